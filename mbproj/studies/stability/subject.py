"""What a map is made of: a scene with a setting, and what became of it at one value of what is varied."""

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
    """A run holds while joints are open by no more than `closed` (the mechanism's lengths, rad). The energy balance may
    be off by no more than `energy`, a part of the largest kinetic energy, |ΔV| and work; it fails where it stops, or is
    beyond `open` or `lost`; in between it degrades."""

    closed: float = 1e-6
    energy: float = 1e-2
    open: float = 1e-2
    lost: float = 0.1


@dataclass(frozen=True)
class Subject:
    """A scene, run with a setting until a time in s; or not run, as its small motions are looked at."""

    scene: Scene
    setting: Setting
    until: float
    limits: Limits
    is_linear: bool = False


@dataclass(frozen=True)
class Point:
    """What a run did at a value of what is varied: its state; how far joints were open at most (in the mechanism's
    lengths, rad) and the energy balance off (relative), NaN where nothing was computed; when it first was not as it
    should be (s), at which joint, and why, None and "" where it held; whether it `ended`, or stopped before."""

    value: float
    state: str
    closure: float
    energy: float
    time: float | None = None
    joint: str | None = None
    cause: str = ""
    ended: bool = True

    def as_json(self) -> dict[str, Any]:
        """By name; None for what is not a number."""
        values = asdict(self)
        for name in ("closure", "energy"):
            values[name] = values[name] if abs(values[name]) < float("inf") else None
        return values

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Point:
        """What `as_json` gave."""
        numbers = {name: float("nan") if values[name] is None else values[name] for name in ("closure", "energy")}
        return cls(**{**values, **numbers})


def cause_of(error: MbprojError) -> str:
    """Why a run did not get to its end, without its place and time."""
    if isinstance(error, InputError):
        return error.problems[0].message
    return error.cause if isinstance(error, SimulationError) else str(error)
