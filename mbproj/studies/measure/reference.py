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

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from math import ceil, floor, lcm
from time import process_time
from typing import Annotated, Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import brief, dataclass
from mbproj.base.errors import InputError, MbprojError, Problem
from mbproj.linear.equilibrium.start import beside
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.law_switches import switches_of
from mbproj.motion.stiffness import steps_for_stability
from mbproj.motion.time_events import crowded, time_events
from mbproj.results.analysis.trust import growth
from mbproj.scene.sampling import DEFAULT_SAMPLES, MOST_SAMPLES
from mbproj.scene.scene import Scene
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import OFF_AXIS, Mechanism, Solution, sample_times, solve, unseen
from mbproj.studies.parallel.progress import PERTURBED_STARTS, Tell, silent
from mbproj.studies.study import Study

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
    times: Annotated[Array, "T"]
    position: Annotated[Array, "T k 3"]
    velocity: Annotated[Array, "T k 3"]
    uncertainty: Annotated[Array, "T k"]
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
    mechanism: Mechanism,
    times: Array,
    compared: Collection[str] = (),
    seconds: float = SECONDS,
    tell: Tell = silent,
) -> Reference:
    """The reference of `mechanism` at `times` (evenly spaced, as `solve` takes them), to compare the integrators
    `compared`.

    It is kept on disk (`mbproj.studies.store`). Raises InputError where the mechanism cannot be run at all.
    """
    tell("reference", 0, 1)
    pair = IMPLICIT if _is_stiff(mechanism, times) else INTEGRATORS
    first, second = pair if pair[0] not in compared or pair[1] in compared else pair[::-1]
    what = ("reference", mechanism.identity, times.tolist(), first, seconds, FALLING, PART, TOLERANCES)
    study = Study(what, Reference, T=len(times))
    found: Reference = study.one("", lambda: _computed(mechanism, times, first, second, seconds))
    return found


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
    """Compute the reference from two solutions with fixed steps. Where laws have edges in the state, or the mechanism
    is stiff, they have error control."""
    edges = switches_of(mechanism.system) is not None
    tolerances = STIFF_TOLERANCES if first in IMPLICIT else TOLERANCES if edges else ()
    fine = _fine(mechanism, Setting(integrator=first, projection_tolerance=ROUND_OFF), times, seconds, tolerances)
    if why := unseen(mechanism, fine.solution):
        raise InputError(Problem(why, hint=OFF_AXIS))
    taken = fine.solution.report.formulation if fine.solution.report else ""
    other = "reduced" if taken == "planar" else "auto"
    setting = Setting(integrator=second, projection_tolerance=ROUND_OFF, formulation=other)
    check = _fine(mechanism, setting, times, seconds, tolerances)
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


def _fine(mechanism: Mechanism, setting: Setting, times: Array, seconds: float, tolerances: Sequence[float]) -> _Fine:
    """Solve with error control at falling `tolerances`, down to where round-off dominates. Without any, halve fixed
    steps until that does not help. Where the formulation is refused, take `auto`."""
    sizes, halving, started = _halved(times), not tolerances, process_time()
    if tolerances:
        sizes = ({"tolerance": tolerance} for tolerance in tolerances)
    best: _Fine | None = None
    for size in sizes:
        begun, finer = process_time(), solve(mechanism, replace(setting, **size), times)
        if finer.failure and finer.failure.status == "refused":
            if setting.formulation != "auto":
                return _fine(mechanism, replace(setting, formulation="auto"), times, seconds, tolerances)
            raise InputError(finer.failure.cause)
        if best is None:
            best = _Fine(finer, np.full((len(times), 1), np.inf))
            continue
        moved = running_largest(np.linalg.norm(finer.position - best.solution.position, axis=2))
        if halving and not _falls(best.moved, moved):
            return _Fine(best.solution, moved)
        best, taken = _Fine(finer, moved), process_time()
        if halving and moved[-1].max() <= GOAL * mechanism.system.length:
            return best
        if taken - started + 2.0 * (taken - begun) > seconds:
            return replace(best, out_of_time=halving or finer.setting.tolerance != tolerances[-1])
    assert best is not None  # there is at least one size
    return best


