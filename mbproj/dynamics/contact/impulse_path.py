"""The impact of one rough stop, followed along its normal impulse p (Routh 1905; Keller 1986; Stronge 1990).

With u = (u_n, u_t) the rates along the normal and the tangents, du/dp = B (1, f). Friction f slides, f = -μ u_t/|u_t|,
or sticks, B_tt f = -B_tn with |f| <= μ. Until u_n = 0 the stop absorbs the energy W = -∫ u_n dp, and it returns e² W:
this energetic law creates no energy, because friction opposes the sliding all along the way.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

#: The most pieces of sliding and sticking, and the number of directions in which a start of sliding is searched.
MOST_PIECES, DIRECTIONS = 8, 360


@dataclass(frozen=True, eq=False)
class ImpulseResult:
    """The result of the path: the impulses along normal and tangents (1 + k,), and the work of each, J (1 + k,)."""

    impulse: Array
    work: Array


def followed(B: Array, u: Array, coefficient: float, restitution: float) -> ImpulseResult | None:
    """Return the impact at rates u (1 + k,) before it, of k tangents, with B (1 + k, 1 + k); None where the gap never
    stops closing."""
    speed, mobility = float(np.linalg.norm(u)), float(B[0, 0])
    path = _Path(B / mobility, coefficient)
    y = path.until(lambda y: float(y[0]), np.concatenate([u / speed, np.zeros(2 * len(u))]))
    if y is not None and restitution > 0.0:
        given_back = (1.0 - restitution**2) * float(y[path.work][0])
        y = path.until(lambda y: float(y[path.work][0]) - given_back, y)
    if y is None:
        return None
    return ImpulseResult(y[path.impulse] * speed / mobility, y[path.work] * speed**2 / mobility)


class _Path:
    """The path y = (rates, impulses, works) over p, with B[0, 0] = 1 and rates of size 1."""

    def __init__(self, B: Array, coefficient: float) -> None:
        self.B, self.coefficient, size = B, coefficient, len(B)
        self.rate, self.impulse, self.work = (slice(k * size, (k + 1) * size) for k in range(3))
        self.sticking = np.asarray(-np.linalg.lstsq(B[1:, 1:], B[1:, 0], rcond=THRESHOLDS.no_push)[0], dtype=float)

    def until(self, goal: Callable[[Array], float], y: Array) -> Array | None:
        """Return y where the goal rises through zero; None where it does not."""
        for _ in range(MOST_PIECES):
            slides = np.linalg.norm(y[self.rate][1:]) > THRESHOLDS.stop_rests
            if not slides and np.linalg.norm(self.sticking) > self.coefficient:
                y = y.copy()
                y[self.rate][1:] = 2.0 * THRESHOLDS.stop_rests * self._begins()
                slides = np.True_
            y, arrived = self._piece(goal, y, self._sliding if slides else lambda _: self.sticking)
            if arrived:
                return y
        return None

    def _piece(
        self, goal: Callable[[Array], float], y: Array, friction: Callable[[Array], Array]
    ) -> tuple[Array, bool]:
        """Return y at the end of sliding or sticking, and whether the goal is reached there."""
        from scipy.integrate import solve_ivp

        def slope(p: float, y: Array) -> Array:
            f = np.concatenate([[1.0], friction(y[self.rate][1:])])
            return np.concatenate([self.B @ f, f, y[self.rate] * f])

        def reached(p: float, y: Array) -> float:
            return goal(y)

        def stands(p: float, y: Array) -> float:
            return float(np.linalg.norm(y[self.rate][1:]) - THRESHOLDS.stop_rests)

        for event, way in ((reached, 1.0), (stands, -1.0)):
            event.terminal, event.direction = True, way  # type: ignore[attr-defined]
        events = (reached, stands) if friction == self._sliding else (reached,)
        to = THRESHOLDS.rounding
        solution = solve_ivp(slope, (0.0, np.inf), y, "DOP853", rtol=to, atol=0.01 * to, events=events)
        end, arrived = np.array(solution.y[:, -1]), bool(len(solution.t_events[0]))
        if not arrived:  # the rest of the sliding stops at once
            left = -np.linalg.lstsq(self.B[1:, 1:], end[self.rate][1:], rcond=THRESHOLDS.no_push)[0]
            end[self.impulse][1:] += left
            end[self.rate] += self.B[:, 1:] @ left
        return end, arrived

    def _sliding(self, rate: Array) -> Array:
        return -self.coefficient * rate / np.linalg.norm(rate)

    def _begins(self) -> Array:
        """Return the direction of incipient sliding where sticking is impossible: the rate of sliding grows along
        it."""
        if len(self.B) == 2:
            return np.sign(self.B[1:, 0])
        angles = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS + 1)
        across = np.array([self._across(angle) for angle in angles])
        from scipy.optimize import brentq

        for k in np.flatnonzero((across[:-1] <= 0.0) != (across[1:] <= 0.0)):
            angle = brentq(self._across, angles[k], angles[k + 1])
            way = np.array([np.cos(angle), np.sin(angle)])
            if way @ (self.B[1:, 0] - self.coefficient * self.B[1:, 1:] @ way) > 0.0:
                return way
        return np.array([1.0, 0.0])

    def _across(self, angle: float) -> float:
        """Return the component, across a direction, of the rate's change while it slides along the direction."""
        way = np.array([np.cos(angle), np.sin(angle)])
        change = self.B[1:, 0] - self.coefficient * self.B[1:, 1:] @ way
        return float(way[0] * change[1] - way[1] * change[0])
