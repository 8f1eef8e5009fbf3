"""The full formulation as an initial value problem: y = (q, q', ...), y' = (q', q'', ...) from Eq. 14 or Eqs. 80-81.

The layout names the other blocks of y: states of elements, the work of forces, joint coordinates that are followed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple, final

import numpy as np

from mbproj.base.arrays import Array, Integers, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.bearings import supports
from mbproj.equations.constraints import constraint, constraint_velocity, gamma, jacobian
from mbproj.equations.forces import applied, generalised, law_state, state_rates, unit_pull
from mbproj.equations.friction import Jammed, settled_loads
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.motions import Drive, drive_at
from mbproj.equations.of_motion import SOLVERS, HeldRows, Solver, generalised_force, mass_matrix, with_flywheels
from mbproj.equations.rank.row_policy import RowPolicy
from mbproj.equations.rank.row_space import independent
from mbproj.equations.turning import Teeth, driven_to, sums_at_start
from mbproj.model.forces import NO_REFLECTED, Forces
from mbproj.model.layout import Layout
from mbproj.model.system import System
from mbproj.motion.failures import ill_conditioned, jammed, not_finite, singular
from mbproj.motion.law_switches import on_branches
from mbproj.motion.projection import Method, ProjectedState, Projection, make_method, project_after
from mbproj.motion.time_events import TimeWindow


class Accelerations(NamedTuple):
    """q'' (7n,), λ (m,), and the `power` in W of forces and motions, of dampers, and of separate losses of laws, (2 +
    apart,); empty without any.

    `nearness`: the pose's distance from a singular one, as a part of the largest of the run."""

    acceleration: Array
    multipliers: Array
    power: Array
    nearness: float


@dataclass(frozen=True, eq=False)
class Terms:
    """M, C_q, Q and γ; each reflected inertia has a coordinate and a row of its own after those of `held`. `lasting`
    (m,): multipliers of combinations that are not held. `power` (2,) of forces, and the rates of motions, `driven`."""

    M: Array
    C_q: Array
    Q: Array
    gamma: Array
    held: HeldRows
    lasting: Array
    power: Array
    driven: Array

    def solved(self, acceleration: Array, multipliers: Array) -> Accelerations:
        """Return the accelerations and the multipliers of all rows for a solution of Eq. 14 in these terms."""
        rows, size = self.held.C_q.shape
        spread = self.held.multipliers(multipliers[:rows]) + self.lasting
        power = self.power
        if len(self.driven):
            power = power - np.append(spread[-len(self.driven) :] @ self.driven, np.zeros(len(power) - 1))
        return Accelerations(acceleration[:size], spread, power, self.held.nearness)