def _halved(times: Array) -> Iterator[dict[str, Any]]:
    """Yield fixed steps that meet the times, each half of the one before."""
    parts = max(1, -(-FEWEST_STEPS // (len(times) - 1)))
    while True:
        yield {"step": float(times[1] - times[0]) / parts}
        parts *= 2


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


# --- The influence of round-off on a motion ---------------------------------------------------------------------------
# Runs from starts that differ by round-off.


#: A tolerance so tight that round-off dominates the error.
TIGHTEST = 1e-14
#: The number of perturbed starts, and the factor by which the true motion may be farther away than the farthest of
#: them.
PERTURBED, ROUND_OFF_SAFETY = 4, 3.0
#: Size of the perturbation in units of the round-off of the mechanism's coordinates.
UNITS = 4.0


def perturbed(mechanism: Mechanism, seed: int) -> Mechanism:
    """Return the mechanism with a perturbed start that is consistent too. A random number of a few units in the last
    place of the largest changes each coordinate and velocity."""
    random, system, state = np.random.default_rng(seed), mechanism.system, mechanism.state
    size = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
    ulp = UNITS * np.finfo(float).eps
    q = state.q + ulp * np.maximum(size, np.abs(state.q)) * random.uniform(-1.0, 1.0, len(size))
    fastest = float(np.abs(state.v).max(initial=0.0))
    v = state.v + ulp * fastest * random.uniform(-1.0, 1.0, len(size))
    guess = replace(initial_guess(mechanism.scene, system), q=q, v=v)
    return Mechanism(mechanism.scene, system, beside(mechanism.scene, system, guess))


def tight_solution(mechanism: Mechanism, times: Array) -> Solution:
    """A solution as accurate as round-off allows, where the equations are smooth."""
    return solve(mechanism, Setting(integrator="dop853", tolerance=TIGHTEST), times)


def round_off_bound(mechanism: Mechanism, of: Solution, tell: Tell = silent) -> Array:
    """A bound on the error that round-off causes in a `tight_solution` up to each time, (T, k), m. It comes from runs
    with perturbed starts."""
    others = []
    for seed in range(1, PERTURBED + 1):
        tell(PERTURBED_STARTS, seed - 1, PERTURBED)
        setting = Setting(integrator="dop853", tolerance=(1.0 + 0.25 * seed) * TIGHTEST)
        others.append(solve(perturbed(mechanism, seed), setting, of.times))
    return ROUND_OFF_SAFETY * largest_distance(others, of)


def largest_distance(others: Sequence[Solution], of: Solution) -> Array:
    """The largest distance up to each time between the solution `of` and the others, (T, k), m. It is infinite from the
    end of one of them on."""
    apart = np.max([np.linalg.norm(other.position - of.position, axis=-1) for other in others], axis=0)
    distances: Array = np.maximum.accumulate(np.nan_to_num(apart, nan=np.inf))
    return distances


# --- The length of a study, and sample times that fixed steps of several sizes meet -----------------------------------


#: The fewest and the most samples, where the steps allow it.
FEW, MANY = 200, 1000
#: The number of samples where there is no fixed step: a number with many divisors.
DEFAULT = 480
#: The largest common multiple of steps, in units of the shortest, that is converted to a floating-point number.
FARTHEST = Fraction(10) ** 200
#: The relative difference up to which a ratio of times counts as a whole number.
WHOLE = 1e-9


def span(scene: Scene, until: float | None) -> float:
    """The length of a study in s: `until`, or the scene's duration. Raises InputError where neither is given."""
    duration = scene.settings.duration if until is None else until
    if duration is None or not 0.0 < duration < float("inf"):
        hint = "add it to 'simulation', or say how long on the command line"
        problem = Problem("the scene has no duration", scene.place("simulation"), hint)
        raise InputError(problem)
    return duration


def sampled(scene: Scene, until: float | None) -> Array:
    """The sample times of a run of the scene, (T,), s: every output step, or every step, or every thousandth of the
    duration, up to `until`. Raises InputError where the scene has no duration, or there are too many samples to
    hold."""
    duration, settings = span(scene, until), scene.settings
    interval = min(duration, settings.output_step or settings.step or (settings.duration or duration) / DEFAULT_SAMPLES)
    if duration / interval > MOST_SAMPLES:
        message = f"more than {MOST_SAMPLES:.0e} samples, every {interval:.6g} s until {duration:.6g} s"
        raise InputError(Problem(message, hint="choose a longer --output-step, or an earlier end"))
    whole = np.asarray(interval * np.arange(int(duration / interval * (1.0 + WHOLE)) + 1), dtype=float)
    over = duration - float(whole[-1]) > WHOLE * duration
    return np.concatenate([whole, [duration]]) if over else whole


def common_times(until: float, steps: Iterable[float]) -> Array:
    """Times from 0 to `until` (s) that are whole multiples of every step (s): some hundreds where possible. They end at
    the last common multiple before `until`. Raises InputError where there is none."""
    steps = tuple(steps)
    if not steps:
        return sample_times(until, DEFAULT)
    fractions = [Fraction(step / min(steps)).limit_denominator(10**7) for step in steps]
    whole = lcm(*(part.denominator for part in fractions))
    multiple = Fraction(lcm(*(int(part * whole) for part in fractions)), whole)  # in units of the shortest step
    together = min(steps) * float(min(multiple, FARTHEST))
    ratio = until / together
    count = floor(ratio * (1.0 + WHOLE))
    if not count:
        message = f"the steps do not meet before {together:g} s, and the study ends at {until:g} s"
        raise InputError(Problem(message, hint="choose steps that divide each other: 0.01, 0.005, 0.0025"))
    end = until if abs(ratio - count) <= WHOLE * ratio else count * together
    thinner = (stride for stride in range(ceil(count / MANY), ceil(count / FEW) + 1) if count % stride == 0)
    return sample_times(end, count // next(thinner, 1))


def stride_for(times: Array, step: float) -> int | None:
    """The fewest intervals of `times` after which a fixed step meets a sample again; None where no number fits."""
    intervals, interval = len(times) - 1, float(times[1] - times[0])
    for stride in range(1, intervals + 1):
        ratio = stride * interval / step
        if intervals % stride == 0 and ratio > 0.5 and abs(ratio - round(ratio)) <= WHOLE * ratio:
            return stride
    return None


def divisors(number: int) -> list[int]:
    """All divisors of a number, in increasing order."""
    return [int(part) for part in np.flatnonzero(number % np.arange(1, number + 1) == 0) + 1]


# --- A certain reference ----------------------------------------------------------------------------------------------
# A reference up to the time until which it is certain, and why it is not certain, or an error goal is missed, beyond:
# chaos, round-off, or too many kinks.
# Where forces or motions have more kinks in time than steps can end at, no method keeps its order. Kinks in the state
# do not count, as error control meets them anywhere.


#: A study ends early where the reference is uncertain by more than this part of the mechanism's size.
CERTAIN = 1e-6
#: Round-off explains an uncertainty if it makes up at least this part of it.
EXPLAINS = 0.1
#: A motion is chaotic where errors grow exponentially, by more than this factor over the study.
CHAOS = 1e3
#: The most forces and motions that a message names.
SHOWN = 3


def certain_reference(
    mechanism: Mechanism, until: float, scene_setting: Setting, names: Sequence[str], tell: Tell = silent
) -> tuple[Reference, list[str]]:
    """The reference up to `until` (s), or to the last time at which it is certain to `CERTAIN`, and notes on it. It
    serves to compare the integrators `names` and `scene_setting`. Raises InputError where no time is certain."""
    steps = [scene_setting.step] if scene_setting.step is not None and scene_setting.step <= until else []
    known = reference(mechanism, common_times(until, steps), names, tell=tell)
    limit, notes = CERTAIN * mechanism.system.length, list[str]()
    while (certain := known.certain_until(limit)) < known.times[-1]:
        why = why_not(mechanism, known, limit, certain, tell)
        if certain < 2 * known.times[1]:
            raise InputError(Problem(f"there is no reference for this mechanism: {why}", hint="try a shorter time"))
        notes = [f"the study ends at {certain:.4g} s: the reference is certain to {limit:.1g} m up to there ({why})"]
        known = reference(mechanism, common_times(certain, steps), names)
    return known, [known.words, *notes]


def why_not(mechanism: Mechanism, reference: Reference, goal: float, until: float, tell: Tell = silent) -> str:
    """Return in words why an error of `goal` (m) is missed, or cannot be checked, after the time `until` (s).

    Runs from starts that differ by round-off tell. Round-off is the reason where these runs part by a fair part of the
    goal or of the reference's uncertainty. Where they part exponentially, the motion is chaotic.
    """
    uncertainty, times = reference.uncertainty.max(axis=1), reference.times
    ended = np.flatnonzero(~np.isfinite(uncertainty))
    if len(ended) and reference.limit:
        return reference.limit
    better = tight_solution(mechanism, times)
    parted = round_off_bound(mechanism, better, tell).max(axis=1)
    at = min(int(np.searchsorted(times, until * (1.0 + 1e-9), side="right")), len(times) - 1)
    if parted[at] >= EXPLAINS * min(goal, float(uncertainty[at])):
        extent = float(np.ptp(reference.position, axis=0).max())
        fitted = growth(times, parted, np.zeros_like(parted), extent)
        grown = parted[-1] / max(float(parted[1]), np.finfo(float).tiny)
        if fitted.law == "exponential" and grown > CHAOS:
            return f"the motion is chaotic: starts that differ by round-off part as exp({fitted.rate:.2g} t)"
        return f"errors grow from round-off: starts that differ by it are {parted[at]:.1g} m apart at {times[at]:.4g} s"
    known = bool(uncertainty[at] <= goal)
    differ = f"the best solutions are uncertain by {uncertainty[at]:.1g} m at {times[at]:.4g} s"
    said = "no setting is that accurate" if known else differ
    rough = uneven(mechanism, float(times[-1]))
    if rough:
        return f"{not_smooth(rough)}, and {said}"
    why = reference.limit or "a load that is shorter than a step may be the reason"
    return said if known else f"the reference does not converge: {differ}; {why}"


def uneven(mechanism: Mechanism, until: float) -> tuple[str, ...]:
    """The names of the forces and motions with too many kinks within `until` (s)."""
    start = mechanism.state.t
    return crowded(time_events(mechanism.system, start, start + until, until / DEFAULT_SAMPLES))


def not_smooth(names: Sequence[str]) -> str:
    """A sentence about the names that `uneven` returned: "force 'push' has more kinks in time than steps end at"."""
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    *others, last = [*names[:SHOWN], *more]
    said = "more kinks in time than steps end at"
    return f"{', '.join(others)} and {last} have {said}" if others else f"{last} has {said}"
