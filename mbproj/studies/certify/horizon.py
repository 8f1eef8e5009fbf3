"""The trust horizon: how long a run agrees with a better solution of the same equations.

The better solution is DOP853 with GPOPM in the fastest formulation. Its tolerance falls by factors of 100 until the
horizons no longer depend on it. The distance between the last two solutions bounds the error of the last one. Where the
method has its full order, the bound is some fifty times too large. Where round-off dominates first, runs from perturbed
starts show how far any solution in double precision may be from the truth. Horizons then become ranges.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from mbproj.analysis.growth import Growth, growth
from mbproj.analysis.trust import horizons, settled
from mbproj.arrays import Array
from mbproj.results.trust import Poses, Trust
from mbproj.scene.records import Settings
from mbproj.studies.measure.certain import not_smooth, uneven
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.nearby import TIGHTEST, largest_distance, round_off_bound
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import OFF_AXIS, Solution, solve, unseen
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.thresholds import Thresholds

#: The error limits in m for which horizons are given.
LIMITS = tuple(10.0**power for power in range(-9, 1))
#: The loosest tolerance of the better solution, and the factor to the next one. The last is `TIGHTEST`, which round-off
#: dominates.
LOOSEST, FACTOR = 1e-8, 1e-2
#: The error of the tightest solution, as a part of its distance to the one before, where forces are smooth.
LEFT = 0.1


def limits_of(given: Iterable[float]) -> tuple[float, ...]:
    """The given limits in increasing order, each once; `LIMITS` where none is given."""
    return tuple(sorted({float(limit) for limit in given})) or LIMITS


def certify(
    mechanism: Mechanism,
    settings: Settings,
    times: Array,
    position: Array,
    limits: Sequence[float] = LIMITS,
    tell: Tell = silent,
    sharing: Sequence[str] = (),
) -> Trust:
    """Judges a run with `settings` by a better solution. The run's points (see `Mechanism`) were at `position` (T, k,
    3), m, at the sample times (T,), s. `limits` are in m. `sharing` names the stops on whose shares of a load the
    motion depends."""
    tested = tuple(limits)
    if len(times) < 2:
        return _trust(mechanism, times, position, None, np.zeros(position.shape[:2]), tested, "nothing was run")
    better, before = None, None
    rungs = list(ladder(settings))
    for number, tolerance in enumerate(rungs):
        tell("certifying", number, len(rungs))
        before, better = better, solve(mechanism, _better_setting(tolerance), times)
        if why := unseen(mechanism, better):
            why = f"no figure: {why}; {OFF_AXIS}"
            return _trust(mechanism, times, position, None, np.full(position.shape[:2], np.inf), tested, why)
        if before is not None:
            uncertainty = largest_distance([before], better)
            trust = _trust(mechanism, times, position, better, uncertainty, tested, "")
            if settled(trust.horizon_low, trust.horizon_high, times).all():
                return _with_contacts(mechanism, times, position, better, uncertainty, tested, "", sharing)
    assert better is not None  # there is at least one tolerance
    blame: tuple[str, ...] = ()
    uncertainty, rough = round_off_bound(mechanism, better, tell), uneven(mechanism, float(times[-1]))
    if before is not None:
        left = (1.0 if rough else LEFT) * largest_distance([before], better)
        blame = rough if left[-1].max() > uncertainty[-1].max() else ()
        uncertainty = np.maximum(uncertainty, left)
    return _with_contacts(mechanism, times, position, better, uncertainty, tested, _remark(better, blame), sharing)


def _with_contacts(
    mechanism: Mechanism,
    times: Array,
    position: Array,
    better: Solution,
    uncertainty: Array,
    limits: Sequence[float],
    remark: str,
    sharing: Sequence[str],
) -> Trust:
    """Return the certificate with the error that contacts leave in the better solution too."""
    slack = slack_bound(mechanism, better)
    if slack[-1].max(initial=0.0) > uncertainty[-1].max(initial=0.0):
        remark = f"times are ranges where they depend on the slack with which contacts are decided, {slack.max():.1g} m"
    uncertainty = uncertainty + slack
    if sharing:
        shares = share_bound(mechanism, better, sharing)
        own = ", ".join(f"stop '{name}'" for name in sharing)
        if shares is None:
            why = f"no figure: the motion depends on how these share their load, {own}"
            return _trust(mechanism, times, position, None, np.full(position.shape[:2], np.inf), limits, why)
        uncertainty = uncertainty + shares
        largest = f"by {shares.max():.1g} m where the floor is lower under one of them"
        remark = f"the motion depends on how these share their load, {own}: {largest}"
    return _trust(mechanism, times, position, better, uncertainty, limits, remark)


def ladder(settings: Settings) -> Iterator[float]:
    """The tolerances of the better solution of a run with `settings`. All are tighter than the run's own, or the
    tightest there is."""
    tolerance = min(LOOSEST, FACTOR * (settings.tolerance or 1.0))
    while tolerance > TIGHTEST / FACTOR**0.5:
        yield float(f"{tolerance:.2g}")
        tolerance *= FACTOR
    yield TIGHTEST


def _better_setting(tolerance: float) -> Setting:
    return Setting(integrator="dop853", tolerance=tolerance)


def _trust(
    mechanism: Mechanism,
    times: Array,
    position: Array,
    better: Solution | None,
    uncertainty: Array,
    limits: Sequence[float],
    remark: str,
) -> Trust:
    error = np.linalg.norm(position - (position if better is None else better.position), axis=-1)
    extent = np.ptp(position, axis=0).max(axis=-1)
    fits = [_growth(times, error[:, k], uncertainty[:, k], float(extent[k])) for k in range(len(extent))]
    solution = "" if better is None else better.setting.label
    trust = trust_of(mechanism.points, times, error, uncertainty, limits, fits, solution, remark)
    return replace(trust, better=None if better is None else Poses(better.body_position, better.body_orientation))


def trust_of(
    names: tuple[str, ...],
    times: Array,
    error: Array,
    uncertainty: Array,
    limits: Sequence[float],
    fits: Sequence[Growth],
    solution: str,
    remark: str,
) -> Trust:
    """Return the certificate of k points, by `names`, with their errors and uncertainties (T, k), m, at the times (T,),
    s, and the growth of each. `limits` are in m; `solution` is the label of what the run was compared with."""
    bounds = horizons(times, error, uncertainty, np.asarray(limits))
    return Trust(
        names=names,
        limits=np.asarray(limits, dtype=float),
        time=times,
        error=error,
        uncertainty=uncertainty,
        horizon=bounds.time,
        horizon_low=bounds.low,
        horizon_high=bounds.high,
        growth_rate=np.array([fit.rate for fit in fits]),
        growth_power=np.array([fit.power for fit in fits]),
        growth_law=tuple(fit.law for fit in fits),
        solution=solution,
        remark=remark,
    )


def _growth(times: Array, error: Array, uncertainty: Array, extent: float) -> Growth:
    """The growth of the error where it is known, or else of the influence of round-off, which grows alike."""
    fitted = growth(times, error, uncertainty, extent)
    return fitted if fitted.law else growth(times, uncertainty, np.zeros_like(uncertainty), extent)


def _remark(better: Solution, rough: Sequence[str]) -> str:
    """The reason why horizons are ranges: the better solution ended, the forces `rough` are not smooth, or
    round-off."""
    if better.failure is not None:
        return f"the better solution {better.failure}; what comes after it is not known"
    if rough:
        return f"times are ranges where they are not known better, because {not_smooth(rough)}"
    return "the run is nearly as good as round-off allows: times are given as ranges where that matters"


# --- The error that contacts leave in any solution --------------------------------------------------------------------
# The slack with which they are decided, and loads that they share.


#: The thresholds that decide when contacts open and frictions slip, the factor by which they are loosened, and the part
#: of the distance to the looser solution that bounds the error. A decision comes between one slack and twice the slack
#: early: the looser solution is at least 8 slacks away, and the true one at most 2.
SLACKS, LOOSER, PART = ("slips", "contact_pulls"), 10.0, 0.25
#: How much lower the floor under one of the feet is where these share a load, in lengths of the mechanism, and the most
#: feet under which it is lowered.
UNEVEN, MOST_FEET = 1e-6, 8


def slack_bound(mechanism: Mechanism, of: Solution) -> Array:
    """A bound on the error of a solution by the slack with which contacts and dry frictions are decided, up to each
    time, (T, k), m. 0 without any."""
    system = mechanism.system
    if system.stops is None and system.frictions is None:
        return np.zeros(of.position.shape[:2])
    own = system.thresholds
    looser = Thresholds(**{name: LOOSER * getattr(own, name) for name in SLACKS})
    other = solve(Mechanism(mechanism.scene, replace(system, thresholds=looser), mechanism.state), of.setting, of.times)
    return PART * largest_distance([other], of)


def share_bound(mechanism: Mechanism, of: Solution, stops: Sequence[str]) -> Array | None:
    """How far a solution depends on how these stops share a load, up to each time, (T, k), m: the largest distance to
    those with the floor a little lower under one of them. None where none of these runs to the end."""
    others = []
    for floor in _uneven(mechanism, stops):
        other = solve(floor, of.setting, of.times)
        if other.failure is None:
            others.append(other)
    return largest_distance(others, of) if others else None


def _uneven(mechanism: Mechanism, stops: Sequence[str]) -> Iterator[Mechanism]:
    """Yield the mechanism with a bound of one of the stops shifted away from it."""
    system = mechanism.system
    assert system.stops is not None
    for name in stops[:MOST_FEET]:
        at = system.names.stops.index(name)
        bound = system.stops.bound.copy()
        bound[at] -= system.stops.side[at] * UNEVEN * system.length
        yield Mechanism(mechanism.scene, replace(system, stops=replace(system.stops, bound=bound)), mechanism.state)
