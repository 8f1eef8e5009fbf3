"""A reference for trajectories, with its own uncertainty: two fine solutions that have as little in common as can be.

Each is computed with fixed steps. They are halved until the solution moves by half as much as before or more, which
is round-off, or the time for it is up: one by Dormand-Prince 5, one by Dormand-Prince 8, and where the mechanism has
two formulations in the kernel each in its own. How far they are apart, and how far the check moved at its last halving,
is what the reference is uncertain by.

Where a force or a motion is not smooth, fixed steps hit its kinks anywhere and converge by luck. Two solutions with
error control, whose steps shrink there, take their place if they agree better; where they are farther from those with
fixed steps than these are uncertain, one of the two has missed something. Then that distance is the uncertainty.

Stability alone may ask explicit methods for more steps than there is time for. Then the two are implicit methods that
differ, to tolerances that fall until the time is up.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from time import process_time

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, MbprojError, Problem
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.stiff.fast_forces import steps_for_stability
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import OFF_AXIS, Solution, solve, unseen
from mbproj.studies.store import cached

#: The integrators of the two solutions; the first is the reference unless it is among those compared and the other not.
INTEGRATORS = ("dopri5", "dop853")
#: The reference is uncertain by this multiple of how far it is from the check: both may be off to the same side.
SAFETY = 3.0
#: Tolerance of their projections, below what any mechanism reaches: they go on until the violation no longer falls. A
#: chaotic motion is as wrong as its least violation.
ROUND_OFF = 1e-16
#: Steps that the halving begins with at least.
FEWEST_STEPS = 200
#: Seconds of processor time that each of the two solutions may take.
SECONDS = 10.0
#: Tolerances with error control.
TOLERANCES = (1e-12, 1e-13, 1e-14)
#: The two of stiff mechanisms, and their tolerances: where stability asks an explicit method for so many steps.
IMPLICIT, STIFF_TOLERANCES, STIFF = ("esdirk4", "radau5"), tuple(10.0**-k for k in range(6, 13)), 50_000
#: A solution is fine enough when it moves by less than this part of the mechanism's size.
GOAL = 1e-13
#: Halving goes on while a solution moves by less than this part of what it moved by before.
FALLING = 0.5
#: It does so at more than this part of the times and points.
PART = 0.1


@dataclass(frozen=True, eq=False)
class Reference:
    """Positions (T, k, 3) in m and velocities in m/s of `points` at `times` (T,), and by how much the positions are
    `uncertain` at most up to each time, (T, k) in m; infinite where there is no reference. `method` and `check` say in
    words how the two solutions were computed, `limit` why they are no better: one ended early, or time was up; empty
    where round-off is the reason."""

    points: tuple[str, ...]
    times: Array
    position: Array
    velocity: Array
    uncertainty: Array
    method: str
    check: str
    limit: str = ""

    @property
    def words(self) -> str:
        """What it is, for a reader of errors."""
        largest = float(self.uncertainty[-1].max())
        why = f" ({self.limit})" if self.limit and not np.isfinite(largest) else ""
        return f"reference: {self.method}; checked by {self.check}; uncertain by {largest:.1e} m{why}"

    def at_every(self, stride: int) -> Reference:
        """The reference at every stride-th of its times alone."""
        return replace(
            self,
            times=self.times[::stride],
            position=self.position[::stride],
            velocity=self.velocity[::stride],
            uncertainty=self.uncertainty[::stride],
        )

    def certain_until(self, limit: float) -> float:
        """The last time (s) up to which every point is certain to `limit` (m)."""
        beyond = np.flatnonzero(~(self.uncertainty <= limit).all(axis=1))
        return float(self.times[-1] if not len(beyond) else self.times[max(beyond[0] - 1, 0)])


def reference(
    mechanism: Mechanism, times: Array, compared: Collection[str] = (), seconds: float = SECONDS
) -> Reference:
    """The reference of `mechanism` at `times` (as of `solve`) for a comparison of the integrators `compared`.

    It is kept on disk (`mbproj.studies.store`). Raises InputError where the mechanism cannot be run at all.
    """
    pair = IMPLICIT if _is_stiff(mechanism, times) else INTEGRATORS
    first, second = pair if pair[0] not in compared or pair[1] in compared else pair[::-1]
    what = ("reference", mechanism.identity, times.tolist(), first, seconds, FALLING, PART, TOLERANCES)
    return cached(what, lambda: _computed(mechanism, times, first, second, seconds), (Reference,))


def _is_stiff(mechanism: Mechanism, times: Array) -> bool:
    """Whether explicit methods would need too many steps, as the forces are at the start. What cannot be run is not."""
    setting = Setting(integrator=INTEGRATORS[1], tolerance=TOLERANCES[0])
    try:
        settings = mechanism.settings(setting, float(times[-1]), float(times[1]))
        return steps_for_stability(mechanism.system, mechanism.state, settings) > STIFF
    except MbprojError:
        return False


def _computed(mechanism: Mechanism, times: Array, first: str, second: str, seconds: float) -> Reference:
    """Fixed steps, but where laws have edges in the state, at which steps end with error control alone, and where it is
    stiff."""
    if first in IMPLICIT:
        return _checked(partial(_tight, tolerances=STIFF_TOLERANCES), mechanism, times, first, second, seconds)
    solved = _fine if switches_of(mechanism.system) is None else _tight
    return _checked(solved, mechanism, times, first, second, seconds)


def _checked(
    solved: Callable[..., _Fine], mechanism: Mechanism, times: Array, first: str, second: str, seconds: float
) -> Reference:
    """The reference of two solutions of a kind."""
    fine = solved(mechanism, Setting(integrator=first, projection_tolerance=ROUND_OFF), times, seconds)
    if why := unseen(mechanism, fine.solution):
        raise InputError(Problem(why, hint=OFF_AXIS))
    taken = fine.solution.report.formulation if fine.solution.report else ""
    other = "reduced" if taken == "planar" else "auto"
    setting = Setting(integrator=second, projection_tolerance=ROUND_OFF, formulation=other)
    check = solved(mechanism, setting, times, seconds, instead="auto")
    apart = SAFETY * np.linalg.norm(fine.solution.position - check.solution.position, axis=2) + check.moved
    return Reference(
        points=mechanism.points,
        times=times,
        position=fine.solution.position,
        velocity=fine.solution.velocity,
        uncertainty=running_largest(apart),
        method=_words(fine.solution),
        check=_words(check.solution),
        limit=_limit((fine, check), seconds),
    )


@dataclass(frozen=True, eq=False)
class _Fine:
    """A solution, and by how much its points moved up to each time at the last halving of its steps, (T, k); whether
    there was no time for more."""

    solution: Solution
    moved: Array
    out_of_time: bool = False


def _fine(mechanism: Mechanism, setting: Setting, times: Array, seconds: float, instead: str = "") -> _Fine:
    """Halves the steps until that does not help. Where the formulation is refused, `instead` takes its place."""
    interval, started = float(times[1] - times[0]), process_time()
    per_interval = max(1, -(-FEWEST_STEPS // (len(times) - 1)))
    size = mechanism.system.length
    first = solve(mechanism, replace(setting, step=interval / per_interval), times)
    best = _Fine(first, np.full((len(times), 1), np.inf))
    while True:
        begun, per_interval = process_time(), 2 * per_interval
        finer = solve(mechanism, replace(setting, step=interval / per_interval), times)
        if finer.failure and finer.failure.status == "refused":
            if instead and instead != setting.formulation:
                return _fine(mechanism, replace(setting, formulation=instead), times, seconds)
            raise InputError(finer.failure.cause)
        moved = running_largest(np.linalg.norm(finer.position - best.solution.position, axis=2))
        if not _falls(best.moved, moved):
            return _Fine(best.solution, moved)
        best = _Fine(finer, moved)
        taken = process_time()
        if moved[-1].max() <= GOAL * size:
            return best
        if taken - started + 2.0 * (taken - begun) > seconds:
            return replace(best, out_of_time=True)


def _tight(
    mechanism: Mechanism,
    setting: Setting,
    times: Array,
    seconds: float,
    instead: str = "",
    tolerances: Sequence[float] = TOLERANCES,
) -> _Fine:
    """With error control, at tolerances that fall to what round-off dominates. Where the formulation is refused,
    `instead` takes its place."""
    started, first = process_time(), solve(mechanism, replace(setting, tolerance=tolerances[0]), times)
    best = _Fine(first, np.full((len(times), 1), np.inf))
    if best.solution.failure and best.solution.failure.status == "refused":
        return _tight(mechanism, replace(setting, formulation=instead), times, seconds, tolerances=tolerances)
    for tolerance in tolerances[1:]:
        begun = process_time()
        tighter = solve(mechanism, replace(setting, tolerance=tolerance), times)
        moved = running_largest(np.linalg.norm(tighter.position - best.solution.position, axis=2))
        best, taken = _Fine(tighter, moved), process_time()
        if taken - started + 2.0 * (taken - begun) > seconds:
            return replace(best, out_of_time=tolerance != tolerances[-1])
    return best


def _limit(solutions: Sequence[_Fine], seconds: float) -> str:
    failures = [str(fine.solution.failure) for fine in solutions if fine.solution.failure]
    late = any(fine.out_of_time for fine in solutions)
    return failures[0] if failures else f"{seconds:g} s are too few for a better reference" if late else ""


def _falls(before: Array, now: Array) -> bool:
    """Whether halving the steps still helps at some of the times: a chaotic motion is far off at the end until its
    steps are very fine, and down to round-off at the beginning long before."""
    fallen = (now[1:] <= FALLING * before[1:]) & (now[1:] < np.inf)
    return bool(np.isinf(before[1:]).all() or np.mean(fallen) > PART)


def running_largest(values: Array) -> Array:
    """The largest of `values` (T, ...) up to each time; infinite from the first NaN on."""
    largest: Array = np.maximum.accumulate(np.where(np.isnan(values), np.inf, values), axis=0)
    return largest


def _words(solution: Solution) -> str:
    formulation = solution.report.formulation if solution.report else solution.setting.formulation
    tolerance, step = solution.setting.tolerance, solution.setting.step
    how = f"tolerance {tolerance:g}" if step is None else f"fixed steps of {step:.3g} s"
    return f"{solution.setting.integrator}, {how}, {formulation}"


def error(solution: Solution, reference: Reference) -> Array:
    """Distance of each point from the reference, (T, k) in m; infinite after a failure."""
    distance = np.linalg.norm(solution.position - reference.position, axis=2)
    return np.where(np.isnan(distance), np.inf, distance)
