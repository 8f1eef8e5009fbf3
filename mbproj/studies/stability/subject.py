"""The subject of a stability map, a scene with a setting, and its result at one value of the quantity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, MbprojError, SimulationError
from mbproj.scene.records import Scene
from mbproj.studies.measure.setting import Setting

#: The three states of a point, from best to worst.
HOLDS, DEGRADES, FAILS = "holds", "degrades", "fails"


@dataclass(frozen=True)
class Limits:
    """The limits of the three states. A run holds while joints are open by at most `closed` (the mechanism's lengths,
    rad), and the energy balance is off by at most `energy`. The latter is relative to the largest kinetic energy, |ΔV|
    and work. A run fails where it stops, or exceeds `open` or `lost`; in between it degrades."""

    closed: float = 1e-6
    energy: float = 1e-2
    open: float = 1e-2
    lost: float = 0.1


@dataclass(frozen=True)
class Subject:
    """A scene that is run with a setting until a time (s). With `is_linear` it is not run: its small motions are
    judged."""

    scene: Scene
    setting: Setting
    until: float
    limits: Limits
    is_linear: bool = False


@dataclass(frozen=True)
class StabilityPoint:
    """The result of a run at one value of the quantity. `closure` is the largest opening of a joint (the mechanism's
    lengths, rad), `energy` the largest relative error of the balance; NaN where not computed. `time` (s), `joint` and
    `cause` tell when, where and why the run first exceeded a limit; None and "" where it holds. `ended` is False for a
    run that stopped early."""

    value: float
    state: str
    closure: float
    energy: float
    time: float | None = None
    joint: str | None = None
    cause: str = ""
    ended: bool = True

    def as_json(self) -> dict[str, Any]:
        """The values by name, with None for what is infinite or NaN."""
        values = asdict(self)
        for name in ("closure", "energy"):
            values[name] = values[name] if abs(values[name]) < float("inf") else None
        return values

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> StabilityPoint:
        """Build the point from the values that `as_json` gave."""
        numbers = {name: float("nan") if values[name] is None else values[name] for name in ("closure", "energy")}
        return cls(**{**values, **numbers})


def cause_of(error: MbprojError) -> str:
    """The message of an error that ended a run, without its place and time."""
    if isinstance(error, InputError):
        return error.problems[0].message
    return error.cause if isinstance(error, SimulationError) else str(error)
