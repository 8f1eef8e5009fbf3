"""The full formulation in the kernel's loop. The kernel makes the steps in reduced coordinates, finds events, and
decides which contacts are closed or slide. Accelerations and projections are computed here, in NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple, final

import numpy as np

from mbproj.base.arrays import Array, may_overflow
from mbproj.base.errors import SimulationError
from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.constraints import set_jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.system import System
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.formulations.reduced import Reduced, space_state
from mbproj.motion.time_events import Leg, TimeWindow


class Asked(NamedTuple):
    """A state of the kernel, y at t, for which it calls NumPy. Functions of time are evaluated within `first` to
    `last`. `branches`: those of the kernel's programs, None where none are held. `rows`: pairs of a closed contact's
    number (stops, then frictions) and the value of its coordinate."""

    t: float
    y: Array
    first: float
    last: float
    branches: Array | None
    rows: tuple[tuple[int, float], ...]

    @classmethod
    def of(
        cls, t: float, y: Array, first: float, last: float, branches: Array | None, rows: list[tuple[int, float]]
    ) -> Asked:
        """Return the state from the kernel's arguments."""
        return cls(t, y, first, last, branches, tuple(rows))


@final
class FullInLoop(Reduced):
    """A system in the kernel's loop with the equations of the full formulation. `whole`: the mechanism for NumPy,
    without laws of sliding frictions. `redundant`: the number of rows that follow from the others."""

    name = "full"

    def __init__(self, core: Any, system: System, whole: System, redundant: int) -> None:
        super().__init__(core, system)
        self.whole, self.redundant = whole, redundant
        self._answers: _Answers | None = None

    def with_system(self, system: System, whole: System | None = None) -> FullInLoop:
        copy = FullInLoop(self.core, system, whole or system, self.redundant)
        copy.model.rows = self.model.rows
        return copy

    def multipliers(self, samples: Any, forces: Array | None = None) -> Array:
        """Return λ of all rows, (T, m), as the run computed them."""
        carried: Array = samples.carried
        return carried

    def projection(self, settings: ProjectionSettings) -> Any:
        """Return the settings of the projection with which the kernel solves for contacts. The kernel takes from them
        only whether rows are stabilised."""
        stabilises = PROJECTIONS[settings.method].correction in ("none", "baumgarte")
        return super().projection(settings if stabilises else replace(settings, method="gopm"))

    def run(self, state: State, settings: Settings, leg: Leg | None = None) -> Any:
        """Return the kernel's run from a state; it calls NumPy for accelerations and projections."""
        march = super().run(state, settings, leg)
        self._answers = _Answers(self, state, settings)
        march.follow_formulation(self._answers)
        return march

    def failure(self, run: Any, settings: Settings) -> SimulationError | None:
        """Return the error of a run that ended too early: that of NumPy, where NumPy had no result."""
        of_kernel = super().failure(run, settings)
        of_numpy = None if self._answers is None else self._answers.take_failure()
        return of_kernel if of_kernel is None or of_numpy is None else of_numpy


