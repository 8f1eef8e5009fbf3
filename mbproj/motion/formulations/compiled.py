"""A run in the compiled kernel: the common part of reduced and planar coordinates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, final

import numpy as np

from mbproj.base.arrays import Array, Integers, contiguous, may_overflow
from mbproj.base.errors import SimulationError
from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.equations.assembly.assemble import State, turns_of
from mbproj.equations.forces import require_values
from mbproj.equations.motions import drive_at
from mbproj.equations.samples import Motion, Samples
from mbproj.model.layout import Layout
from mbproj.model.planar.plane import Plane
from mbproj.model.system import System
from mbproj.motion.steppers.tableau import tableau_of
from mbproj.motion.time_events import Leg, kernel_steps, kernel_tableau

PHASES = ("accelerations", "position projection", "velocity projection", "rest")


class Recorded(NamedTuple):
    """A system in the kernel's coordinates, before a run: the layout of the kernel's y, the system's numbers of the
    kernel's joints, which are those with rows, and the record of its model."""

    layout: Layout
    joints: list[int]
    model: Mapping[str, Any]


class Compiled(ABC):
    """A system in the kernel's coordinates. `dimension` is the prefix of the kernel's classes, Space or Plane. Each has
    a model of its own, because a run chooses the rows that its model holds."""

    name: ClassVar[str]
    dimension: ClassVar[str]
    #: The plane of planar coordinates.
    plane: Plane | None = None

    def __init__(self, core: Any, system: System, recorded: Recorded) -> None:
        self.core, self.system, self.layout = core, system, recorded.layout
        self.model = getattr(core, f"{self.dimension}Model")(**recorded.model)
        self._joints = recorded.joints
        self._equations: Any = None  # with the rows of the run
        #: The projection for which the model's usual rows were found: a penalty has more rows.
        self.settled = ProjectionSettings()

    def hold(self, rows: Any) -> None:
        """Set the rows that the model holds at most poses."""
        self.model.rows = rows
        self._equations = None

    @abstractmethod
    def with_system(self, system: System, whole: System | None = None) -> Compiled:
        """Return these coordinates for a system with other forces. `whole` is the mechanism without laws of frictions
        and stops."""

    @property
    @abstractmethod
    def degrees_of_freedom(self) -> int:
        """The degrees of freedom that the independent rows leave."""

    @property
    @abstractmethod
    def row_scale(self) -> Array:
        """The scales of the kernel's rows: the system's length, or 1 rad, (m,)."""

    @abstractmethod
    def state(self, q: Array, v: Array) -> Array:
        """Return the kernel's state (..., n, 13 or 6) from q and v = q' (..., 7n)."""

    def samples(self, block: Mapping[str, Any], counters: Mapping[str, Integers]) -> Samples:
        """Return a block of the kernel in the coordinates of all formulations."""
        y, work = block["y"], block["y"][:, self.layout["quadratures"]]
        return Samples(
            t=block["t"],
            motion=_InKernel(self, y, block["acceleration"], block["angles"]),
            carried=block["multipliers"],
            solved=self.multipliers,
            step_size=block["step_size"],
            work=work if work.shape[1] else np.zeros((len(y), 2)),
            counters=counters,
        )

    @abstractmethod
    def motion(self, bodies: Array) -> tuple[Array, Array]:
        """Return q and q' (T, 7n) at states of the kernel's bodies (T, n, 13 or 6)."""

    @abstractmethod
    def acceleration(self, bodies: Array, acceleration: Array) -> Array:
        """Return q'' (T, 7n) at states of the kernel's bodies with their accelerations (T, n, 6 or 3)."""

    @abstractmethod
    def multipliers(self, samples: Samples, forces: Array | None = None) -> Array:
        """Return λ of all rows at samples, (T, m), of a run in the kernel. `forces` (T, S + K) along the coordinates of
        stops and frictions may be added; None for no such forces."""

    @abstractmethod
    def turns(self, turns: Integers) -> Integers:
        """Return whole turns of the kernel's coordinates from those of the system's (nc,)."""

    @abstractmethod
    def of_all(self, of_kernel: Array) -> Array:
        """Return angles or whole turns of the system's coordinates (.., nc) from those of the kernel's."""

    def standing(self, t: float, y: Array, turns: Sequence[int]) -> State:
        """Return the state of a mark of the kernel."""
        q, v = self.coordinates(self.bodies_of(y))
        return State(t, self.states(y, q, v, self.of_all(np.array(turns, dtype=float))), self.system.layout)

    def bodies_of(self, y: Array) -> Array:
        """Return the bodies' states (..., n, 13 or 6) at the kernel's y (..., its size)."""
        return y[..., self.layout["bodies"]].reshape(*y.shape[:-1], self.system.bodies, -1)

    def coordinates(self, bodies: Array) -> tuple[Array, Array]:
        """Return q and v (7n,) at one state of the kernel's bodies, (n, 13 or 6)."""
        q, v = self.motion(bodies[None])
        return q[0], v[0]

    def states(self, y: Array, q: Array, v: Array, turns: Array) -> Array:
        """Return the system's y (..., N) from the kernel's (..., its size), with these positions, velocities and
        turns."""
        beside = self.layout.common_blocks(y, self.system.layout)
        return self.system.layout.vector_of({"positions": q, "velocities": v, "turns": turns, **beside})

    def joint(self, number: int) -> int:
        """Return the system's number of one of the kernel's joints; motions follow the joints, and then reflected
        inertias."""
        beyond = number - len(self._joints)
        return self._joints[number] if beyond < 0 else len(self.system.names.joints) + beyond

    @abstractmethod
    def row(self, number: int) -> int:
        """Return the row of the system's C (norm rows first) for one of the kernel's rows."""

    @abstractmethod
    def coordinate(self, number: int) -> int:
        """Return the system's number of one of the kernel's coordinates."""

    def equations(self, projection: ProjectionSettings | None = None) -> Any:
        """Return the kernel's equations at single states, with the rows of the run unless a projection is given."""
        if projection is not None:
            return self._equations_with(self.projection(projection))
        if self._equations is None:
            is_penalty = PROJECTIONS[self.settled.method].correction == "penalty"
            taken = self.projection(self.settled) if is_penalty else self.core.Projection(self.core.Correction.mass)
            self._equations = self._equations_with(taken)
        return self._equations

    def _equations_with(self, projection: Any) -> Any:
        """Return equations with the kernel's settings of a projection."""
        return getattr(self.core, f"{self.dimension}Equations")(self.model, projection)

    def owner(self, number: int) -> str | None:
        """Return the owner of one of the kernel's joints, for messages: "joint 'A'", "motion 'm'"."""
        if number < 0:
            return None
        joint, joints = self.joint(number), self.system.names.joints
        if joint >= len(joints) + self.system.driven:
            return "a joint's reflected inertia"
        if joint >= len(joints):
            return f"motion '{self.system.names.motions[joint - len(joints)]}'"
        return f"joint '{joints[joint]}'"

    def is_regular(self, state: State) -> tuple[bool, int]:
        """Return whether the accelerations are unique at a state, and else the kernel's joint whose rows depend on
        others (-1 where no joint is the cause). Raises SimulationError where a function of the scene has no value."""
        equations, instant = self.equations(), state.instant(self.system)
        beside = [*self.turns(instant.expected).tolist(), *state.x.tolist()]
        if equations.accelerations(self.state(state.q, state.v), state.t, beside) is not None:
            return True, -1
        self.require_functions(state)
        return False, int(equations.singular_joint)

    def responses(self, state: State, laws: Integers) -> Array | None:
        """Return W of `mbproj.equations.fast_modes` for these laws, (e, e); None where it is not unique."""
        y = contiguous(self.state(state.q, state.v))
        of_laws: Array | None = self.equations().responses(y, laws.tolist(), state.t)
        return of_laws

    def require_functions(self, state: State) -> None:
        """Raise SimulationError that names the force, motion, state or controller whose function has no value."""
        drive_at(self.system, state.t)
        require_values(state.instant(self.system))

    def run(self, state: State, settings: Settings, leg: Leg | None = None) -> Any:
        """Return the kernel's run from a state."""
        run = self.core.Run(
            self.model,
            kernel_tableau(self.core, tableau_of(settings.integrator), kinematic=settings.kinematic is True),
            self.projection(settings.projection),
            kernel_steps(self.core, settings, leg or Leg.whole(self.system, settings, state.t)),
            self.beginning(state),
            contiguous(self.turns(state.turns), dtype=np.int64),
        )
        self._keep(run, state, settings)
        return run

    def beginning(self, state: State) -> Array:
        """Return the kernel's initial y (its size,) of a run from `state`."""
        bodies = self.state(state.q, state.v).ravel()
        return self.layout.vector_of({"bodies": bodies} | state.layout.common_blocks(state.y, self.layout))

    def _keep(self, run: Any, state: State, settings: Settings) -> None:
        """Add rows for conserved quantities to the run, where the settings ask for them and the mechanism has a degree
        of freedom."""
        projection, free = settings.projection, self.degrees_of_freedom > 0
        if not (free and PROJECTIONS[projection.method].corrects and (projection.energy or projection.momentum)):
            return
        fields = np.zeros((0, 3 if self.dimension == "Plane" else 6))
        if projection.momentum:
            from mbproj.motion.formulations.invariants import momenta_of

            fields = momenta_of(self.system, state, self.rigid_fields)
        if projection.energy or len(fields):
            run.keep(projection.energy, fields, settings.tolerance or 0.0)

    @abstractmethod
    def rigid_fields(self, q: Array) -> Array:
        """Return q' (k, 7n) at q of the rigid motions of all bodies that these coordinates have: shifts, then turns
        about axes through the origin."""

    def projection(self, settings: ProjectionSettings) -> Any:
        """Return the projection's settings as the kernel takes them."""
        taken = self.core.Projection(getattr(self.core.Correction, PROJECTIONS[settings.method].correction))
        if settings.gains is not None:
            taken.alpha, taken.beta = settings.gains
        for name in ("alpha", "tolerance", "threshold"):
            if (option := getattr(settings, name)) is not None:
                setattr(taken, name, option)
        taken.paper_test = settings.test == "paper"
        taken.every, taken.max_iterations = settings.every, settings.max_iterations
        taken.position, taken.velocity = settings.position, settings.velocity
        taken.fallback = settings.fallback == "gopm"
        return taken

    def failure(self, run: Any, settings: Settings) -> SimulationError | None:
        """Return the error of a run with these settings that ended too early; None for a run that reached its end."""
        outcome, status, t = run.outcome, self.core.Status, float(run.outcome.time)
        if outcome.status in (status.running, status.finished):
            return None
        from mbproj.motion import failures

        if outcome.status == status.not_finite or not np.isfinite(outcome.open_by):
            return failures.not_finite(t)
        if settings.kinematic is True and outcome.status in (status.vanished, status.singular, status.unsolved):
            from mbproj.motion.failures import branch_untold

            return branch_untold(t)
        if outcome.status == status.vanished:
            return failures.step_vanished(t)
        if outcome.status == status.singular:
            return failures.singular(t, self.owner(outcome.joint))
        if outcome.status == status.branch:
            return (failures.other_branch if outcome.near_singular else failures.LostStep)(t, outcome.velocity_change)
        if outcome.status == status.unresolved:
            return failures.unresolved(t, outcome.velocity_change)
        if outcome.status == status.untold:
            name = self.system.names.coordinates[self.coordinate(outcome.coordinate)]
            return failures.TurnsUntold(
                t, name, outcome.turned, outcome.off, outcome.step, teeth=self.system.couplings.size > 0
            )
        if outcome.status == status.pushed_back:
            from mbproj.motion.law_switches import switches_of

            switches, k = switches_of(self.system), int(outcome.row)
            assert switches is not None
            return failures.pushed_back(t, switches.owner(k), switches.what(k), jumps=switches.jumps(k))
        if outcome.status == status.jammed:
            return failures.jammed_law(t, self.system, int(outcome.row))
        if outcome.status == status.off_rope:
            return failures.off_rope(
                t, self.system, self.coordinate(outcome.row), outcome.rope_centre, outcome.rope_span
            )
        if outcome.status == status.overlap:
            names = self.system.names
            gap = outcome.row >= 0 and names.coordinates[self.coordinate(outcome.row)].rpartition(".")[0]
            return failures.overlap(t, gap or names.joints[self.joint(outcome.joint)])
        if outcome.status == status.unsolved:
            body, force = int(outcome.body), int(outcome.force)
            unsolved = failures.unsolved_stage(t, self.system, body, force, is_near=bool(outcome.near_singular))
            return unsolved if settings.step is None else failures.halved_in_vain(unsolved, float(run.standing["h"]))
        if outcome.status == status.broken:
            return self._broken(t, run)
        where = self.system.row_owner(self.row(outcome.row))
        by, passes, failed = outcome.open_by, outcome.passes, bool(outcome.projection_failed)
        return failures.left_open(t, where, by, passes, projection=settings.projection, failed=failed)

    def _broken(self, t: float, run: Any) -> SimulationError:
        """Return the error of the functions of the scene at a state where one has no value."""
        from mbproj.motion import failures

        try:
            with may_overflow():
                self.require_functions(self.standing(t, run.broken_state, run.standing["turns"]))
        except SimulationError as error:
            return error
        return failures.not_finite(t)


