"""The numbers of a template, by option: as written, and in SI units."""

from __future__ import annotations

from collections.abc import Mapping

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.scene.fields.fields import Field
from mbproj.scene.fields.quantities import Integer, Number, given_number

#: The most links, loops or slots of a template: nobody could read a longer scene.
MOST = 5000


@dataclass(frozen=True)
class TemplateOption:
    """An option of `mbproj new`: the field that reads its text, and its help."""

    field: Field[float]
    help: str


LENGTH, MASS = Number("m", above=0.0), Number("kg", above=0.0)
OPTIONS: Mapping[str, TemplateOption] = {
    "links": TemplateOption(Integer(minimum=1), "Number of bars."),
    "loops": TemplateOption(Integer(minimum=1), "Number of loops, one below the other."),
    "slots": TemplateOption(Integer(minimum=3), "Number of slots of the wheel."),
    "length": TemplateOption(LENGTH, "Length of each bar; how far the load falls; distance of the axles."),
    "mass": TemplateOption(
        MASS, "Mass of each bar; of the slider, the coupler, the follower, the load, or the wheels."
    ),
    "radius": TemplateOption(LENGTH, "Radius of the drum, or of the base circle of the cam."),
    "angle": TemplateOption(Number("rad"), "Angle of the bars at the start, from hanging straight down."),
    "crank": TemplateOption(LENGTH, "Length of the crank."),
    "rod": TemplateOption(LENGTH, "Length of the connecting rod."),
    "coupler": TemplateOption(LENGTH, "Length of the coupler."),
    "rocker": TemplateOption(LENGTH, "Length of the rocker."),
    "frame": TemplateOption(LENGTH, "Distance of the pivots of crank and rocker."),
    "speed": TemplateOption(Number("rad/s", above=0.0), "Speed of the crank, the hub, the cam or the driver."),
}


@dataclass(frozen=True)
class Values:
    """Numbers by option: `text` as written, with units, and `number` in SI units."""

    text: Mapping[str, str]
    number: Mapping[str, float]

    def count(self, option: str) -> int:
        """The value of an option that is a whole number."""
        return int(self.number[option])

    def parameters(self, *options: str) -> list[str]:
        """The lines of these options for the block `parameters` of the scene."""
        return [f"  {option}: {self.text[option]}" for option in options]


def values_of(options: Mapping[str, str], defaults: Mapping[str, str], what: str) -> Values:
    """Read the values of a template called `what`; an option that is not in `options` has its default. Raises
    InputError for an option that the template does not have, or a number that cannot be read."""
    problems = []
    for option in options:
        if option not in defaults:
            takes = ", ".join(f"--{other}" for other in defaults)
            problems.append(Problem(f"a {what} has no --{option}", Place(f"--{option}"), f"it takes {takes}"))
    if problems:
        raise InputError(problems)
    text = {option: " ".join(str(options.get(option, default)).split()) for option, default in defaults.items()}
    number: dict[str, float] = {}
    for option, value in text.items():
        try:
            number[option] = given_number(value, f"--{option}", OPTIONS[option].field)
        except InputError as error:
            problems += error.problems
    for option in ("links", "loops", "slots"):
        if number.get(option, 0) > MOST:
            problems.append(refused(option, f"is at most {MOST}, found {number[option]:g}", "give fewer"))
    if problems:
        raise InputError(problems)
    return Values(text, number)


def refused(option: str, why: str, hint: str) -> Problem:
    """The problem of an option whose number makes no mechanism."""
    return Problem(f"'{option}' {why}", Place(f"--{option}"), hint)
