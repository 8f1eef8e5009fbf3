"""Conservation in the full formulation: the energy balance and momenta, which are corrected after each step."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.equations_of_motion import mass_matrix
from mbproj.dynamics.equations.forces import law_state
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.dynamics.equations.round_off import EPSILON
from mbproj.dynamics.observe.total_energy import kinetic_energy
from mbproj.dynamics.symmetries import rigid_fields
from mbproj.model.system import System
from mbproj.projection import Method, ProjectedState, Projection
from mbproj.projection.solve.invariants import BalanceScratch, corrected
from mbproj.scene.records import ProjectionSettings
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.integrate.formulations.full import FullFormulation


@dataclass
class Balance:
    """The balance of one run: the conserved quantities `kept`, y at the start of the current step, and whether its
    correction was refused.

    `fields` (k, 6): the rigid motions whose momenta are conserved."""

    system: System
    method: Projection
    energy: bool
    fields: Array
    kept: BalanceScratch
    before: Array | None = None
    refused: bool = False

    @classmethod
    def of(cls, system: System, state: State, method: Method, settings: ProjectionSettings) -> Balance | None:
        """Return the balance of a run from a state; None where none is asked for, or nothing is conserved or free to
        move."""
        if not (settings.energy or settings.momentum) or not isinstance(method, Projection):
            return None
        fields = np.zeros((0, 6))
        if settings.momentum:
            from mbproj.integrate.formulations.invariants import momenta_of

            fields = momenta_of(system, state)
        if not (settings.energy or len(fields)):
            return None
        return cls(system, method, settings.energy, fields, BalanceScratch())

    def begin(self, formulation: FullFormulation, t: float, y: Array) -> None:
        """Begin a new balance at y and t."""
        q, v, _ = formulation.split(y)
        self.kept.energy, _ = self._energy(formulation, formulation.instant(t, y), y)
        self.kept.momenta = self.fields @ rigid_fields(q) @ mass_matrix(self.system, pose_of(q)) @ v

    def after_step(
        self, formulation: FullFormulation, t: float, before: Array, y: Array, projected: ProjectedState
    ) -> ProjectedState:
        """Return the state after a step from `before` to y at t, which the joints' rows moved to `projected`."""
        self.before, self.refused = before, False
        if not projected.velocity_iterations or projected.failures:
            return projected
        closed = formulation.layout.changed(y, {"positions": projected.q, "velocities": projected.v})
        return replace(projected, v=self._after_step(formulation, t, closed))

    def _after_step(self, formulation: FullFormulation, t: float, y: Array) -> Array:
        """Return the corrected v (7n,) of a closed y. A correction that is larger than a step's error is refused, and a
        new balance begins."""
        kept, v = self.kept, formulation.split(y)[1]
        change, missing, part, self.refused = self._change(formulation, t, y)
        if self.refused:
            kept.refused += 1
            self.begin(formulation, t, y)
            return v
        if missing is None:
            kept.rested += 1
            return np.asarray(v + change)
        kept.held += 1
        kept.given, kept.moved = kept.given + missing, kept.moved + abs(missing)
        kept.furthest = max(kept.furthest, abs(kept.given))
        kept.largest = max(kept.largest, part)
        return np.asarray(v + change)

    def inside_step(self, formulation: FullFormulation, t: float, y: Array, projected: ProjectedState) -> Array:
        """Return a closed state y inside the step with corrected velocities. The limit for corrections does not apply,
        because the extension has a larger error; nothing is counted."""
        if self.refused or self.before is None or not projected.velocity_iterations or projected.failures:
            return y
        v = formulation.split(y)[1] + self._change(formulation, t, y)[0]
        return formulation.layout.changed(y, {"velocities": v})

    def _change(self, formulation: FullFormulation, t: float, y: Array) -> tuple[Array, float | None, float, bool]:
        """Return the change of v (7n,), its energy in J, its size divided by that of v, and whether it is larger than a
        step's error. The energy is None where the energy row is singular."""
        q, v, expected = formulation.split(y)
        now, by_step = self._speed(formulation, q, v), self._changed(formulation, y)
        if not now > THRESHOLDS.row_rests * by_step:
            return np.zeros_like(v), None, 0.0, False
        instant = formulation.instant(t, y)
        energy, grain = self._energy(formulation, instant, y)
        missing = self.kept.energy - energy if self.energy else None
        held = formulation.policy.rows.to_move(instant.pose, formulation.drive(t, expected))
        M, fields = mass_matrix(self.system, instant.pose), self.fields @ rigid_fields(q)
        tolerated = max(THRESHOLDS.half_digits, THRESHOLDS.row_tolerated * (formulation.settings.tolerance or 0.0))
        error = tolerated * float(np.abs(y[formulation.layout["quadratures"]][:2]).sum())  # error of the energy
        change, is_regular = corrected(self.method, M, held.C_q, v, missing, fields, self.kept.momenta, grain, error)
        part = self._speed(formulation, q, change) / now
        scale = self._speed(formulation, q, formulation.layout.scale[formulation.layout["velocities"]])
        limit = max(THRESHOLDS.row_refused * by_step, tolerated * (scale + now)) / now
        return change, (missing or 0.0) if is_regular else None, part, part > limit

    def _changed(self, formulation: FullFormulation, y: Array) -> float:
        """Return √(ΔvᵀM Δv) for the change Δv of the velocities in the step, with ω in the bodies' axes."""
        assert self.before is not None
        change, system = np.zeros((2, self.system.bodies, 3)), self.system
        for sign, at in ((1.0, y), (-1.0, self.before)):
            q, v, _ = formulation.split(at)
            twist = twist_of(pose := pose_of(q), v)
            change += sign * np.array([twist.velocity[:-1], body_rates(pose, twist)[:-1]])
        moved = np.sum(system.mass * np.sum(change[0] ** 2, axis=-1))
        return float(np.sqrt(moved + np.einsum("bi,bij,bj", change[1], system.inertia, change[1])))

    def _speed(self, formulation: FullFormulation, q: Array, v: Array) -> float:
        """Return √(vᵀMv) of the bodies."""
        return float(np.sqrt(max(float(v @ mass_matrix(formulation.bodies, pose_of(q)) @ v), 0.0)))

    def _energy(self, formulation: FullFormulation, instant: Instant, y: Array) -> tuple[float, float]:
        """Return T + V - W + D and its round-off, in J. V is stored by gravity and forces, and W and D are the work and
        the losses in y."""
        system, work = self.system, y[formulation.layout["quadratures"]]
        kinetic = kinetic_energy(system, instant.pose, instant.twist)
        weight = -system.mass * (instant.pose.position[:-1] @ system.gravity)
        stored = [] if system.forces.is_empty else [law_state(instant, formulation.held).stored]
        terms = np.array([kinetic, *weight, *stored, *(work[:2] * [-1.0, 1.0] if len(work) else ())])
        return float(terms.sum()), THRESHOLDS.round_off_grains * EPSILON * float(np.abs(terms).sum())
