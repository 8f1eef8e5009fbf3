"""A run with a certificate: the positions of its points are recorded, and judged when the run ends.

The poses of a kinematic run are compared with those that Gauss-Newton steps in all coordinates find. Nothing was
integrated, so no error grows. The error of a pose comes from the residual of C, amplified by 1 / σ, where σ
is the smallest singular value of C_q in lengths and rad. The comparison also tests that both solutions stay on the same
branch, because their steps differ.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol, overload

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS, Thresholds
from mbproj.equations.assembly.assemble import State, moved_by, nearest, scaled_rows
from mbproj.equations.assembly.gauss_newton import moved, shortest
from mbproj.equations.constraints import position_grain, time_derivative
from mbproj.equations.kinematics import attached, pose_of
from mbproj.equations.motions import drive_at
from mbproj.equations.rank.row_space import NO_CONDITIONS
from mbproj.equations.recorded import Block
from mbproj.model.system import System
from mbproj.motion.failures import branch_untold
from mbproj.motion.report import Report, sharing_stops
from mbproj.motion.simulate import Keep, Progress, simulate
from mbproj.results.analysis.trust import Growth, growth, horizons, settled
from mbproj.results.trust import Poses, Trust
from mbproj.scene.scene import Scene
from mbproj.studies.measure.reference import TIGHTEST, largest_distance, not_smooth, round_off_bound, uneven
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import OFF_AXIS, DatasetRecorder, Mechanism, Solution, solve, unseen
from mbproj.studies.parallel.progress import Tell, silent

if TYPE_CHECKING:
    from mbproj.results.writer import ResultsWriter


# --- The trust horizon ------------------------------------------------------------------------------------------------
# How long a run agrees with a better solution of the same equations.
# The better solution is DOP853 with GPOPM in the fastest formulation. Its tolerance falls by factors of 100 until the
# horizons no longer depend on it. The distance between the last two solutions bounds the error of the last one. Where
# the method has its full order, the bound is some fifty times too large. Where round-off dominates first, runs from
# perturbed starts show how far any solution in double precision may be from the truth. Horizons then become ranges.


#: The error limits in m for which horizons are given.
LIMITS = tuple(10.0**power for power in range(-9, 1))
#: The loosest tolerance of the better solution, and the factor to the next one. The last is `TIGHTEST`, which round-off
#: dominates.
LOOSEST, FACTOR = 1e-8, 1e-2
#: The error of the tightest solution, as a part of its distance to the one before, where forces are smooth.
LEFT = 0.1


def limits_of(limits: Iterable[float]) -> tuple[float, ...]:
    """The given limits in increasing order, each once; `LIMITS` where none is given."""
    return tuple(sorted({float(limit) for limit in limits})) or LIMITS


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
    run = _Run(mechanism, times, position, tuple(limits))
    if len(times) < 2:
        return run.trust(None, np.zeros(position.shape[:2]), "nothing was run")
    better, before = None, None
    rungs = list(ladder(settings))
    for number, tolerance in enumerate(rungs):
        tell("certifying", number, len(rungs))
        before, better = better, solve(mechanism, Setting(integrator="dop853", tolerance=tolerance), times)
        if why := unseen(mechanism, better):
            return run.unknown(f"{why}; {OFF_AXIS}")
        if before is not None:
            uncertainty = largest_distance([before], better)
            trust = run.trust(better, uncertainty)
            if settled(trust.horizon_low, trust.horizon_high, times).all():
                return run.with_contacts(better, uncertainty, "", sharing)
    assert better is not None  # there is at least one tolerance
    blame: tuple[str, ...] = ()
    uncertainty, rough = round_off_bound(mechanism, better, tell), uneven(mechanism, float(times[-1]))
    if before is not None:
        left = (1.0 if rough else LEFT) * largest_distance([before], better)
        blame = rough if left[-1].max() > uncertainty[-1].max() else ()
        uncertainty = np.maximum(uncertainty, left)
    return run.with_contacts(better, uncertainty, _remark(better, blame), sharing)


@dataclass(frozen=True, eq=False)
class _Run:
    """A run that is judged, see `certify`."""

    mechanism: Mechanism
    times: Array
    position: Array
    limits: tuple[float, ...]

    def with_contacts(self, better: Solution, uncertainty: Array, remark: str, sharing: Sequence[str]) -> Trust:
        """The certificate with the error that contacts leave in the better solution too."""
        slack = slack_bound(self.mechanism, better)
        if slack[-1].max(initial=0.0) > uncertainty[-1].max(initial=0.0):
            largest = f"{slack.max():.1g} m"
            remark = f"times are ranges where they depend on the slack with which contacts are decided, {largest}"
        uncertainty = uncertainty + slack
        if sharing:
            shares = share_bound(self.mechanism, better, sharing)
            stops = ", ".join(f"stop '{name}'" for name in sharing)
            remark = f"the motion depends on how these share their load, {stops}"
            if shares is None:
                return self.unknown(remark)
            uncertainty = uncertainty + shares
            remark += f": by {shares.max():.1g} m where the floor is lower under one of them"
        return self.trust(better, uncertainty, remark)

    def unknown(self, why: str) -> Trust:
        """The certificate of a run of whose error nothing is known."""
        return self.trust(None, np.full(self.position.shape[:2], np.inf), f"no figure: {why}")

    def trust(self, better: Solution | None, uncertainty: Array, remark: str = "") -> Trust:
        """The certificate by a better solution, which is uncertain by (T, k), m."""
        error = np.linalg.norm(self.position - (self.position if better is None else better.position), axis=-1)
        extent = np.ptp(self.position, axis=0).max(axis=-1)
        fits = [_growth(self.times, error[:, k], uncertainty[:, k], float(extent[k])) for k in range(len(extent))]
        solution = "" if better is None else better.setting.label
        trust = trust_of(self.mechanism.points, self.times, error, uncertainty, self.limits, fits, solution, remark)
        return replace(trust, better=None if better is None else Poses(better.body_position, better.body_orientation))


def ladder(settings: Settings) -> Iterator[float]:
    """The tolerances of the better solution of a run with `settings`. All are tighter than the run's own, or the
    tightest there is."""
    tolerance = min(LOOSEST, FACTOR * (settings.tolerance or 1.0))
    while tolerance > TIGHTEST / FACTOR**0.5:
        yield float(f"{tolerance:.2g}")
        tolerance *= FACTOR
    yield TIGHTEST


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
    thresholds = system.thresholds
    looser = Thresholds(**{name: LOOSER * getattr(thresholds, name) for name in SLACKS})
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


# --- A run with a certificate -----------------------------------------------------------------------------------------


class CertificateRecorder(Protocol):
    """A recorder of a run's blocks and then its certificate, e.g. `mbproj.results.writer.ResultsWriter`."""

    def write(self, block: Block) -> None:
        """Records T consecutive samples by dataset path."""

    def trust(self, trust: Trust) -> None:
        """Records the certificate."""


