"""What a motion in the full formulation keeps: its energy balance and momenta, held after each step."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.energy import kinetic_energy, potential_energy
from mbproj.dynamics.equations.equations_of_motion import mass_matrix
from mbproj.dynamics.equations.forces import law_state
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.dynamics.rank.row_set import in_lengths
from mbproj.dynamics.symmetries import rigid_fields
from mbproj.model.system import System
from mbproj.projection import Method, Projected, Projection
from mbproj.projection.solve.invariants import Kept, corrected
from mbproj.scene.records import ProjectionSettings
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.integrate.formulations.full import FullFormulation


@dataclass
class Balance:
    """Scratch of a run: what is `kept`, y where the step at hand began, and whether that was refused.

    `fields` (k, 6): the rigid motions whose momenta are kept."""

    system: System
    method: Projection
    energy: bool
    fields: Array
    kept: Kept
    before: Array | None = None
    refused: bool = False

    @classmethod
    def of(cls, system: System, state: State, method: Method, settings: ProjectionSettings) -> Balance | None:
        """That of a run from a state; None where no row is asked for, or nothing is kept or free to move."""
        if not (settings.energy or settings.momentum) or not isinstance(method, Projection):
            return None
        fields = np.zeros((0, 6))
        if settings.momentum:
            from mbproj.integrate.formulations.invariants import momenta_of

            fields = momenta_of(system, state)
        if not (settings.energy or len(fields)):
            return None
        return cls(system, method, settings.energy, fields, Kept())

    def begin(self, formulation: FullFormulation, t: float, y: Array) -> None:
        """A new balance begins at y at t."""
        q, v, _ = formulation.parts(y)
        self.kept.energy = self._energy(formulation, formulation.instant(t, y), y)
        self.kept.momenta = self.fields @ rigid_fields(q) @ mass_matrix(self.system, pose_of(q)) @ v

    def after_step(
        self, formulation: FullFormulation, t: float, before: Array, y: Array, projected: Projected
    ) -> Projected:
        """The state after a step from `before` to y at t, which the joints' rows moved to `projected`."""
        if not projected.velocity_iterations or projected.failures:
            return projected
        closing = formulation.change(formulation.parts(y)[1], projected.v)
        closed = formulation.layout.changed(y, {"positions": projected.q, "velocities": projected.v})
        return replace(projected, v=self._after_step(formulation, t, before, closed, closing))

    def _after_step(self, formulation: FullFormulation, t: float, before: Array, y: Array, closing: float) -> Array:
        """v (7n,) of y, which is closed, corrected; the joints' rows changed the velocities by the part `closing`."""
        kept = self.kept
        kept.closing = max(kept.closing, closing)
        self.before = before
        v = formulation.parts(y)[1]
        change, missing, part = self._change(formulation, t, y)
        # Without rows of joints nothing tells how much a step errs.
        limit = THRESHOLDS.row_refused * max(kept.closing, THRESHOLDS.row_grain)
        self.refused = part > limit and self.system.constraints > self.system.bodies
        if self.refused:
            kept.refused += 1
            return v
        if missing is None:
            kept.rested += 1
            return np.asarray(v + change)
        kept.held += 1
        kept.given, kept.moved = kept.given + missing, kept.moved + abs(missing)
        kept.furthest = max(kept.furthest, abs(kept.given))
        kept.largest = max(kept.largest, part)
        return np.asarray(v + change)

    def inside_step(self, formulation: FullFormulation, t: float, y: Array, projected: Projected) -> Array:
        """A closed state y inside the step, corrected though its extension errs by more; nothing is counted."""
        if self.refused or self.before is None or not projected.velocity_iterations or projected.failures:
            return y
        v = formulation.parts(y)[1] + self._change(formulation, t, y)[0]
        return formulation.layout.changed(y, {"velocities": v})

    def _change(self, formulation: FullFormulation, t: float, y: Array) -> tuple[Array, float | None, float]:
        """The change of v (7n,), its energy in J, None where that is singular, and its part of v."""
        q, v, expected = formulation.parts(y)
        if not self._speed(formulation, y) > THRESHOLDS.row_rests * self._changed(formulation, y):
            return np.zeros_like(v), None, 0.0
        instant = formulation.instant(t, y)
        missing = self.kept.energy - self._energy(formulation, instant, y) if self.energy else None
        held = formulation.policy.rows.to_move(instant.pose, formulation.drive(t, expected))
        M, fields = mass_matrix(self.system, instant.pose), self.fields @ rigid_fields(q)
        change, is_regular = corrected(self.method, M, held.C_q, v, missing, fields, self.kept.momenta)
        size = np.linalg.norm(in_lengths(self.system, change)) / np.linalg.norm(in_lengths(self.system, v))
        return change, (missing or 0.0) if is_regular else None, float(size)

    def _changed(self, formulation: FullFormulation, y: Array) -> float:
        """By how much the step has changed the velocities, in the bodies' axes, as a speed."""
        assert self.before is not None
        change, system = np.zeros((2, self.system.bodies, 3)), self.system
        for sign, at in ((1.0, y), (-1.0, self.before)):
            q, v, _ = formulation.parts(at)
            twist = twist_of(pose := pose_of(q), v)
            change += sign * np.array([twist.velocity[:-1], body_rates(pose, twist)[:-1]])
        moved = np.sum(system.mass * np.sum(change[0] ** 2, axis=-1))
        return float(np.sqrt(moved + np.einsum("bi,bij,bj", change[1], system.inertia, change[1])))

    def _speed(self, formulation: FullFormulation, y: Array) -> float:
        """√(vᵀMv) of the bodies."""
        q, v, _ = formulation.parts(y)
        return float(np.sqrt(v @ mass_matrix(formulation.bodies, pose_of(q)) @ v))

    def _energy(self, formulation: FullFormulation, instant: Instant, y: Array) -> float:
        """E = T + V - W of what conserves it and what does work."""
        system, work = self.system, y[formulation.layout["quadratures"]]
        found = kinetic_energy(system, instant.pose, instant.twist) + potential_energy(system, instant.pose)
        if not system.forces.is_empty:
            found = found + law_state(instant, formulation.held).stored
        return float(found - (work[0] - work[1] if len(work) else 0.0))
