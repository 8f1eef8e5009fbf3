"""What the forces of a scene do at a state: forces and torques on the bodies, potential energy, power.

A law gives a generalised force F on a coordinate s(q): on every point and vector that s binds it acts with F ∂s/∂x, so
that its power is F s'. Springs keep energy, dampers lose it; what functions of a scene give is work done.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array, Integers, Numbers, cross
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.kinematics import Pose, Twist, attached, body_rates, slots_of
from mbproj.errors import SimulationError
from mbproj.functions.series import constant_series, failure, run, time_series
from mbproj.model.forces import Forces
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class LawState:
    """The coordinates of the laws, their rates, and the force of each law's spring, damper and function, (..., E)."""

    value: Numbers
    rate: Numbers
    spring: Numbers
    damper: Numbers
    given: Numbers

    @property
    def force(self) -> Numbers:
        """F, (..., E), in N or N m."""
        return self.spring + self.damper + self.given


@dataclass(frozen=True, eq=False)
class Applied:
    """Forces (n+1, 3) in N at the centres of mass in global axes, and torques (n+1, 3) in N m about them in body axes;
    the power in W of what functions give, and the power that dampers lose."""

    force: Array
    torque: Array
    power: float
    dissipation: float


def law_state(forces: Forces, pose: Pose, twist: Twist, t: Numbers | float, reference: Numbers) -> LawState:
    """The laws at poses (...) and times t (...).

    `reference` (..., nc): the joints' coordinates, each to less than half a turn, from which angles take their turns.
    """
    laws = forces.laws
    value = laws.coordinates.value(attached(pose, *slots_of(laws.coordinates)))
    turns = np.round((reference[..., laws.joint_coordinate] - value) / (2.0 * np.pi)) if laws.is_angle.any() else 0.0
    value = value + 2.0 * np.pi * laws.is_angle * turns
    with np.errstate(divide="ignore", invalid="ignore"):  # two points that have met are noticed by `applied`
        rate = set_velocity(laws.coordinates, pose, twist)
    given = np.zeros_like(value)
    time = time_series(np.broadcast_to(np.asarray(t, dtype=float), value.shape[:-1]))
    for law in np.flatnonzero(laws.program >= 0):
        variables = [time, constant_series(value[..., law]), constant_series(rate[..., law])]
        given[..., law] = run(forces.programs, int(laws.program[law]), variables)[0]
    return LawState(value, rate, -laws.stiffness * (value - laws.free), -laws.damping * rate, given)


def potential_of_springs(forces: Forces, state: LawState) -> Numbers:
    """½ Σ k (s - free)² in J, shape (...)."""
    return 0.5 * np.sum(forces.laws.stiffness * (state.value - forces.laws.free) ** 2, axis=-1)


def applied(system: System, pose: Pose, twist: Twist, t: float, reference: Array) -> Applied:
    """All forces of the scene but gravity, on every body and the ground, at one state.

    Raises SimulationError that names the force whose function has no finite value there, or that has no direction.
    """
    forces = system.forces
    assert forces is not None
    state = law_state(forces, pose, twist, t, reference)
    if not np.all(np.isfinite(state.force)):
        raise _law_fails(forces, state, t)
    force, torque = _of_laws(forces, pose, state.force)
    given_force, given_torque = _on_bodies(forces, pose, t)
    omega = body_rates(pose, twist)
    power = np.sum(given_force * twist.velocity) + np.sum(given_torque * omega) + state.given @ state.rate
    return Applied(force + given_force, torque + given_torque, float(power), -float(state.damper @ state.rate))


def generalised(pose: Pose, force: Array, torque: Array) -> Array:
    """Q (7n,) of forces (n+1, 3), global, and torques (n+1, 3), body axes: (F, 2 Lᵀτ / |Λ|²) for each body."""
    norm2 = np.sum(pose.orientation * pose.orientation, axis=-1)[:, None]
    turning = 2.0 * (np.swapaxes(pose.L, -1, -2) @ torque[..., None])[..., 0] / norm2
    return np.concatenate([force, turning], axis=-1)[:-1].ravel()


def unit_pull(forces: Forces, pose: Pose, law: int) -> tuple[Array, Array]:
    """Forces and torques on every body and the ground, as in `Applied`, of a force of size 1 on the coordinate of one
    law."""
    size = np.zeros(forces.laws.size)
    size[law] = 1.0
    return _of_laws(forces, pose, size)


def _of_laws(forces: Forces, pose: Pose, size: Numbers) -> tuple[Array, Array]:
    """Every attachment of a law of size F (E,) is pulled with F ∂s/∂x."""
    bound = forces.laws.coordinates
    gradient = bound.gradient_entries(attached(pose, *slots_of(bound)))
    pull = size[bound.entry_row, None] * gradient
    body, local = bound.body[bound.entry_slot], bound.local[bound.entry_slot]
    force, torque = np.zeros_like(pose.position), np.zeros_like(pose.position)
    np.add.at(force, body, bound.is_point[bound.entry_slot, None] * pull)
    np.add.at(torque, body, cross(local, _in_body(pose, body, pull)))
    return force, torque


def _on_bodies(forces: Forces, pose: Pose, t: float) -> tuple[Array, Array]:
    """The given forces and torques."""
    given = forces.on_bodies
    force, torque = np.zeros_like(pose.position), np.zeros_like(pose.position)
    if not given.size:
        return force, torque
    time = time_series(np.asarray(t))
    vector = np.array([[run(forces.programs, index, [time])[0] for index in row] for row in given.program])
    if not np.all(np.isfinite(vector)):
        raise _program_fails(forces, int(given.program[~np.isfinite(vector)][0]), t, 0.0, 0.0)
    carried = (given.turn @ vector[..., None])[..., 0]
    turned = (pose.rotation[given.body] @ carried[..., None])[..., 0]
    vector = np.where(given.in_body[:, None], turned, vector)
    np.add.at(force, given.body, np.where(given.is_torque[:, None], 0.0, vector))
    in_body = _in_body(pose, given.body, vector)
    np.add.at(torque, given.body, np.where(given.is_torque[:, None], in_body, cross(given.point, in_body)))
    return force, torque


def _in_body(pose: Pose, body: Integers, vector: Array) -> Array:
    """Global vectors (e, 3) in the axes of bodies (e,)."""
    return (vector[:, None, :] @ pose.rotation[body])[:, 0, :]


def _law_fails(forces: Forces, state: LawState, t: float) -> SimulationError:
    law = int(np.flatnonzero(~np.isfinite(state.force))[0])
    program = int(forces.laws.program[law])
    value, rate = float(state.value[law]), float(state.rate[law])
    if program >= 0 and np.isfinite(value) and np.isfinite(rate):
        return _program_fails(forces, program, t, value, rate)
    where = f"force '{forces.law_owners[law]}'"
    if value == 0.0:
        return SimulationError(t, "its two points have met, and it has no direction", where=where, hint="move one")
    return SimulationError(t, "the solution is no longer finite", where=where, hint="try a smaller step or tolerance")


def _program_fails(forces: Forces, index: int, t: float, value: float, rate: float) -> SimulationError:
    variables = [time_series(np.asarray(t)), constant_series(np.asarray(value)), constant_series(np.asarray(rate))]
    cause = f"'{forces.programs.texts[index]}' fails: {failure(forces.programs, index, variables)}"
    hint = "correct the expression, or end the run before that time"
    return SimulationError(t, cause, where=f"force '{forces.program_owners[index]}'", hint=hint)
