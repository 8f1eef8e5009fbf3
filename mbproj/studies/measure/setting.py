"""A setting: all that decides how accurate a run is and what it costs, apart from the mechanism itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, fields
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.registry import PROJECTIONS
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import Settings
from mbproj.scene.settings import Merged, check_settings, option_name, read_options, settings_of, takes
from mbproj.scene.text.nodes import plain
from mbproj.scene.text.suggestions import choose_from

#: Below every violation that a run can have: a threshold for a scene whose own one is to have no effect.
NO_THRESHOLD = 1e-50


@dataclass(frozen=True)
class Setting:
    """How to run a scene, by the names of the options of `mbproj run`. Either `step` (s) or `tolerance` is given; what
    is None has the program's default, or does not apply to the method."""

    projection: str = "gpopm"
    integrator: str = "rk4"
    step: float | None = None
    tolerance: float | None = None
    every: int = 1
    threshold: float | None = None
    formulation: str = "auto"
    acceleration: str = "bordered"
    projection_tolerance: float | None = None
    projection_test: str = "violation"
    project_position: bool = True
    project_velocity: bool = True
    projection_fallback: str = "none"
    energy_row: bool = False
    momentum_row: bool = False
    max_iterations: int = 25
    alpha: float | None = None
    gains: tuple[float, float] | None = None

    def __new__(cls, *values: object, **named: object) -> Setting:
        """Raises InputError for a name that is none of a setting."""
        names = [each.name for each in fields(cls)]
        wrong = [name for name in named if name not in names]
        if wrong:
            raise InputError([Problem(f"a setting has no '{name}'", hint=choose_from(name, names)) for name in wrong])
        return super().__new__(cls)

    def __post_init__(self) -> None:
        """Numbers of NumPy become plain ones, so that they can be written."""
        for each in fields(self):
            value = plain(getattr(self, each.name))
            object.__setattr__(self, each.name, tuple(value) if isinstance(value, list) else value)

    @classmethod
    def of(cls, settings: Settings) -> Setting:
        """That of a scene's settings; the duration and what is recorded are not part of it."""
        inner = settings.projection
        return cls(
            projection=inner.method,
            integrator=settings.integrator,
            step=settings.step,
            tolerance=settings.tolerance,
            every=inner.every,
            threshold=inner.threshold,
            formulation=settings.formulation,
            acceleration=settings.acceleration,
            projection_tolerance=inner.tolerance,
            projection_test=inner.test,
            project_position=inner.position,
            project_velocity=inner.velocity,
            projection_fallback=inner.fallback,
            energy_row=inner.energy,
            momentum_row=inner.momentum,
            max_iterations=inner.max_iterations,
            alpha=inner.alpha,
            gains=inner.gains,
        )

    def projected_by(self, projection: str) -> Setting:
        """The setting with this projection, and of its own what belongs to every method; all of it where the method is
        its own."""
        if projection == self.projection:
            return self
        corrects = projection in PROJECTIONS and PROJECTIONS[projection].corrects
        energy, momentum = self.energy_row and corrects, self.momentum_row and corrects
        return Setting(projection, acceleration=self.acceleration, energy_row=energy, momentum_row=momentum)

    def options(self, over: Settings | None = None) -> dict[str, Any]:
        """What to ask for on top of `over` (the program's defaults): projection, integrator, step or tolerance, and
        whatever else differs. `read_scene` takes it as `simulation`."""
        base = asdict(Setting.of(over or Settings()))
        own = {name: value for name, value in asdict(self).items() if self._has(name)}
        named = ("integrator", "tolerance" if self.step is None else "step", "projection")
        found = {name: own[name] for name in named}
        found |= {name: value for name, value in own.items() if value is not None and value != base[name]}
        if self.threshold is None and base["threshold"] is not None and "threshold" in own:
            found["threshold"] = NO_THRESHOLD
        return found

    def command_line(self, over: Settings | None = None) -> str:
        """The options of `mbproj run`, e.g. "--integrator dop853 --tolerance 1e-8 --projection gpopm"; `over` are the
        settings of the scene that they are for."""
        return " ".join(f"{option_name(name)} {_written(value)}" for name, value in self.options(over).items())

    @property
    def label(self) -> str:
        """A few words for a legend, e.g. "gpopm, rk4, h = 0.01 s, every 5 steps"."""
        size = f"tol {_written(self.tolerance)}" if self.step is None else f"h = {self.step:.4g} s"
        parts = [self.projection, self.integrator, size]
        if self.every != 1:
            parts.append(f"every {self.every} steps")
        if self.threshold is not None:
            parts.append(f"threshold {_written(self.threshold)}")
        if self.projection_test != "violation":
            parts.append(f"{self.projection_test}'s test")
        parts += [words for on, words in ((self.energy_row, "energy row"), (self.momentum_row, "momentum rows")) if on]
        return ", ".join(parts)

    def settings(self, duration: float, output_step: float) -> Settings:
        """The settings of a run over `duration` with a sample every `output_step`, both in s.

        Raises InputError where the values do not fit each other, or `output_step` is no multiple of the step.
        """
        reading = Reading()
        given = {**self.options(), "duration": duration, "output_step": output_step}
        values = read_options(given, reading) or {}
        problems = reading.problems or list(check_settings(Merged(values, frozenset(values), reading.places)))
        if problems:
            raise InputError(problems)
        return settings_of(values)

    def _has(self, name: str) -> bool:
        """Whether this setting's method has that option."""
        return name not in _OF_METHODS or (self.projection in PROJECTIONS and takes(self.projection, _OF_METHODS[name]))


#: Options that only some methods have, with their keys in the scene's `projection`.
_OF_METHODS = {
    field.name: {
        "projection_tolerance": "tolerance",
        "projection_test": "test",
        "project_position": "position",
        "project_velocity": "velocity",
        "projection_fallback": "fallback",
        "energy_row": "energy",
        "momentum_row": "momentum",
    }.get(field.name, field.name)
    for field in fields(Setting)
    if field.name not in ("projection", "integrator", "step", "tolerance", "formulation", "acceleration")
}


def only_full(projections: Iterable[str]) -> list[str]:
    """Those of the methods that exist in the full formulation alone."""
    return [name for name in projections if name in PROJECTIONS and not PROJECTIONS[name].compiled]


def _written(value: Any) -> str:
    """A value as the command line reads it back to the last bit."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple | list):
        return ",".join(map(_written, value))
    return shortest(value) if isinstance(value, float) else str(value)


def shortest(value: float) -> str:
    """The shortest decimal that reads back as this number: 1e-8, not 1e-08."""
    mantissa, exponent, power = repr(value).partition("e")
    return f"{mantissa}e{int(power)}" if exponent else mantissa