@final
class _InKernel(Motion):
    """The motion of a block of the kernel in the coordinates of all formulations. A diverged run may overflow."""

    def __init__(self, compiled: Compiled, y: Array, acceleration: Array, angles: Array) -> None:
        self._compiled, self._y, self._acceleration, self._angles = compiled, y, acceleration, angles
        self.layout = compiled.system.layout

    @cached_property
    def _bodies(self) -> Array:
        return self._compiled.bodies_of(self._y)

    @cached_property
    def _moved(self) -> tuple[Array, Array]:
        with may_overflow():
            q, v = self._compiled.motion(self._bodies)
        return np.asfortranarray(q, like=q), np.asfortranarray(v, like=v)

    @property
    def q(self) -> Array:
        return self._moved[0]

    @property
    def v(self) -> Array:
        return self._moved[1]

    @cached_property
    def acceleration(self) -> Array:
        with may_overflow():
            change = self._compiled.acceleration(self._bodies, self._acceleration)
        return np.asfortranarray(change, like=change)

    @property
    def x(self) -> Array:
        return self._y[:, self._compiled.layout["states"]]

    @cached_property
    def y(self) -> Array:
        return self._at(slice(None))

    def state(self, t: float, at: int) -> State:
        """Return the state of one sample. It is computed as two equal ones, which have the bits of a block."""
        return State(t, self._at(np.array([at, at]))[0], self.layout)

    def _at(self, rows: Integers | slice) -> Array:
        """Return the states of some samples."""
        compiled, q = self._compiled, self.q[rows]
        with may_overflow():
            turns = turns_of(compiled.system, q, compiled.of_all(self._angles[rows]))
            return compiled.states(self._y[rows], q, self.v[rows], turns)
