"""A run in the compiled kernel: what reduced and planar coordinates have in common, and the march in blocks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import ModuleType
from typing import Any, ClassVar

import numpy as np

from mbproj.arrays import Array, Integers, may_overflow
from mbproj.dynamics.assembly.assemble import State, coordinate_values
from mbproj.dynamics.equations.forces import applied
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.observe.samples import Samples, block_samples
from mbproj.errors import SimulationError
from mbproj.integrate.events.breaks import Break, breaks_of
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.outcome.failures import (
    TurnsUntold,
    dry_friction,
    left_open,
    not_finite,
    other_branch,
    singular,
    step_vanished,
    unresolved,
    unsolved_stage,
)
from mbproj.integrate.outcome.marks import START, Mark, Marks, restored_events, resuming, saved_events
from mbproj.integrate.outcome.tally import Passed, Peak, Tally
from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau
from mbproj.integrate.steppers.methods import tableau_of
from mbproj.integrate.steppers.tableau import Tableau
from mbproj.model.system import System
from mbproj.registry import PROJECTIONS
from mbproj.scene.records import ProjectionSettings, Settings
from mbproj.scene.sampling import output_every, output_times, whole_steps

#: The kernel comes back for Ctrl-C and for progress at least this often, s.
RETURN_SECONDS = 0.1
PHASES = ("accelerations", "position projection", "velocity projection", "rest")


class Compiled(ABC):
    """A system in the kernel's coordinates. `dimension` names the kernel's classes: Space or Plane."""

    name: ClassVar[str]
    dimension: ClassVar[str]

    def __init__(self, core: ModuleType | None, system: System, model: Any) -> None:
        assert core is not None
        self.core, self.system, self.model = core, system, model

    @property
    @abstractmethod
    def degrees_of_freedom(self) -> int:
        """What the independent rows leave free."""

    @property
    @abstractmethod
    def row_scale(self) -> Array:
        """What the kernel's rows are measured against: the system's length, or 1 rad, (m,)."""

    @abstractmethod
    def state(self, q: Array, v: Array) -> Array:
        """The kernel's state (..., n, 13 or 6) from q and v = q' (..., 7n)."""

    @abstractmethod
    def coordinates(self, y: Array) -> tuple[Array, Array]:
        """q and v of one state of the kernel."""

    @abstractmethod
    def samples(self, block: Mapping[str, Any], counters: Mapping[str, Integers]) -> Samples:
        """A block of the kernel in the coordinates of all formulations."""

    @abstractmethod
    def turns(self, turns: Integers) -> Integers:
        """Whole turns of the kernel's coordinates from those of the system's (nc,)."""

    @abstractmethod
    def joint(self, number: int) -> int:
        """The system's number of one of the kernel's joints; motions follow the joints, and then reflected inertias."""

    @abstractmethod
    def row(self, number: int) -> int:
        """A row of the system's C (norm rows first) for one of the kernel's rows."""

    @abstractmethod
    def coordinate(self, number: int) -> int:
        """The system's number of one of the kernel's coordinates."""

    def equations(self, projection: ProjectionSettings | None = None) -> Any:
        """The kernel's equations at single states."""
        mass = self.core.Correction.mass
        settings = self.core.Projection(mass) if projection is None else self.projection(projection)
        return getattr(self.core, f"{self.dimension}Equations")(self.model, settings)

    def owner(self, number: int) -> str | None:
        """Whose rows are those of one of the kernel's joints, for messages: "joint 'A'", "motion 'm'"."""
        if number < 0:
            return None
        joint, joints = self.joint(number), self.system.names.joints
        if joint >= len(joints) + self.system.driven:
            return "a joint's reflected inertia"
        if joint >= len(joints):
            return f"motion '{self.system.names.motions[joint - len(joints)]}'"
        return f"joint '{joints[joint]}'"

    def is_regular(self, state: State) -> tuple[bool, int]:
        """Whether the accelerations are unique at a state, and else the kernel's joint whose rows depend on the others'
        (-1 where no joint is to blame). Raises SimulationError where a function of the scene has no value."""
        equations, coordinate = self.equations(), coordinate_values(self.system, pose_of(state.q))
        reference = coordinate + 2.0 * np.pi * state.turns
        y = self.state(state.q, state.v)
        if equations.accelerations(y, state.t, self.turns(reference).tolist()) is not None:
            return True, -1
        self.require_functions(state.t, state.q, state.v)
        return False, int(equations.singular_joint)

    def responses(self, state: State, laws: Integers) -> Array | None:
        """W of `mbproj.dynamics.fast_modes` for these laws, (e, e); None where it is not unique."""
        y = np.ascontiguousarray(self.state(state.q, state.v))
        found: Array | None = self.equations().responses(y, laws.tolist(), state.t)
        return found

    def require_functions(self, t: float, q: Array, v: Array) -> None:
        """Raises SimulationError that names the force or motion whose function has no value at a state."""
        drive_at(self.system, t)
        if self.system.forces is not None:
            pose = pose_of(q)
            applied(self.system, pose, twist_of(pose, v), t, coordinate_values(self.system, pose))

    def run(self, state: State, settings: Settings) -> Any:
        """The kernel's run from a state."""
        kind = getattr(self.core, f"{self.dimension}Run")
        turns = np.ascontiguousarray(self.turns(state.turns), dtype=np.int64)
        return kind(
            self.model,
            _tableau(self.core, tableau_of(settings.integrator)),
            self.projection(settings.projection),
            _steps(self.core, settings, state.t, breaks_of(self.system, state.t, settings)),
            self.state(state.q, state.v),
            turns,
        )

    def projection(self, settings: ProjectionSettings) -> Any:
        """The settings as the kernel has them."""
        found = self.core.Projection(getattr(self.core.Correction, PROJECTIONS[settings.method].correction))
        if settings.gains is not None:
            found.alpha, found.beta = settings.gains
        if settings.alpha is not None:
            found.alpha = settings.alpha
        if settings.tolerance is not None:
            found.tolerance = settings.tolerance
        if settings.threshold is not None:
            found.threshold = settings.threshold
        found.paper_test = settings.test == "paper"
        found.every, found.max_iterations = settings.every, settings.max_iterations
        found.position, found.velocity = settings.position, settings.velocity
        found.fallback = settings.fallback == "gopm"
        return found

    def failure(self, run: Any, settings: Settings) -> SimulationError | None:
        """Why a run with these settings ended before its time; None where it did not."""
        outcome, status = run.outcome, self.core.Status
        t = float(outcome.time)
        if outcome.status in (status.running, status.finished):
            return None
        if outcome.status == status.not_finite or not np.isfinite(outcome.open_by):
            return not_finite(t)
        if outcome.status == status.vanished:
            return step_vanished(t)
        if outcome.status == status.singular:
            return singular(t, self.owner(outcome.joint))
        if outcome.status == status.branch:
            return other_branch(t, outcome.velocity_change)
        if outcome.status == status.unresolved:
            return unresolved(t, outcome.velocity_change)
        if outcome.status == status.untold:
            name = self.system.names.coordinates[self.coordinate(outcome.coordinate)]
            teeth = self.system.meshes.size > 0
            return TurnsUntold(t, name, outcome.turned, outcome.off, outcome.step, teeth=teeth)
        if outcome.status == status.pushed_back:
            switches = switches_of(self.system.forces)
            assert switches is not None
            return dry_friction(t, switches.owner(outcome.row), switches.what(outcome.row))
        if outcome.status == status.unsolved:
            body, force = int(outcome.body), int(outcome.force)
            return unsolved_stage(t, self.system, body, force, is_near=bool(outcome.near_singular))
        if outcome.status == status.broken:
            return self._broken(t, run.broken_state)
        where = self.system.row_owner(self.row(outcome.row))
        failed = bool(outcome.projection_failed)
        return left_open(t, where, outcome.open_by, outcome.passes, projection=settings.projection, failed=failed)

    def _broken(self, t: float, y: Array) -> SimulationError:
        """What the functions of the scene say at a state where one has no value."""
        try:
            with may_overflow():
                self.require_functions(t, *self.coordinates(y))
        except SimulationError as error:
            return error
        return not_finite(t)


