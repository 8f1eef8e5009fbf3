"""The equations of motion near a motion, linearised exactly, for virtual displacements ξ that change in time:

    M ξ'' + D ξ' + K ξ + Gᵀ δλ = 0,      (G ξ)'' = 0.


The residual M u' + ω × Jω + Gᵀλ - f is varied with δω = ξθ' + ω × ξθ and δω' = ξθ'' + ω × ξθ' + ω' × ξθ in body axes,
and with δs = gξ, δs' = gξ' + g'ξ and δs'' = gξ'' + 2 g'ξ' + g''ξ of any coordinate s. K holds the geometric stiffness
∂(Gᵀλ)/∂ξ, without which a pendulum has no frequency. Elements have first-order states, δx' = f_x δx + f_ξ ξ + f_ξ' ξ',
which exert forces F_xᵀ δx on the bodies.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.blocks import Blocks, Rows, added, on_diagonal, products, stacked, summed
from mbproj.dynamics.derivatives.bushing_derivatives import bushing_derivatives
from mbproj.dynamics.derivatives.law_derivatives import channel_slopes, given_derivative, given_rows, law_slopes
from mbproj.dynamics.derivatives.row_derivatives import Carried, RowMotion, force_derivative, row_motion, tilde
from mbproj.dynamics.derivatives.slip_derivatives import SlipMotion, slip_motion
from mbproj.dynamics.derivatives.tangent import accelerations, velocities
from mbproj.dynamics.equations.constraint_equations import set_bias, set_velocity
from mbproj.dynamics.equations.forces import applied, law_state
from mbproj.dynamics.equations.instant import Instant, no_states
from mbproj.dynamics.equations.kinematics import Pose, Twist, body_rates, pose_of, twist_of
from mbproj.model.channels import ChannelKind
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class MotionAtTime:
    """A mechanism at one time: t in s, coordinates q (7n,), u = (r', ω) and u' (6n,), and states of elements x (K,).

    `expected` (nc,) are the joints' coordinates, with angles known to within half a turn: they give the turns of angles
    in forces."""

    t: float
    q: Array
    u: Array
    change: Array
    expected: Array
    x: Array = field(default_factory=no_states)

    @property
    def pose(self) -> Pose:
        """The pose of the bodies."""
        return pose_of(self.q)

    def twist(self, pose: Pose) -> Twist:
        """Return the velocities of the bodies at a pose."""
        return twist_of(pose, velocities(pose, self.u))

    def change_of(self, pose: Pose) -> Twist:
        """Return the accelerations of the bodies at a pose: a `Twist` that holds q'' in place of q'."""
        return twist_of(pose, accelerations(pose, self.u, self.change))

    def instant(self, system: System) -> Instant:
        """Return the `Instant` from which functions of the system take their variables."""
        pose = self.pose
        return Instant(system, pose, self.twist(pose), self.t, self.expected, self.x)

    def carried(self) -> Carried:
        """Return r and A of the bodies with their first two time derivatives."""
        pose = self.pose
        return Carried.along(pose, self.twist(pose), self.change_of(pose))


@dataclass(frozen=True, eq=False)
class StateEquations:
    """δx' = f_x δx + f_ξ ξ + f_ξ' ξ' of the K states of elements: `by_states` (K, K), `by_displacement` and `by_rate`
    (K, 6n). `push` F_x (K, 6n): the generalised force of each state on the bodies."""

    by_states: Array
    by_displacement: Rows
    by_rate: Rows
    push: Rows


@dataclass(frozen=True, eq=False)
class LinearEquations:
    """M, D and K (6n, 6n); G, G' and G'' (m, 6n), the rows of the joints and motions along the motion; and the
    equations of the states. `slip`: the derivative of the rows at velocity level by the pose, None without such
    rows."""

    M: Blocks
    D: Blocks
    K: Blocks
    rows: RowMotion
    states: StateEquations
    slip: SlipMotion | None = None


def linear_equations(system: System, motion: MotionAtTime, multipliers: Array) -> LinearEquations:
    """Return the equations near a motion with the multipliers λ (m,) of the joints' rows and then the motions'."""
    carried, n = motion.carried(), system.bodies
    parts = [_inertia(system, motion), _reflected(system, motion, carried), _forces(system, motion, carried)]
    constraint, rows = force_derivative(system.rows, carried, multipliers), row_motion(system.rows, carried)
    viscous, elastic, states = channel_equations(system, motion)
    M, D, K = (added(n, [part[order] for part in parts]) for order in range(3))
    slip = slip_motion(system.rows, carried) if system.rolls else None
    return LinearEquations(M, added(n, [D, viscous]), added(n, [K, constraint, elastic]), rows, states, slip)


def channel_equations(system: System, motion: MotionAtTime) -> tuple[Blocks, Blocks, StateEquations]:
    """Return the parts of D and K from forces that name channels, and the equations of the states. A function counts as
    constant where it has no slope."""
    n, channels, none = system.bodies, system.channels, added(system.bodies, [])
    if not channels.size:
        empty = stacked(n, []).combined(np.zeros((len(motion.x), 0)))
        return none, none, StateEquations(np.zeros((len(motion.x),) * 2), empty, empty, empty)
    instant, carried = motion.instant(system), motion.carried()
    coordinates = row_motion(system.coordinates, carried)
    of_forces, of_states = channel_slopes(instant)
    pulls = [row_motion(system.forces.laws.coordinates, carried).G, given_rows(system.forces, instant.pose)]
    states, angles, rates = (
        ((channels.kind == kind)[:, None] & (channels.index[:, None] == np.arange(size))).astype(float)
        for kind, size in (
            (ChannelKind.STATE, len(motion.x)),
            (ChannelKind.COORDINATE, system.coordinates.size),
            (ChannelKind.RATE, system.coordinates.size),
        )
    )
    G, G_rate, G_dot = coordinates.G.combined(angles), coordinates.G.combined(rates), coordinates.G_dot.combined(rates)
    pushed, every = stacked(n, pulls).combined(-of_forces.T), np.ones(channels.size)
    return (
        products(pushed, G_rate, every),
        added(n, [products(pushed, G, every), products(pushed, G_dot, every)]),
        StateEquations(
            of_states @ states,
            summed([G.combined(of_states), G_dot.combined(of_states)]),
            G_rate.combined(of_states),
            pushed.combined(-states.T),
        ),
    )


def constraint_rows(system: System, motion: MotionAtTime) -> Rows:
    """Return G of the joints' rows and then the motions', (m, 6n)."""
    return row_motion(system.rows, motion.carried()).G


def mass_blocks(system: System, motion: MotionAtTime) -> Blocks:
    """Return diag(m I, J) in (δr, δθ in body axes) with reflected inertias, (6n, 6n)."""
    parts = [_inertia(system, motion)[0], _reflected(system, motion, motion.carried())[0]]
    return added(system.bodies, parts)


def tangent_force(system: System, motion: MotionAtTime) -> Array:
    """Return f - M u' less all terms quadratic in the velocities, (6n,), in (N, N m in body axes) of each body.

    The constraints have to balance it. Raises SimulationError where a force has no finite value."""
    pose = motion.pose
    twist, change = motion.twist(pose), motion.change_of(pose)
    ω, ω_dot = (body_rates(pose, moving)[:-1] for moving in (twist, change))
    J = system.inertia
    momentum = (J @ ω[..., None])[..., 0]
    force = system.mass[:, None] * (system.gravity - change.velocity[:-1])
    torque = -(J @ ω_dot[..., None])[..., 0] - np.cross(ω, momentum)
    loads = applied(motion.instant(system))
    wrenches = np.concatenate([force + loads.force[:-1], torque + loads.torque[:-1]], axis=1).ravel()
    if system.reflected.size:
        rows = system.reflected.rows
        s_ddot = set_velocity(rows, pose, change) + set_bias(rows, pose, twist)
        g = row_motion(rows, motion.carried()).G.matrix()
        wrenches = wrenches - g.T @ (system.reflected.inertia * s_ddot)
    return wrenches


def _inertia(system: System, motion: MotionAtTime) -> tuple[Blocks, Blocks, Blocks]:
    """Return M, D and K of the bodies' own inertia."""
    n, J = system.bodies, system.inertia
    ω, ω_dot = (part.reshape(n, 6)[:, 3:] for part in (motion.u, motion.change))
    spin = tilde(ω)
    gyroscopic = spin @ J - tilde((J @ ω[..., None])[..., 0])
    M, D, K = np.zeros((n, 6, 6)), np.zeros((n, 6, 6)), np.zeros((n, 6, 6))
    M[:, :3, :3] = system.mass[:, None, None] * np.eye(3)
    M[:, 3:, 3:] = J
    D[:, 3:, 3:] = J @ spin + gyroscopic
    K[:, 3:, 3:] = J @ tilde(ω_dot) + gyroscopic @ spin
    return on_diagonal(M), on_diagonal(D), on_diagonal(K)


def _reflected(system: System, motion: MotionAtTime, carried: Carried) -> tuple[Blocks, Blocks, Blocks]:
    """Return M, D and K of reflected inertias, which exert -I s'' on their coordinates."""
    reflected, pose = system.reflected, motion.pose
    g = row_motion(reflected.rows, carried)
    s_ddot = set_velocity(reflected.rows, pose, motion.change_of(pose))
    s_ddot = s_ddot + set_bias(reflected.rows, pose, motion.twist(pose))
    inertia = reflected.inertia
    bent = force_derivative(reflected.rows, carried, inertia * s_ddot)
    return (
        products(g.G, g.G, inertia),
        products(g.G, g.G_dot, 2.0 * inertia),
        added(system.bodies, [products(g.G, g.G_ddot, inertia), bent]),
    )


def _forces(system: System, motion: MotionAtTime, carried: Carried) -> tuple[Blocks, Blocks, Blocks]:
    """Return M, D and K of the scene's forces; gravity is constant in these coordinates."""
    none = added(system.bodies, [])
    forces, bound, instant = system.forces, system.forces.laws.coordinates, motion.instant(system)
    state = law_state(instant)
    stiffness, damping = law_slopes(instant, state)
    g, viscous, elastic = row_motion(bound, carried), none, none
    if forces.bushings.size:
        viscous, elastic = bushing_derivatives(forces, instant.pose, instant.twist, state.force)
    return (
        none,
        added(system.bodies, [products(g.G, g.G, -damping), viscous]),
        added(
            system.bodies,
            [
                elastic,
                products(g.G, g.G, -stiffness),
                products(g.G, g.G_dot, -damping),
                force_derivative(bound, carried, state.force[: bound.size]).scaled(-1.0),
                given_derivative(instant).scaled(-1.0),
            ],
        ),
    )
