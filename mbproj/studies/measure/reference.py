"""A reference for trajectories, with its own uncertainty: two fine solutions, computed as differently as possible.

One solution is by Dormand-Prince 5, the other by Dormand-Prince 8, each in a formulation of its own where the kernel
has two. Both have fixed steps. These are halved until round-off keeps the change of the solution from falling by half,
or the time is up. The uncertainty follows from the distance of the two and from the change of the check at its last
halving.

Where laws have edges in the state, only error control ends steps at them. There both solutions have error control, with
tolerances down to round-off.

Where stability would ask explicit methods for too many steps, the two are different implicit methods. Their tolerances
fall until the time is up.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from time import process_time

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import brief, dataclass
from mbproj.errors import InputError, MbprojError, Problem
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.stiff.fast_forces import steps_for_stability
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import OFF_AXIS, Solution, solve, unseen
from mbproj.studies.store import cached

#: The integrators of the two solutions. The first is the reference; the second is, where only the first is among those
#: compared.
INTEGRATORS = ("dopri5", "dop853")
#: The uncertainty is this multiple of the distance from the check, because both solutions may err to the same side.
SAFETY = 3.0
#: Tolerance of the projections of both, below what any mechanism reaches: they iterate until the violation falls no
#: more. In a chaotic motion the smallest violation grows.
ROUND_OFF = 1e-16
#: The fewest steps that the halving begins with.
FEWEST_STEPS = 200
#: Seconds of processor time that each of the two solutions may take.
SECONDS = 10.0
#: Tolerances of solutions with error control.
TOLERANCES = (1e-12, 1e-13, 1e-14)
#: The integrators and tolerances for stiff mechanisms: those for which stability asks explicit methods for more than
#: `STIFF` steps.
IMPLICIT, STIFF_TOLERANCES, STIFF = ("esdirk4", "radau5"), tuple(10.0**-k for k in range(6, 13)), 50_000
#: A solution is fine enough when a halving moves it by less than this part of the mechanism's size.
GOAL = 1e-13
#: Halving helps where it moves a solution by less than this part of the movement at the halving before.
FALLING = 0.5
#: Halving goes on while it helps at more than this part of the times and points.
PART = 0.1


@dataclass(frozen=True, eq=False)
class Reference:
    """Positions (T, k, 3) in m and velocities in m/s of `points` at `times` (T,), with a bound on their error.

    `uncertainty` (T, k), m, bounds the error of the positions up to each time; it is infinite where there is no
    reference. `method` and `check` tell how the two solutions were computed. `limit` tells why they are no better: one
    ended early, or time was up. It is empty where round-off is the reason."""

    points: tuple[str, ...]
    times: Array
    position: Array
    velocity: Array
    uncertainty: Array
    method: str
    check: str
    limit: str = ""

    __repr__ = brief

    @property
    def words(self) -> str:
        """A line that tells how the reference was computed and how uncertain it is."""
        largest = float(self.uncertainty[-1].max())
        why = f" ({self.limit})" if self.limit and not np.isfinite(largest) else ""
        return f"reference: {self.method}; checked by {self.check}; uncertain by {largest:.1e} m{why}"

    def at_every(self, stride: int) -> Reference:
        """The reference at every `stride`-th of its times."""
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
    """The reference of `mechanism` at `times` (evenly spaced, as `solve` takes them), to compare the integrators
    `compared`.

    It is kept on disk (`mbproj.studies.store`). Raises InputError where the mechanism cannot be run at all.
    """
    pair = IMPLICIT if _is_stiff(mechanism, times) else INTEGRATORS
    first, second = pair if pair[0] not in compared or pair[1] in compared else pair[::-1]
    what = ("reference", mechanism.identity, times.tolist(), first, seconds, FALLING, PART, TOLERANCES)
    return cached(what, lambda: _computed(mechanism, times, first, second, seconds), (Reference,))


def _is_stiff(mechanism: Mechanism, times: Array) -> bool:
    """Whether explicit methods would need too many steps, judged by the forces at the start. False for what cannot be
    run."""
    setting = Setting(integrator=INTEGRATORS[1], tolerance=TOLERANCES[0])
    try:
        settings = mechanism.settings(setting, float(times[-1]), float(times[1]))
        return steps_for_stability(mechanism.system, mechanism.state, settings) > STIFF
    except MbprojError:
        return False


def _computed(mechanism: Mechanism, times: Array, first: str, second: str, seconds: float) -> Reference:
    """Compute the reference with fixed steps. Where laws have edges in the state, or the mechanism is stiff, compute it
    with error control."""
    if first in IMPLICIT:
        return _checked(partial(_tight, tolerances=STIFF_TOLERANCES), mechanism, times, first, second, seconds)
    solved = _fine if switches_of(mechanism.system) is None else _tight
    return _checked(solved, mechanism, times, first, second, seconds)


def _checked(
    solved: Callable[..., _Fine], mechanism: Mechanism, times: Array, first: str, second: str, seconds: float
) -> Reference:
    """Compute the reference from two solutions, both by the function `solved`."""
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
        method=_method_words(fine.solution),
        check=_method_words(check.solution),
        limit=_limit((fine, check), seconds),
    )


@dataclass(frozen=True, eq=False)
class _Fine:
    """A solution, and how far its last refinement moved the points up to each time, (T, k), m. `out_of_time` tells that
    time did not suffice for more."""

    solution: Solution
    moved: Array
    out_of_time: bool = False


def _fine(mechanism: Mechanism, setting: Setting, times: Array, seconds: float, instead: str = "") -> _Fine:
    """Halve the fixed steps until that does not help. Where the formulation is refused, use `instead`."""
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
    """Solve with error control at falling tolerances, down to where round-off dominates. Where the formulation is
    refused, use `instead`."""
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
    """Whether a halving of the steps helps at enough of the times. A chaotic motion needs very fine steps for its end,
    while its beginning reaches round-off long before."""
    fallen = (now[1:] <= FALLING * before[1:]) & (now[1:] < np.inf)
    return bool(np.isinf(before[1:]).all() or np.mean(fallen) > PART)


def running_largest(values: Array) -> Array:
    """The largest of `values` (T, ...) up to each time; infinite from the first NaN on."""
    largest: Array = np.maximum.accumulate(np.where(np.isnan(values), np.inf, values), axis=0)
    return largest


def _method_words(solution: Solution) -> str:
    formulation = solution.report.formulation if solution.report else solution.setting.formulation
    tolerance, step = solution.setting.tolerance, solution.setting.step
    how = f"tolerance {tolerance:g}" if step is None else f"fixed steps of {step:.3g} s"
    return f"{solution.setting.integrator}, {how}, {formulation}"


def error(solution: Solution, reference: Reference) -> Array:
    """The distance of each point from the reference, (T, k) in m; infinite after a failure."""
    distance = np.linalg.norm(solution.position - reference.position, axis=2)
    return np.where(np.isnan(distance), np.inf, distance)
