"""Arguments of the kernel, good unless changed."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.base.thresholds import of_the_kernel
from mbproj.functions.program import Code, Program
from mbproj.functions.program_set import flatten
from mbproj.kernel import core
from mbproj.kernel.models import by_name, programs
from mbproj.model.channels import NO_CHANNELS, NO_MOTIONS
from mbproj.model.couplings import compile_couplings
from mbproj.motion.steppers.tableau import load_tableau
from mbproj.motion.time_events import kernel_tableau

INF = float("inf")


def numbers(*rows: list[float]) -> Any:
    """Rows of parameters, likewise."""
    most = max(count for *_, count in core().primitives())
    return np.array([[*row, *[0.0] * (most - len(row))] for row in rows], dtype=float).reshape(-1, most)


def primitives(**changes: Any) -> dict[str, Any]:
    """Two bodies on a ball, and a vector of the first normal to one of the second: good unless changed."""
    good: dict[str, Any] = {
        "body": np.array([0, 1, 0, 1]),
        "is_point": np.array([1, 1, 0, 0]),
        "local": np.array([[1.0, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 1, 0]]),
        "kind": np.array([0, 1]),
        "slot_count": np.array([2, 2]),
        "first_slot": np.array([0, 2]),
        "parameters": numbers([], []),
        "offset": np.zeros(2),
        "weight": np.ones(2),
        "joins": np.zeros(2, bool),
        "follows": [None, None],
        "owner": np.zeros(2, int),
    }
    return good | changes


def no_primitives() -> dict[str, Any]:
    nothing = {
        name: np.zeros(0, int) for name in ("kind", "slot_count", "first_slot", "offset", "weight", "joins", "owner")
    }
    return primitives(**nothing, parameters=numbers(), follows=[])


def model(**changes: Any) -> Any:
    good: dict[str, Any] = {
        "thresholds": core().Thresholds(**of_the_kernel()),
        "mass": np.ones(2),
        "inertia": np.tile(np.eye(3), (2, 1, 1)),
        "gravity": np.zeros(3),
        "constraints": primitives(),
        "row_scale": np.ones(4),
        "coordinates": no_primitives(),
        "length": 1.0,
        "layout": blocks(),
        "programs": functions(),
        "first_rate": 0,
        "channels": by_name(NO_CHANNELS),
        "switches": np.zeros((0, 2), int),
        "motions": by_name(NO_MOTIONS),
        "couplings": by_name(compile_couplings([], [])),
        "followers": np.zeros((0, 4), int),
    }
    return core().SpaceModel(**good | changes)


def functions(*codes: Code, variables: int = 3) -> dict[str, Any]:
    """Programs of so many variables."""
    return programs(flatten([Program(code) for code in codes]), variables)


def block(name: str, scale: list[float], start: list[float] | None = None) -> dict[str, Any]:
    return {"name": name, "scale": scale, "start": start}


def blocks(**sizes: int) -> list[dict[str, Any]]:
    """The layout of y, with so many numbers beside the bodies' states."""
    beside = [block(name, [INF] * sizes.get(name, 0)) for name in ("states", "quadratures", "followed")]
    return [block("bodies", [1.0] * 26), *beside]


def state() -> np.ndarray:
    """The two bodies end to end along x, turning about z."""
    y = np.zeros((2, 13))
    y[:, 0], y[:, 3], y[:, 12] = [0.0, 2.0], 1.0, 1.0
    y[1, 8] = 2.0
    return y


def projection(**changes: Any) -> Any:
    made = core().Projection(core().Correction.mass)
    for name, value in changes.items():
        setattr(made, name, value)
    return made


def run(y: np.ndarray | None = None, turns: np.ndarray | None = None, **changes: Any) -> Any:
    steps = changes.get("steps", core().Steps.fixed(0.0, 1.0, 0.1, 10, 1))
    made = core().Run(
        changes.get("model") or model(),
        changes.get("tableau") or kernel_tableau(core(), load_tableau("rk4"), kinematic=False),
        changes.get("projection") or projection(),
        steps,
        state().ravel() if y is None else y,
        np.zeros(0, int) if turns is None else turns,
    )
    made.advance(100, 10.0)
    return made.outcome


def tableau(**changes: np.ndarray) -> Any:
    """RK4, with some parts changed."""
    return core().Tableau(tableau=by_name(load_tableau("rk4")) | changes, kinematic=False)
