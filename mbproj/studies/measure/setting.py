"""A setting: all that decides the accuracy and the cost of a run, apart from the mechanism itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, fields
from typing import Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import SETTINGS, Settings, option_name
from mbproj.scene.fields.reading import Reading
from mbproj.scene.settings import Merged, check_settings, read_options, settings_of, takes
from mbproj.scene.text.nodes import plain

#: A threshold below every violation of a run: it switches off the scene's own one.
NO_THRESHOLD = 1e-50


def _usual(name: str) -> Any:
    """The default of a setting."""
    return SETTINGS[name].usual


@dataclass(frozen=True)
class Setting:
    """A way to run a scene, in the names of the options of `mbproj run`. Either `step` (s) or `tolerance` is given. A
    value of None means the program's default, or an option that does not apply to the method."""

    projection: str = _usual("projection")
    integrator: str = _usual("integrator")
    step: float | None = _usual("step")
    tolerance: float | None = _usual("tolerance")
    every: int = _usual("every")
    threshold: float | None = _usual("threshold")
    formulation: str = _usual("formulation")
    acceleration: str = _usual("acceleration")
    projection_tolerance: float | None = _usual("projection_tolerance")
    projection_test: str = _usual("projection_test")
    project_position: bool = _usual("project_position")
    project_velocity: bool = _usual("project_velocity")
    projection_fallback: str = _usual("projection_fallback")
    energy_row: bool = _usual("energy_row")
    momentum_row: bool = _usual("momentum_row")
    max_iterations: int = _usual("max_iterations")
    alpha: float | None = _usual("alpha")
    gains: tuple[float, float] | None = _usual("gains")

    def __new__(cls, *values: object, **named: object) -> Setting:
        """Raises InputError for an unknown name."""
        names = [each.name for each in fields(cls)]
        wrong = [name for name in named if name not in names]
        if wrong:
            raise InputError([Problem(f"a setting has no '{name}'", hint=choose_from(name, names)) for name in wrong])
        return super().__new__(cls)

    def __post_init__(self) -> None:
        """Turn NumPy's numbers into Python's, so that they can be written as JSON."""
        for each in fields(self):
            value = plain(getattr(self, each.name))
            object.__setattr__(self, each.name, tuple(value) if isinstance(value, list) else value)

    @classmethod
    def of(cls, settings: Settings) -> Setting:
        """The setting that a scene's settings contain, without what the mechanism and the samples follow from."""
        return cls(**{each.name: SETTINGS[each.name].of(settings) for each in fields(cls)})

    def projected_by(self, projection: str) -> Setting:
        """Return this setting where `projection` is its own method. For another, return that method's default setting,
        which keeps `acceleration`. It keeps the rows of energy and momentum too where the method corrects."""
        if projection == self.projection:
            return self
        corrects = projection in PROJECTIONS and PROJECTIONS[projection].corrects
        energy, momentum = self.energy_row and corrects, self.momentum_row and corrects
        return Setting(projection, acceleration=self.acceleration, energy_row=energy, momentum_row=momentum)

    def options(self, over: Settings | None = None) -> dict[str, Any]:
        """The options that differ from `over` (by default the program's defaults), and always projection, integrator,
        and step or tolerance. `read_scene` takes them as `simulation`."""
        base = asdict(Setting.of(over or Settings()))
        taking = self.projection in PROJECTIONS
        taken = {name: value for name, value in asdict(self).items() if not taking or takes(self.projection, name)}
        named = ("integrator", "tolerance" if self.step is None else "step", "projection")
        options = {name: taken[name] for name in named}
        options |= {name: value for name, value in taken.items() if value is not None and value != base[name]}
        if self.threshold is None and base["threshold"] is not None and "threshold" in taken:
            options["threshold"] = NO_THRESHOLD
        return options

    def command_line(self, over: Settings | None = None) -> str:
        """The options of `mbproj run` as one string, e.g. "--integrator dop853 --tolerance 1e-8 --projection gpopm".
        `over` are the settings of the scene to be run."""
        return " ".join(f"{option_name(name)} {as_text(value)}" for name, value in self.options(over).items())

    @property
    def label(self) -> str:
        """A few words for a legend, e.g. "gpopm, rk4, h = 0.01 s, every 5 steps"."""
        size = f"tol {as_text(self.tolerance)}" if self.step is None else f"h = {self.step:.4g} s"
        parts = [self.projection, self.integrator, size]
        if self.every != 1:
            parts.append(f"every {self.every} steps")
        if self.threshold is not None:
            parts.append(f"threshold {as_text(self.threshold)}")
        if self.projection_test != "violation":
            parts.append(f"{self.projection_test}'s test")
        parts += [] if self.alpha is None else [f"α = {self.alpha:.6g}"]
        parts += [] if self.gains is None else [f"gains {self.gains[0]:.6g} {self.gains[1]:.6g} 1/s"]
        parts += [words for on, words in ((self.energy_row, "energy row"), (self.momentum_row, "momentum rows")) if on]
        return ", ".join(parts)

    @property
    def schedule(self) -> str:
        """The projection and when it is applied, e.g. "gpopm every 5 steps"."""
        text = self.projection + " with energy row" * self.energy_row
        if self.every != 1:
            text += f" every {self.every} steps"
        return text if self.threshold is None else f"{text} above {shortest(self.threshold)}"

    def settings(self, duration: float, output_step: float) -> Settings:
        """The settings of a run over `duration` with a sample every `output_step`, both in s.

        Raises InputError where the values do not fit each other, or `output_step` is no multiple of the step.
        """
        reading = Reading()
        options = {**self.options(), "duration": duration, "output_step": output_step}
        values = read_options(options, reading) or {}
        problems = reading.problems or list(check_settings(Merged(values, values, reading.places)))
        if problems:
            raise InputError(problems)
        return settings_of(values)


def only_full(projections: Iterable[str]) -> list[str]:
    """The methods that exist only in the full formulation."""
    return [name for name in projections if name in PROJECTIONS and not PROJECTIONS[name].compiled]


def as_text(value: Any) -> str:
    """A value as text from which the command line reads exactly the same value."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple | list):
        return ",".join(map(as_text, value))
    return shortest(value) if isinstance(value, float) else str(value)


def shortest(value: float) -> str:
    """The shortest decimal from which exactly this number is read: 1e-8, not 1e-08."""
    mantissa, exponent, power = repr(value).partition("e")
    return f"{mantissa}e{int(power)}" if exponent else mantissa