@overload
def simulate_certified(
    system: System,
    state: State,
    settings: Settings,
    recorder: CertificateRecorder | None = None,
    progress: Progress | None = None,
    *,
    scene: Scene,
    limits: Sequence[float] = LIMITS,
    tell: Tell = silent,
    keep: Keep | None = None,
) -> tuple[Report, Trust]: ...
@overload
def simulate_certified(
    mechanism: Mechanism,
    settings: Settings,
    recorder: CertificateRecorder | None = None,
    progress: Progress | None = None,
    limits: Sequence[float] = LIMITS,
    tell: Tell = silent,
    keep: Keep | None = None,
) -> tuple[Report, Trust]: ...
def simulate_certified(*args: Any, scene: Scene | None = None, **named: Any) -> tuple[Report, Trust]:
    """Runs `simulate` with its arguments, and returns also how long the result can be trusted (see `certify`).

    It needs the `scene` of the system too, to compute better solutions; or a `Mechanism` in place of system, state and
    scene. A run that fails is certified up to its failure before SimulationError is raised; an interrupted one is not
    certified.
    """
    system = args[0] if args else named.get("system")
    if isinstance(system, System):
        if scene is None:
            raise TypeError("simulate_certified() lacks the argument 'scene': that of the system")
        words = ("system", "state")
        named |= dict(zip(words, args, strict=False))
        args = (Mechanism(scene, named.pop("system"), named.pop("state")), *args[2:])
    return _certified(*args, **named)


@dataclass(frozen=True)
class Certified:
    """What a run that `mbproj.studies.record` records is certified for: the errors `limits` (m). `tell` shows the
    progress."""

    limits: Sequence[float]
    tell: Tell = silent

    def simulate(
        self,
        scene: Scene,
        system: System,
        state: State,
        settings: Settings,
        recorder: ResultsWriter,
        progress: Progress | None,
        keep: Keep,
    ) -> tuple[Report, Trust]:
        """Run the scene into the recorder, and judge the run."""
        mechanism = Mechanism(scene, system, state)
        return _certified(mechanism, settings, recorder, progress, self.limits, self.tell, keep)


def _certified(
    mechanism: Mechanism,
    settings: Settings,
    recorder: CertificateRecorder | None = None,
    progress: Progress | None = None,
    limits: Sequence[float] = LIMITS,
    tell: Tell = silent,
    keep: Keep | None = None,
) -> tuple[Report, Trust]:
    places = f"{mechanism.kind}/position"
    paths = DatasetRecorder(("time", places), recorder)
    choice = mechanism.choice(settings)

    def judge() -> Trust:
        arrays = paths["time"], paths[places]
        if choice.kinematic and len(arrays[0]) > 1:
            trust = certify_kinematic(mechanism, *arrays, limits, tell)
        else:
            trust = certify(mechanism, settings, *arrays, limits, tell, sharing_stops(paths.met))
        if recorder is not None:
            recorder.trust(trust)
        return trust

    try:
        report = simulate(mechanism.system, mechanism.state, settings, paths, progress, keep=keep, choice=choice)
    except SimulationError:
        judge()
        raise
    return report, judge()