@final
@dataclass(frozen=True, eq=False)
class FullFormulation:
    """Constants of a run. `method`: the projection method. `sums`: the teeth at the start of gears and screws.
    `window`: where functions of time are evaluated. `held`: the branches on which laws are held."""

    system: System
    settings: Settings
    method: Method
    policy: RowPolicy
    sums: Array
    bodies: System  # the system without reflected inertias
    window: TimeWindow
    held: Array | None = None
    on_branches: System | None = None  # the system with its rows and laws on these branches

    @classmethod
    def of(cls, system: System, state: State, settings: Settings, redundant: int = 0) -> FullFormulation:
        """Return a run's formulation. Raises InputError where the projection method refuses the mass matrix."""
        method = make_method(settings.projection)
        if isinstance(method, Projection) and (reason := method.refusal(mass_matrix(system, pose_of(state.q)))):
            raise InputError(reason)
        start = state.instant(system)
        sums = sums_at_start(system, start.pose, start.expected)
        bodies, policy = replace(system, reflected=NO_REFLECTED), RowPolicy(system, redundant)
        return cls(system, settings, method, policy, sums, bodies, TimeWindow())

    @property
    def layout(self) -> Layout:
        """The layout of y."""
        return self.system.integrated

    def split(self, y: Array) -> tuple[Array, Array, Array]:
        """Return q (7n,), q' (7n,) and the joints' coordinates that are followed, all or none."""
        layout = self.layout
        return y[layout["positions"]], y[layout["velocities"]], y[layout["followed"]]

    def state(self, t: float, y: Array, turns: Integers) -> State:
        """Return the state at y, with the whole turns (nc,) of the joints' coordinates."""
        return State.of(self.system, t, **self.layout.common_blocks(y, self.system.layout), turns=turns)

    def drive(self, t: float, expected: Array) -> Drive:
        """Return the values that motions prescribe, with the teeth in mesh at the joints' coordinates `expected`,
        (nc,). Accelerations, which may jump, are evaluated within the window; positions and rates at t."""
        drive = drive_at(self.system, t, Teeth(self.sums, expected) if self.system.couplings.size else None)
        seen = self.window.clip(t)
        inside = drive if seen == t else drive_at(self.system, seen)
        return replace(drive, acceleration=inside.acceleration)

    def seen_within(self, window: TimeWindow) -> FullFormulation:
        """Return the formulation with another window."""
        return replace(self, window=window)

    def holding(self, held: Array) -> FullFormulation:
        """Return the formulation with these branches."""
        return replace(self, held=held, on_branches=on_branches(self.system, held))

    def derivative(self, t: float, y: Array) -> Array:
        """Return y' at y, with the rows of the current step."""
        return self._derivative(t, y)[0]

    def watched_derivative(self, t: float, y: Array) -> Array:
        """Return y' at a stage of a step. The policy records the pose's distance from a singular one."""
        slope, nearness = self._derivative(t, y)
        self.policy.see(nearness)
        return slope

    def _derivative(self, t: float, y: Array) -> tuple[Array, float]:
        instant = self.instant(t, y)
        accelerations = self.accelerations(t, y, instant=instant)
        return self.slope(t, y, accelerations, instant), accelerations.nearness

    def slope(self, t: float, y: Array, accelerations: Accelerations, instant: Instant | None = None) -> Array:
        """Return y' at y with these accelerations."""
        instant, (_, v, expected) = instant or self.instant(t, y), self.split(y)
        rates = {
            "positions": v,
            "velocities": accelerations.acceleration,
            "states": state_rates(instant, self.held) if self.system.states.size else np.zeros(0),
            "quadratures": accelerations.power,
            "followed": instant.speed if len(expected) else expected,
        }
        return self.layout.vector_of(rates)

    def instant(self, t: float, y: Array, expected: Array | None = None) -> Instant:
        """Return the `Instant` at y. `expected` (nc,): joints' coordinates in place of those that are followed."""
        q, v, followed = self.split(y)
        pose = pose_of(q)
        near, system = followed if expected is None else expected, self.on_branches or self.system
        return Instant(system, pose, twist_of(pose, v), self.window.clip(t), near, y[self.layout["states"]])

    def accelerations(
        self, t: float, y: Array, expected: Array | None = None, instant: Instant | None = None
    ) -> Accelerations:
        """Return the accelerations with the rows of the current step. Equal input gives equal bits. `expected` (nc,):
        the joints' coordinates, angles to within half a turn, in place of those that are followed. Raises
        SimulationError where the equations have no unique solution, or an expression no value."""
        terms = self.terms(t, y, instant or self.instant(t, y, expected))
        try:
            return terms.solved(*self.solve(terms.M, terms.C_q, terms.Q, terms.gamma))
        except np.linalg.LinAlgError as error:
            raise self.singular(t, *self.split(y)[:2]) from error

    @property
    def solve(self) -> Solver:
        """The solver of Eq. 14."""
        return SOLVERS[self.settings.acceleration]

    def terms(self, t: float, y: Array, instant: Instant | None = None) -> Terms:
        """Return the terms of Eq. 14 at a state, in the rows that are held. Raises as `accelerations` does."""
        instant = instant or self.instant(t, y)
        system, rows = instant.system, replace(self.policy.rows, system=instant.system)
        (q, v, _), pose, twist, drive = self.split(y), instant.pose, instant.twist, self.drive(t, instant.expected)
        rhs = gamma(system, pose, twist, drive)
        if self.method.stabilises:
            C, C_dot = constraint(system, pose, drive), constraint_velocity(system, pose, twist, drive)
            rhs = self.method.stabilised(rhs, C, C_dot)
        force, power = generalised_force(self.bodies, pose, twist), np.zeros(self.layout.size_of("quadratures"))
        if not system.forces.is_empty:
            loads = applied(instant, self.held)
            force = force + generalised(pose, loads.force, loads.torque)
            power += [loads.power, loads.dissipation, *loads.apart]
        try:
            held = rows.to_move(pose, drive, v)
        except np.linalg.LinAlgError as error:
            raise self.singular(t, q, v) from error
        lasting, exerted = held.lasting(rows.multipliers)
        parts = mass_matrix(self.bodies, pose), held.C_q, force + exerted, held.combined(rhs)
        if system.reflected.size:
            parts = with_flywheels(system.reflected, pose, twist, *parts)
        terms = Terms(*parts, held, lasting, power, drive.rate)
        if not (system.forces.laws.bearing >= 0).any():
            return terms
        return self._with_bearings(terms, system.forces, instant, t)

    def _with_bearings(self, terms: Terms, forces: Forces, instant: Instant, t: float) -> Terms:
        """Return the terms with friction that depends on loads of bearings. Raises SimulationError where it is not
        unique."""
        system, bearings, pose = self.system, self.system.bearings, instant.pose
        assert bearings is not None
        whole, viscous = (law_state(instant, self.held, each).damper for each in (np.ones(bearings.size), None))
        pulls = np.zeros((bearings.size, len(terms.Q)))
        for law in np.flatnonzero(forces.laws.bearing >= 0):
            pull = generalised(pose, *unit_pull(forces, pose, int(law)))
            pulls[forces.laws.bearing[law], : len(pull)] += (whole[law] - viscous[law]) * pull
        without, none = terms.solved(*self.solve(terms.M, terms.C_q, terms.Q, terms.gamma)), np.zeros(len(terms.gamma))
        held_multipliers = [self.solve(terms.M, terms.C_q, pull, none)[1] for pull in pulls]
        responses = np.array([terms.held.multipliers(each[: len(terms.held.C_q)]) for each in held_multipliers])
        base, more = (
            supports(system, bearings, pose, multipliers[..., system.bodies :])
            for multipliers in (without.multipliers, responses)
        )
        try:
            carried = settled_loads(bearings, base, more)
        except Jammed as error:
            raise jammed(t, system, error.bearing) from error
        loads = applied(instant, self.held, carried)
        return replace(
            terms, Q=terms.Q + carried @ pulls, power=np.array([loads.power, loads.dissipation, *loads.apart])
        )

    def project(self, step: int, t: float, y: Array) -> ProjectedState:
        """Return the state at y after step number `step`, projected according to the settings."""
        projected = self._projected(step, self.settings.projection, t, y)
        self.policy.see(projected.nearest)
        return projected

    def project_between(self, t: float, y: Array) -> tuple[Array, ProjectedState]:
        """Return a state between two steps, projected on the levels that the settings switch on; and the projection."""
        projected = self._projected(1, replace(self.settings.projection, every=1, threshold=None), t, y)
        return self.layout.changed(y, {"positions": projected.q, "velocities": projected.v}), projected

    def _projected(self, step: int, settings: ProjectionSettings, t: float, y: Array) -> ProjectedState:
        q, v, expected = self.split(y)
        if not isinstance(self.method, Projection):
            return ProjectedState(q, v)
        try:
            drive, rows = self.drive(t, expected), self.policy.rows
            return project_after(step, self.system, self.method, settings, q, v, drive, rows)
        except np.linalg.LinAlgError as error:
            raise self.singular(t, q, v) from error

    def lead(self, t: float, y: Array) -> Array:
        """Return y at a time, with driven joint coordinates at the values of their motions."""
        expected = self.split(y)[2]
        if not len(expected):
            return y
        return self.layout.changed(y, {"followed": driven_to(self.system, expected, drive_at(self.system, t).value)})

    def violations(self, t: float, q: Array, v: Array, expected: Array) -> tuple[Array, Array]:
        """Return |C| and |C'|, row by row, (m,)."""
        system, pose, drive = self.system, pose_of(q), self.drive(t, expected)
        twist = twist_of(pose, v)
        return np.abs(constraint(system, pose, drive)), np.abs(constraint_velocity(system, pose, twist, drive))

    def arrive(self, q: Array) -> float:
        """Record an accepted pose; return the smallest distance in the step from a singular one."""
        return self.policy.advance(jacobian(self.system, pose_of(q)))

    def check_regular(self, t: float, q: Array) -> None:
        """Raise SimulationError that names the joint where C_q has lost its rank at the start."""
        if not self.policy.rows.redundant and not independent(self.system, pose_of(q)).all():
            raise self.singular(t, q)

    def singular(self, t: float, q: Array, v: Array | None = None) -> SimulationError:
        """Return the error for equations without a unique solution at a state."""
        with may_overflow():
            rows = jacobian(self.system, pose_of(q))
        if not np.all(np.isfinite(rows)) or not (v is None or np.all(np.isfinite(v))):
            return not_finite(t)
        free = independent(self.system, pose_of(q))
        if free.all() and not self.policy.rows.redundant:
            return ill_conditioned(t, penalty=self.settings.projection.alpha)
        return singular(t, self.system.row_owner(int(np.argmin(free))))
