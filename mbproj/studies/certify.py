"""A run with a certificate: the positions of its points are recorded, and judged when the run ends.

The poses of a kinematic run are compared with those that Gauss-Newton steps in all coordinates find. Nothing was
integrated, so no error grows. The error of a pose comes from the residual of C, amplified by 1 / σ, where σ
is the smallest singular value of C_q in lengths and rad. The comparison also tests that both solutions stay on the same
branch, because their steps differ.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Protocol, overload

import numpy as np

from mbproj.analysis.growth import Growth
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics import State
from mbproj.dynamics.assembly.assemble import moved_by, nearest, scaled_rows
from mbproj.dynamics.assembly.gauss_newton import moved, shortest
from mbproj.dynamics.equations.constraint_equations import time_derivative
from mbproj.dynamics.equations.kinematics import attached, pose_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.equations.round_off import position_grain
from mbproj.dynamics.observe.recorded import Block
from mbproj.dynamics.rank.lasting import NO_CONDITIONS
from mbproj.errors import SimulationError
from mbproj.integrate import Report, simulate
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.reporting.failures import branch_untold
from mbproj.integrate.reporting.report import sharing_stops
from mbproj.integrate.simulate import EventRecorder, Keep, Progress
from mbproj.model.system import System
from mbproj.results.trust import Trust
from mbproj.scene.read import Scene
from mbproj.scene.records import Settings
from mbproj.studies.certify.horizon import LIMITS, certify, trust_of
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.results.writer import ResultsWriter


class CertificateRecorder(Protocol):
    """A recorder of a run's blocks and then its certificate, e.g. `mbproj.results.ResultsWriter`."""

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
def simulate_certified(*given: Any, scene: Scene | None = None, **named: Any) -> tuple[Report, Trust]:
    """Runs `simulate` with its arguments, and returns also how long the result can be trusted (see `certify`).

    It needs the `scene` of the system too, to compute better solutions; or a `Mechanism` in place of system, state and
    scene. A run that fails is certified up to its failure before SimulationError is raised; an interrupted one is not
    certified.
    """
    system = given[0] if given else named.get("system")
    if isinstance(system, System):
        if scene is None:
            raise TypeError("simulate_certified() lacks the argument 'scene': that of the system")
        words = ("system", "state")
        named |= dict(zip(words, given, strict=False))
        given = (Mechanism(scene, named.pop("system"), named.pop("state")), *given[2:])
    return _certified(*given, **named)


@dataclass(frozen=True)
class Certified:
    """What a run that `mbproj.runs.record` records is certified for: the errors `limits` (m). `tell` shows the
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
    paths = _PointRecorder(mechanism, recorder)
    choice = mechanism.choice(settings)

    def judge() -> Trust:
        if choice.kinematic and len(paths.arrays[0]) > 1:
            trust = certify_kinematic(mechanism, *paths.arrays, limits, tell)
        else:
            trust = certify(mechanism, settings, *paths.arrays, limits, tell, sharing_stops(paths.met))
        if recorder is not None:
            recorder.trust(trust)
        return trust

    try:
        report = simulate(mechanism.system, mechanism.state, settings, paths, progress, keep=keep, choice=choice)
    except SimulationError:
        judge()
        raise
    return report, judge()


class _PointRecorder:
    """A recorder of the points' positions, which passes everything on to another recorder."""

    def __init__(self, mechanism: Mechanism, recorder: CertificateRecorder | None) -> None:
        self._dataset, self._recorder = f"{mechanism.kind}/position", recorder
        self._times: list[Array] = []
        self._positions: list[Array] = []
        self.met: Sequence[Event] = ()

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        self._times.append(block["time"])
        self._positions.append(block[self._dataset])
        if self._recorder is not None:
            self._recorder.write(block)

    def events(self, events: Sequence[Event]) -> None:
        """Record the events of the run."""
        self.met = events
        if isinstance(self._recorder, EventRecorder):
            self._recorder.events(events)

    @property
    def arrays(self) -> tuple[Array, Array]:
        """The times (T,) and the positions (T, k, 3)."""
        return np.concatenate(self._times), np.concatenate(self._positions)


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
    own = np.full(position.shape, np.nan)
    uncertainty, remark = np.zeros(position.shape[:2]), "nothing of the motion was integrated: no error grows"
    largest, checked = 0.0, set(np.linspace(0, len(times) - 1, min(len(times), MOST_CHECKED)).astype(int).tolist())
    try:
        for at, q in enumerate(_poses_along(mechanism, times)):
            own[at] = _points(mechanism, q)
            if at in checked:
                tell("certifying", at, len(times))
                largest = max(largest, _round_off(mechanism, q))
    except (SimulationError, np.linalg.LinAlgError) as failure:
        cause = failure.cause if isinstance(failure, SimulationError) else str(failure)
        remark = f"the poses could not be followed to the end: {cause}"
    error = np.linalg.norm(position - own, axis=-1)
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
    rows, own = scaled_rows(system, pose_of(q), NO_CONDITIONS), slice(system.bodies, None)
    rate = shortest(rows, -time_derivative(system, drive_at(system, t))[own] / system.row_scale[own])
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