#: The most samples at which σ is computed.
MOST_CHECKED = 40
#: The residual at which a pose counts as closed, in lengths of the mechanism and rad.
CLOSED = 1e-15
#: A step is halved, at most `MOST_HALVINGS` times, where closing the pose moves a body by more than this part of the
#: step and by more than `NEARLY` (m or rad).
NEAR, NEARLY, MOST_HALVINGS = 0.1, 1e-3, 12
SOLUTION = "Gauss-Newton steps in the full coordinates at the samples, which follow the motion by themselves"


def certify_kinematic(
    mechanism: Mechanism, times: Array, position: Array, limits: Sequence[float], tell: Tell = silent
) -> Trust:
    """Judges a kinematic run whose points were at `position` (T, k, 3), m, at the sample times (T,), s. `limits` are in
    m. From the first sample on that the Gauss-Newton steps cannot reach, the error is unknown."""
    followed = np.full(position.shape, np.nan)
    uncertainty, remark = np.zeros(position.shape[:2]), "nothing of the motion was integrated: no error grows"
    largest, checked = 0.0, set(np.linspace(0, len(times) - 1, min(len(times), MOST_CHECKED)).astype(int).tolist())
    try:
        for at, q in enumerate(_poses_along(mechanism, times)):
            followed[at] = _points(mechanism, q)
            if at in checked:
                tell("certifying", at, len(times))
                largest = max(largest, _round_off(mechanism, q))
    except (SimulationError, np.linalg.LinAlgError) as failure:
        cause = failure.cause if isinstance(failure, SimulationError) else str(failure)
        remark = f"the poses could not be followed to the end: {cause}"
    error = np.linalg.norm(position - followed, axis=-1)
    uncertainty[:] = largest
    unknown = [Growth()] * len(mechanism.points)
    return trust_of(mechanism.points, times, error, uncertainty, limits, unknown, SOLUTION, remark)


def _poses_along(mechanism: Mechanism, times: Array) -> Iterator[Array]:
    """Yield q (7n,) at each of the times, following the motion from the start."""
    t, q = mechanism.state.t, mechanism.state.q
    for time in times.tolist():
        q = _pose_at(mechanism.system, t, q, time)
        t = time
        yield q


def _pose_at(system: System, t: float, q: Array, end: float, halvings: int = 0) -> Array:
    """Follow the motion from q at time t to the time `end`: move along its velocity, then close the constraints. The
    step is halved where closing moves the pose much. Raises SimulationError where the branch cannot be told."""
    drive = drive_at(system, end)
    rows, joint_rows = scaled_rows(system, pose_of(q), NO_CONDITIONS), slice(system.bodies, None)
    rate = shortest(rows, -time_derivative(system, drive_at(system, t))[joint_rows] / system.row_scale[joint_rows])
    ahead = moved(system, q, (end - t) * rate)
    closed, residual = nearest(system, ahead, NO_CONDITIONS, drive, CLOSED)
    way, corrected = (max(moved_by(each, closed)) for each in (q, ahead))
    if np.abs(residual).max(initial=0.0) <= THRESHOLDS.rounding and corrected <= max(NEAR * way, NEARLY):
        return closed
    if halvings == MOST_HALVINGS:
        raise branch_untold(end)
    middle = 0.5 * (t + end)
    return _pose_at(system, middle, _pose_at(system, t, q, middle, halvings + 1), end, halvings + 1)


def _points(mechanism: Mechanism, q: Array) -> Array:
    """The positions of the points at q, (k, 3)."""
    system = mechanism.system
    markers = mechanism.kind == "markers"
    body, local = (system.marker_body, system.marker_local) if markers else (system.body_carrier, system.body_offset)
    return np.asarray(attached(pose_of(q), body, local, np.ones(len(body))), dtype=float)


def _round_off(mechanism: Mechanism, q: Array) -> float:
    """The error of a point's position that round-off in C allows, m; infinite at a singular pose."""
    system, pose = mechanism.system, pose_of(q)
    rows = scaled_rows(system, pose, NO_CONDITIONS).dense()
    values = np.linalg.svd(rows, compute_uv=False)
    σ = float(values[values > THRESHOLDS.dependent].min(initial=np.inf))
    grain = float((position_grain(system, pose)[system.bodies :] / system.row_scale[system.bodies :]).max(initial=0.0))
    return THRESHOLDS.closed_grains * grain / σ * system.length