def march(
    compiled: Compiled, state: State, settings: Settings, tally: Tally, marks: Marks | None = None
) -> Iterator[Samples | None]:
    """Blocks of samples from the start to the end, or from a mark on; None where the kernel came back without any, so
    that its caller can look whether the run is still wanted. Raises SimulationError where the run cannot go on."""
    run, marks = compiled.run(state, settings), marks or Marks()
    if marks.resumed:
        _resume(run, tally, marks.resumed)
    run.keeps_marks = marks.wanted
    marks.newest = lambda: _mark(run, tally)
    running, most = compiled.core.Status.running, block_samples(compiled.system.bodies)
    while run.outcome.status == running:
        block = run.advance(most, RETURN_SECONDS)
        tally.set_counters(run.counters.tolist())
        tally.phases = dict(zip(PHASES, run.phase_seconds, strict=True))
        tally.position_peak = _peak(compiled, run.position_peak)
        joint_peak = _peak(compiled, run.joint_peak)
        tally.joint_peak = replace(joint_peak, row=max(joint_peak.row - compiled.system.bodies, 0))
        tally.velocity_peak = _peak(compiled, run.velocity_peak)
        _take_events(compiled.system, run, tally)
        counters = dict(zip(tally.counters(), block["counters"].T, strict=True))
        yield _samples(compiled, block, counters) if len(block["t"]) else None
    failure = compiled.failure(run, settings)
    if failure is not None:
        raise failure