class _Answers:
    """NumPy's answers to the kernel in one run: the formulation with the rows of the closed contacts, and its row
    policy."""

    def __init__(self, compiled: FullInLoop, state: State, settings: Settings) -> None:
        self._compiled, self._state, self._settings = compiled, state, settings
        self._full: FullFormulation
        self._rows: tuple[tuple[int, float], ...] | None = None
        self._seen: tuple[float, float, bytes | None] | None = None
        self._saved: dict[str, Any] = {}
        self._arrived = False
        self._before: tuple[dict[str, Any], dict[str, Any] | None] = {}, None
        #: The error for which the current step has no result.
        self.failure: SimulationError | None = None

    def accelerate(self, asked: Sequence[Any], sliding: Array, watched: bool) -> tuple[Array, Array] | None:
        """Return (r'', ω') of the bodies, (n, 6), and λ of the joints' and motions' rows. `sliding` (S + K,): forces
        along the coordinates of stops and frictions. None where the result is not unique."""
        at = Asked.of(*asked)
        with may_overflow():
            try:
                formulation, y = self._formulation(at), self._full_y(at.y)
                terms = formulation.terms(at.t, y)
                force = self._generalized_force(formulation, y, sliding)
                Q = terms.Q + np.pad(force, (0, len(terms.Q) - len(force)))
                accelerations = terms.solved(*formulation.solve(terms.M, terms.C_q, Q, terms.gamma))
            except SimulationError as failure:
                self._fails(failure)
                return None
            except np.linalg.LinAlgError:
                self._fails(formulation.singular(at.t, *formulation.split(y)[:2]))
                return None
        if watched:
            formulation.policy.see(accelerations.nearness)
        elif self._arrived:
            formulation.policy.keep(accelerations.multipliers)
            self._arrived = False
        a, Λ = (each.reshape(-1, 7) for each in (accelerations.acceleration, formulation.split(y)[0]))
        spin_up = 2.0 * (matrix_L(Λ[:, 3:]) @ a[:, 3:, None])[..., 0]
        system, first = formulation.system, formulation.system.bodies + self._compiled.whole.joints.size
        of_contacts = slice(first, system.bodies + system.joints.size)
        multipliers = np.delete(accelerations.multipliers, of_contacts)[system.bodies :]
        return np.ascontiguousarray(np.hstack([a[:, :3], spin_up])), np.ascontiguousarray(multipliers)

    def project(self, step: int, asked: Sequence[Any]) -> tuple[Array, list[int]] | None:
        """Return the projected state of the bodies after step number `step`, and the counters. `step` is 0 for a state
        between two steps. None where the projection fails."""
        at = Asked.of(*asked)
        with may_overflow():
            try:
                formulation, y = self._formulation(at), self._full_y(at.y)
                done = formulation.project(step, at.t, y) if step else formulation.project_between(at.t, y)[1]
            except SimulationError as failure:
                self._fails(failure)
                return None
            counts = [done.projections, done.position_iterations, done.velocity_iterations]
            counts += [done.failures, done.fallbacks, int(done.left_open > THRESHOLDS.least_violation)]
            return space_state(done.q, done.v).ravel(), counts

    def _fails(self, failure: SimulationError) -> None:
        """Store the error without its traceback and causes, which would keep frames of the run alive."""
        self.failure = failure.with_traceback(None)
        failure.__cause__ = failure.__context__ = None

    def take_failure(self) -> SimulationError | None:
        """Return the stored error, if any, and delete it: once raised, it would keep frames of the run alive."""
        failure, self.failure = self.failure, None
        return failure

    def begin_step(self) -> None:
        """Begin an attempt of a step from the last accepted state."""
        self.failure = None
        if self._rows is not None:
            self._full.policy.begin()

    def enter_end(self) -> None:
        """Save the row policy before a step is accepted, for `take_back`."""
        self._before = self._saved, None if self._rows is None else dict(vars(self._full.policy))

    def arrive(self, y: Array) -> None:
        """Accept the step at its projected end y."""
        self._full.arrive(self._full.split(self._full_y(y))[0])
        self._arrived = True

    def take_back(self) -> None:
        """Restore the row policy of before the step's end: the step is repeated."""
        self._saved, policy = self._before
        if policy is None:  # an implicit step after a mark has not called NumPy in its stages
            self._rows = None
        else:
            vars(self._full.policy).update(policy)

    def save(self) -> list[float]:
        """Return the row policy as numbers: beside y, the next step depends on it."""
        if self._rows is None:
            return []
        saved = self._full.policy.save()
        before = np.nan if saved["before"] is None else saved["before"]
        head = [float(saved["redundant"]), float(saved["watching"]), before, float(len(saved["largest"]))]
        return [*head, *saved["largest"], *saved["multipliers"]]

    def resume(self, saved: list[float]) -> bool:
        """Continue from the numbers of `save`. Return True, because the kernel asks whether they fit."""
        if not saved:
            return True
        redundant, watching, before, count = saved[:4]
        self._saved = {
            "redundant": redundant,
            "watching": watching,
            "before": None if np.isnan(before) else before,
            "largest": saved[4 : 4 + int(count)],
            "multipliers": saved[4 + int(count) :],
        }
        return True

    def _formulation(self, at: Asked) -> FullFormulation:
        if at.rows != self._rows:
            self._hold(at)
        seen = at.first, at.last, None if at.branches is None else at.branches.tobytes()
        if seen != self._seen:
            self._seen = seen
            formulation = self._full.seen_within(TimeWindow(at.first, at.last))
            self._full = formulation if at.branches is None else formulation.holding(self._branches(at.branches))
        return self._full

    def _hold(self, at: Asked) -> None:
        """Make the formulation with the rows of these closed contacts."""
        stops = len(self._compiled.whole.names.stops)
        held = tuple(sorted(k for k, _ in at.rows if k < stops))
        stuck = {k - stops: value for k, value in sorted(at.rows) if k >= stops}
        system = in_contact(self._compiled.whole, Contacts(held, stuck=stuck))
        formulation = FullFormulation.of(system, self._state, self._settings, self._compiled.redundant)
        self._full, self._rows, self._seen = formulation, at.rows, None
        if self._saved:
            self._full.policy.restore(self._saved)
            self._saved = {}
        else:
            self._full.arrive(self._full.split(self._full_y(at.y))[0])

    def _full_y(self, y: Array) -> Array:
        """Return NumPy's y for the kernel's. Euler parameters are scaled to unit length, where both formulations agree
        to round-off."""
        layout, full_layout = self._compiled.layout, self._full.layout
        bodies = self._compiled.bodies_of(y).copy()
        bodies[:, 3:7] /= np.linalg.norm(bodies[:, 3:7], axis=1, keepdims=True)
        q, v = self._compiled.coordinates(bodies)
        beside = {name: y[layout[name]] for name in ("states", "followed") if full_layout.size_of(name)}
        return full_layout.vector_of({"positions": q, "velocities": v, **beside})

    def _generalized_force(self, formulation: FullFormulation, y: Array, sliding: Array) -> Array:
        """Return Q (7n,) of forces along the coordinates of stops and frictions."""
        system, pose = formulation.system, pose_of(formulation.split(y)[0])
        along_all, first = np.zeros(7 * system.bodies), 0
        for each in (system.stops, system.frictions):
            if each is not None:
                along = sliding[first : first + each.coordinates.size]
                first += len(along)
                if along.any():
                    along_all += along @ set_jacobian(each.coordinates, pose)
        return along_all

    def _branches(self, kernels: Array) -> Array:
        """Return the branches of NumPy's programs from those of the kernel's programs."""
        full, compiled = self._full.system, self._compiled.system
        starts = dict(zip(_names(compiled), compiled.programs.start.tolist(), strict=False))
        branches = np.full(len(full.programs.op), np.nan)
        for name, first, last in zip(_names(full), full.programs.start[:-1], full.programs.start[1:], strict=True):
            if name in starts:
                branches[first:last] = kernels[starts[name] : starts[name] + last - first]
        return branches


def _names(system: System) -> list[tuple[Any, ...]]:
    """Return a key for each of a system's programs: the kind of its owner, and the owner's number."""
    sizes = (system.forces.programs.size, system.states.size, system.couplings.programs.size)
    before = [(what, k) for what, count in enumerate(sizes) for k in range(count)]
    followed = [tuple(each) for each in system.following.values()]
    left = system.programs.size - len(before) - len(followed)
    return [*before, *followed, *(("motion", k) for k in range(left))]
