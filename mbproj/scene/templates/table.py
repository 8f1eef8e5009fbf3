"""The templates of `mbproj new`, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.scene.templates import bars, machines
from mbproj.scene.templates.values import OPTIONS, Values, values_of


@dataclass(frozen=True)
class Template:
    """A template: a summary, its options with their defaults, and the function that yields the lines of its scene.
    `spatial` ones come in a plane or in space."""

    summary: str
    defaults: Mapping[str, str]
    lines: Callable[..., Iterator[str]]
    spatial: bool = False


TEMPLATES: Mapping[str, Template] = {
    "pendulum": Template("a bar on a pin, with its exact period", bars.PENDULUM, bars.pendulum),
    "chain": Template("bars in a row", bars.CHAIN, bars.chain, spatial=True),
    "ladder": Template("parallelograms one below the other", bars.LADDER, bars.ladder),
    "tree": Template("two bars on the end of each", bars.TREE, bars.tree, spatial=True),
    "star": Template("bars on the rim of a hub that turns", bars.STAR, bars.star),
    "slider-crank": Template("driven, in a plane", machines.SLIDER_CRANK, machines.slider_crank),
    "four-bar": Template("a driven crank-rocker", machines.FOUR_BAR, machines.four_bar),
    "cam": Template("a cam, its roller follower and a spring", machines.CAM, machines.cam),
    "geneva": Template("a pin that turns a slotted wheel step by step", machines.GENEVA, machines.geneva),
    "hoist": Template("a drum, a rope and a moving block", machines.HOIST, machines.hoist),
    "winch": Template("a drum and its load, coupled by a row", machines.WINCH, machines.winch),
}


def scene_text(name: str, options: Mapping[str, str], spatial: bool = False) -> str:
    """The text of the scene file of the template `name`; `options` are numbers by option, as texts with their units.

    Raises InputError for an option that the template does not have, a number that its option does not take, or lengths
    that make no mechanism.
    """
    template = TEMPLATES[name]
    if spatial and not template.spatial:
        able = ", ".join(other for other, entry in TEMPLATES.items() if entry.spatial)
        raise InputError(Problem(f"a {name} has no --spatial", Place("--spatial"), f"these have: {able}"))
    values: Values = values_of(options, template.defaults, name)
    lines = template.lines(values, spatial) if template.spatial else template.lines(values)
    return "\n".join(lines) + "\n"


__all__ = ["OPTIONS", "TEMPLATES", "Template", "scene_text"]