def _take_events(system: System, run: Any, tally: Tally) -> None:
    """The events in the state since the last call, and what fixed steps have passed over."""
    switches = switches_of(system.forces)
    if switches is None:
        return
    tally.met += [switches.event(t, k, direction) for t, k, direction in run.take_met()]
    tally.passed = [Passed(switches.owner(k), switches.what(k), first, times) for k, first, times in run.passed]


def _resume(run: Any, tally: Tally, mark: Mark) -> None:
    """Before the first step: the run goes on from a mark. Raises InputError where it is not of this scene."""
    with resuming():
        run.resume(dict(mark))
        tally.met = restored_events(mark["met"])


def _mark(run: Any, tally: Tally) -> Mark:
    """Where a longer run can go on from."""
    mark = run.mark()
    return {**mark, "met": saved_events(tally.met, float(mark["t"]))} if mark else START


def _samples(compiled: Compiled, block: Mapping[str, Any], counters: Mapping[str, Integers]) -> Samples:
    """A block in the coordinates of all formulations; of a run that is lost it may overflow there."""
    with may_overflow():
        return compiled.samples(block, counters)


def work_of(block: Mapping[str, Any]) -> Array:
    """Work and dissipation of a block, (T, 2): zero where nothing is integrated."""
    work: Array = block["work"]
    return work if work.shape[1] else np.zeros((len(work), 2))


def _peak(compiled: Compiled, peak: Any) -> Peak:
    first = compiled.system.bodies if compiled.system.constraints > compiled.system.bodies else 0
    return Peak(peak.value, compiled.row(peak.row) if peak.value > 0.0 else first, peak.time)


def _tableau(core: ModuleType, tableau: Tableau | ImplicitTableau) -> Any:
    if isinstance(tableau, ImplicitTableau):
        coefficients = {
            name: np.ascontiguousarray(getattr(tableau, name)) for name in ("a", "b", "c", "error", "dense")
        }
        return core.Tableau.implicit(tableau.order, tableau.error_order, tableau.gamma, **coefficients)
    parts = (tableau.a, tableau.b, tableau.c, tableau.error, tableau.extra_a, tableau.extra_c, tableau.dense)
    return core.Tableau(tableau.order, tableau.error_order, *(np.ascontiguousarray(part) for part in parts))


def _steps(core: ModuleType, settings: Settings, start: float, breaks: Sequence[Break]) -> Any:
    given = [tuple(each) for each in breaks]
    if settings.step is not None:
        steps, every = whole_steps(settings), output_every(settings)
        return core.Steps.fixed(start, settings.duration, settings.step, steps, every, given)
    times = output_times(settings, start)
    return core.Steps.by_error(start, settings.duration, settings.tolerance, times, given)
