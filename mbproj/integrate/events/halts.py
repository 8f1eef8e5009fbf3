"""What halts a run: a stop of the mechanism that a step has met, and where the run stands then."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, Flags, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.gaps import gap_rates, gaps
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.model.system import System


class WatchedGap(NamedTuple):
    """What halts a run: `sign` (s - bound) of a stop below -`slack`, with the stop's side as the sign where its gap
    closes, and the other one where it opens."""

    stop: int
    sign: float
    slack: float


class WatchedRow(NamedTuple):
    """What halts a run: `sign` λ of a row of C, after the norm rows, below -`slack`."""

    row: int
    sign: float
    slack: float


@dataclass(frozen=True)
class Watched:
    """All that halts a run."""

    gaps: tuple[WatchedGap, ...] = ()
    rows: tuple[WatchedRow, ...] = ()


@dataclass(frozen=True, eq=False)
class HaltedAt:
    """Where a run has halted, the size of the step that it has not made, s, and the integrals of work and dissipation
    there (2,), in J."""

    state: State
    h: float
    work: Array


class Halted(Exception):
    """A run has come to a stop of the mechanism."""

    def __init__(self, standing: HaltedAt) -> None:
        super().__init__(f"halted at t = {standing.state.t:.6g} s")
        self.standing = standing


def watched_gaps(system: System, watched: Watched, state: State) -> tuple[Array, Array]:
    """sign (s - bound) of what is watched, and its rate, (k,) each."""
    stops, pose = system.stops, pose_of(state.q)
    assert stops is not None
    which = [each.stop for each in watched.gaps]
    sign = np.array([each.sign for each in watched.gaps]) * stops.side[which]
    gap, rate = gaps(stops, pose, state.turns), gap_rates(stops, pose, twist_of(pose, state.v))
    return sign * gap[which], sign * rate[which]


def may_pass(value: Numbers, rate: Numbers, value_after: Numbers, rate_after: Numbers, h: float) -> Flags:
    """Whether gaps that close as fast as at the start of a step, and open as fast as at its end, are passed on the way:
    a body may have gone through another one."""
    return np.asarray((value > 0.0) & (value + h * rate < 0.0) & (value_after - h * rate_after < 0.0))


def least(first: tuple[Array, Array], last: tuple[Array, Array], h: float) -> Array:
    """The least values (k,) within a step, on the cubics through both ends (value, rate); less than any where one may
    have been passed."""
    theta = np.array([lowest(*ends, h) for ends in zip(*first, *last, strict=True)])
    value = [cubic(*ends, h, at) for ends, at in zip(zip(*first, *last, strict=True), theta, strict=True)]
    found = np.minimum(np.minimum(first[0], last[0]), np.array(value, dtype=float).reshape(first[0].shape))
    return np.where(may_pass(*first, *last, h), -np.inf, found)


def lowest(value: float, rate: float, value_after: float, rate_after: float, h: float) -> float:
    """The part of a step at which its cubic has a minimum inside; 0 where it has none."""
    a, b, change = h * rate, h * rate_after, value_after - value
    c3, c2 = a + b - 2.0 * change, 3.0 * change - 2.0 * a - b
    root = c2 * c2 - 3.0 * c3 * a
    if not (a < 0.0 < root and c2 + np.sqrt(root) > 0.0):
        return 0.0
    theta = -a / (c2 + np.sqrt(root))
    return float(theta) if 0.0 < theta < 1.0 else 0.0


def cubic(value: float, rate: float, value_after: float, rate_after: float, h: float, theta: float) -> float:
    """The cubic through both ends of a step, at the part θ of it."""
    a, b, change = h * rate, h * rate_after, value_after - value
    return value + theta * (a + theta * (3.0 * change - 2.0 * a - b + theta * (a + b - 2.0 * change)))
