"""The equations of motion near a motion, linearised exactly, for virtual displacements ξ that change in time:

    M ξ'' + D ξ' + K ξ + Gᵀ δλ = 0,      (G ξ)'' = 0.


The residual M u' + ω × Jω + Gᵀλ - f is varied with δω = ξθ' + ω × ξθ and δω' = ξθ'' + ω × ξθ' + ω' × ξθ in body axes,
and with δs = gξ, δs' = gξ' + g'ξ and δs'' = gξ'' + 2 g'ξ' + g''ξ of any coordinate s. K holds the geometric stiffness
∂(Gᵀλ)/∂ξ, without which a pendulum has no frequency. Elements have first-order states, δx' = f_x δx + f_ξ ξ + f_ξ' ξ',
which exert forces F_xᵀ δx on the bodies.
"""

from __future__ import annotations

from dataclasses import field
from itertools import combinations

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.equations.blocks import Blocks, Rows, added, on_diagonal, products, stacked, summed
from mbproj.equations.constraints import set_bias, set_velocity, tangent_entries
from mbproj.equations.forces import (
    Deflection,
    LawState,
    applied,
    deflected,
    given_components,
    law_coordinates,
    law_state,
    rates,
    viscous,
)
from mbproj.equations.instant import Instant, no_states
from mbproj.equations.kinematics import Pose, Twist, body_rates, pose_of, twist_of
from mbproj.equations.tangent_space import accelerations, velocities
from mbproj.functions.program import CHANNELS, COORDINATE, RATE
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import slope, slopes
from mbproj.joints.primitives.basic import Primitive
from mbproj.model.channels import ChannelKind
from mbproj.model.euler_parameters import matrix_L, rotation_matrix
from mbproj.model.forces import COORDINATES, Bushings, Forces
from mbproj.model.primitive_set import Group, PrimitiveSet
from mbproj.model.system import System

# --- Derivatives of primitives ----------------------------------------------------------------------------------------
# Derivatives of a set of primitives along the tangent coordinates of the bodies that they bind.
# A slot's point or vector x moves by δx = B ξ with B = [1, -A s~] of (δr, δθ), or [0, -A s~] of a vector; a row of G
# is g = ∂C/∂x B. Along a motion, ξ constant,
#
#    g'  = (C_xx x') B + C_x B',      g'' = (C_xx x'' + C_xxx x' x') B + 2 (C_xx x') B' + C_x B'',
# And a generalised force gᵀw changes by ∂(gᵀw)/∂ξ = Bᵀ (w C_xx) B + s~ (Aᵀ w C_x)~, the last in the turns. The
# primitives define all of it: C_xx follows from their curvature by polarisation, and C_xxx is the complex step of
# their curvature, exact to round-off (Squire and Trapp 1998).


#: A complex step, whose square vanishes beside 1.
COMPLEX_STEP = 1e-100
#: The step of differences of order 6, in m and in parts of a unit vector: truncation and round-off are both near 1e-13.
DIFFERENCE = 5e-3


@dataclass(frozen=True, eq=False)
class Carried:
    """r (n+1, 3) and A (n+1, 3, 3) of the n bodies and the ground, each with its first and second time derivative."""

    position: tuple[Array, Array, Array]
    rotation: tuple[Array, Array, Array]

    @classmethod
    def along(cls, pose: Pose, twist: Twist, change: Twist) -> Carried:
        """Return the values along a motion; `change` is a `Twist` that holds q'' in place of q'."""
        return cls(
            (pose.position, twist.velocity, change.velocity),
            (pose.rotation, twist.rotation_dot, change.rotation_dot + twist.rotation_bias),
        )

    def slots(self, bound: PrimitiveSet, order: int) -> Array:
        """Return x, x' or x'' of a set's points and vectors, (S, 3), for order 0, 1 or 2."""
        turned = (self.rotation[order][bound.body] @ bound.local[..., None])[..., 0]
        return np.asarray(turned + bound.is_point[:, None] * self.position[order][bound.body], dtype=float)

    def maps(self, bound: PrimitiveSet, order: int) -> Array:
        """Return B, B' or B'', (S, 3, 6), for order 0, 1 or 2."""
        of_twists = np.zeros((len(bound.body), 3, 6))
        if order == 0:
            of_twists[:, :, :3] = bound.is_point[:, None, None] * np.eye(3)
        of_twists[:, :, 3:] = -self.rotation[order][bound.body] @ tilde(bound.local)
        return of_twists


def tilde(vectors: Array) -> Array:
    """Return a~ with a~ b = a × b, (..., 3, 3)."""
    matrices = np.zeros((*vectors.shape, 3), dtype=vectors.dtype)
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    matrices[..., 0, 1], matrices[..., 0, 2], matrices[..., 1, 2] = -z, y, -x
    matrices[..., 1, 0], matrices[..., 2, 0], matrices[..., 2, 1] = z, -y, x
    return matrices


def second_derivatives(primitive: Primitive, x: Array) -> Array:
    """Return ∂g/∂x (k, rows, 3s, 3s) of the gradient g at x (k, s, 3): the quadratic form `curvature`, polarised. For a
    primitive that is not integrable it is the complex step of g."""
    size = x.shape[-2] * 3
    if not primitive.integrable:
        steps = 1j * COMPLEX_STEP * np.eye(size).reshape(size, 1, -1, 3)
        values = primitive.gradient(x + steps).imag / COMPLEX_STEP
        return np.moveaxis(np.asarray(values.reshape(*values.shape[:-2], size)), 0, -1)
    unit = np.eye(size).reshape(size, 1, -1, 3)
    pairs = np.array(list(combinations(range(size), 2))).reshape(-1, 2).T
    directions = np.concatenate([unit, unit[pairs[0]] + unit[pairs[1]]])
    with np.errstate(divide="ignore", invalid="ignore"):  # two points may coincide here: the caller checks the result
        values = primitive.curvature(np.broadcast_to(x, (len(directions), *x.shape)), directions + np.zeros_like(x))
    hessian = np.zeros((*values.shape[1:], size, size))
    every = np.arange(size)
    hessian[..., every, every] = np.moveaxis(values[:size], 0, -1)
    mixed = 0.5 * (values[size:] - values[pairs[0]] - values[pairs[1]])
    hessian[..., pairs[0], pairs[1]] = hessian[..., pairs[1], pairs[0]] = np.moveaxis(mixed, 0, -1)
    return hessian


def third_derivatives(primitive: Primitive, x: Array, x_dot: Array) -> Array:
    """Return ∂²g/∂x² x' x', (k, rows, 3s), of the gradient g at x and x' (k, s, 3)."""
    size = x.shape[-2] * 3
    if not primitive.integrable:
        bent = turned_derivatives(primitive, x, x_dot) @ x_dot.reshape(len(x), 1, -1, 1)
        return np.asarray(bent[..., 0], dtype=float)
    steps = 1j * COMPLEX_STEP * np.eye(size).reshape(size, 1, -1, 3)
    values = primitive.curvature(x + steps, np.broadcast_to(x_dot, (size, *x.shape)).astype(complex))
    return np.moveaxis(np.asarray(values.imag) / COMPLEX_STEP, 0, -1)


def turned_derivatives(primitive: Primitive, x: Array, x_dot: Array) -> Array:
    """Return the derivative of ∂g/∂x along x', (k, rows, 3s, 3s), of a primitive that is not integrable. It is a
    central difference of order 6 of exact values."""
    h = DIFFERENCE / max(float(np.abs(x_dot).max()), np.finfo(float).tiny)
    terms = [
        weight * (second_derivatives(primitive, x + k * h * x_dot) - second_derivatives(primitive, x - k * h * x_dot))
        for k, weight in enumerate((3 / 4, -3 / 20, 1 / 60), 1)
    ]
    return np.asarray(sum(terms) / h, dtype=float)


def force_derivative(bound: PrimitiveSet, carried: Carried, weight: Array) -> Blocks:
    """Return ∂(gᵀw)/∂ξ at constant w (m,), one for each row."""
    x, maps = carried.slots(bound, 0), carried.maps(bound, 0)
    turn = carried.rotation[0][bound.body]
    bodies = len(carried.position[0]) - 1
    parts = []
    for group in bound.groups:
        slots, w = group.slots, weight[group.rows]
        k, s = slots.shape
        bend = np.einsum("kr,krij->kij", w, second_derivatives(group.primitive, x[slots])).reshape(k, s, 3, s, 3)
        blocks = np.einsum("kaiu,kaibj,kbjv->kabuv", maps[slots], bend, maps[slots], optimize=True)
        pull = np.einsum("kr,krai->kai", w, group.primitive.gradient(x[slots]))
        in_body = np.einsum("kaji,kaj->kai", turn[slots], pull)
        every = np.arange(s)
        blocks[:, every, every, 3:, 3:] += tilde(bound.local[slots]) @ tilde(in_body)
        row, column = np.broadcast_arrays(bound.body[slots][:, :, None], bound.body[slots][:, None, :])
        parts.append(Blocks.of(bodies, row.ravel(), column.ravel(), blocks.reshape(-1, 6, 6)))
    return added(bodies, parts)


def rows_at(bound: PrimitiveSet, pose: Pose) -> Rows:
    """Return g of a set's rows at a pose, (m, 6n), with a tenth of the work of `row_motion`."""
    body, entries = tangent_entries(bound, pose)
    return Rows.of(bound.size, len(pose.position) - 1, bound.entry_row, body, entries[:, :6])


@dataclass(frozen=True, eq=False)
class RowMotion:
    """g of a set's rows along a motion, and its first and second time derivatives: G, G' and G'', (m, 6n) each."""

    G: Rows
    G_dot: Rows
    G_ddot: Rows


def row_motion(bound: PrimitiveSet, carried: Carried) -> RowMotion:
    """Return the rows of a set along a motion."""
    orders = [_group_motion(bound, group, carried) for group in bound.groups]
    joined = [np.concatenate([np.zeros((0, 6)), *(part[order] for part in orders)]) for order in range(3)]
    body, bodies = bound.body[bound.entry_slot], len(carried.position[0]) - 1
    return RowMotion(*(Rows.of(bound.size, bodies, bound.entry_row, body, value) for value in joined))


def _group_motion(bound: PrimitiveSet, group: Group, carried: Carried) -> tuple[Array, Array, Array]:
    """Return g, g' and g'' of the entries of one group, (e, 6) each, in the order of the set's entries."""
    slots, primitive = group.slots, group.primitive
    x, x_dot, x_ddot = (carried.slots(bound, order)[slots] for order in range(3))
    B, B_dot, B_ddot = (carried.maps(bound, order)[slots] for order in range(3))
    k, s = slots.shape
    shape = (k, group.rows.shape[1], s, 3)
    C_x = primitive.gradient(x)
    C_xx = second_derivatives(primitive, x)
    C_x_dot = (C_xx @ x_dot.reshape(k, 1, 3 * s, 1)).reshape(shape)
    C_x_ddot = (C_xx @ x_ddot.reshape(k, 1, 3 * s, 1)).reshape(shape)
    C_x_ddot += third_derivatives(primitive, x, x_dot).reshape(shape)
    g = _times(C_x, B)
    g_dot = _times(C_x_dot, B) + _times(C_x, B_dot)
    g_ddot = _times(C_x_ddot, B) + 2.0 * _times(C_x_dot, B_dot) + _times(C_x, B_ddot)
    return g.reshape(-1, 6), g_dot.reshape(-1, 6), g_ddot.reshape(-1, 6)


def _times(gradient: Array, maps: Array) -> Array:
    """Return gradients (k, rows, s, 3) times the slots' maps (k, s, 3, 6)."""
    return np.einsum("krai,kaiu->krau", gradient, maps)


# --- The derivatives of the forces of bushings ------------------------------------------------------------------------
# With f = gᵀF, F = preload - k s - c s', g the gradients of the coordinates, and the damping c along them, which
# depends on the pose,
#
#    δf = -gᵀ k g ξ - gᵀ c (g ξ' + g' ξ) - gᵀ (∂c/∂ξ s') ξ + ∂(gᵀF)/∂ξ, the last with F held,
# Where g' and the derivatives of g and c are complex steps, exact to round-off (Squire and Trapp 1998).


@dataclass(frozen=True, eq=False)
class _BushingBodies:
    """Positions (B, 2, 3) and Euler parameters (B, 2, 4) of the two bodies of each bushing."""

    bushings: Bushings
    position: Array
    orientation: Array

    @classmethod
    def pose(cls, bushings: Bushings, pose: Pose) -> _BushingBodies:
        return cls(bushings, pose.position[bushings.body], pose.orientation[bushings.body])

    def deflect(self, shift: Numbers, turn: Numbers) -> tuple[Deflection, Numbers]:
        """Return the deflection at changed positions and Euler parameters, and g (..., B, 6, 12) by (δr, δθ in body
        axes) of both bodies."""
        orientation = self.orientation + turn
        deflection = deflected(self.bushings, self.position + shift, orientation)
        size = np.sum(orientation * orientation, axis=-1)[..., None, None]
        in_body = deflection.gradient[..., 3:] @ (rotation_matrix(orientation) / size)
        sides = np.concatenate([deflection.gradient[..., :3], in_body], axis=-1)
        return deflection, np.concatenate([sides[..., 0, :, :], sides[..., 1, :, :]], axis=-1)


def bushing_gradient(bushings: Bushings, pose: Pose) -> Array:
    """Return g (B, 6, 12): s' = g (r', ω) of both bodies."""
    return _at_pose(bushings, pose)[1]


def bushing_derivatives(forces: Forces, pose: Pose, twist: Twist, force: Array) -> tuple[Blocks, Blocks]:
    """Return the parts of D and K that come from bushings. `force` (F,) are the forces along all coordinates; those of
    bushings come last."""
    bushings, at = forces.bushings, _BushingBodies.pose(forces.bushings, pose)
    count = bushings.size
    deflection, g = _at_pose(bushings, pose)
    rate, damping = rates(bushings, deflection, pose, twist), viscous(bushings, deflection)
    moving = 1j * COMPLEX_STEP * twist.velocity[bushings.body], 1j * COMPLEX_STEP * twist.rate[bushings.body]
    g_dot = at.deflect(*moving)[1].imag / COMPLEX_STEP
    steps = 1j * COMPLEX_STEP * np.eye(12).reshape(12, 1, 2, 6)  # of the first body, then of the second
    turns = 0.5 * (np.swapaxes(matrix_L(at.orientation), -1, -2) @ steps[..., 3:, None])[..., 0]
    moved, bent = at.deflect(steps[..., :3], turns)  # bent (12, B, 6, 12)
    bushing_force = force[forces.laws.size :].reshape(count, len(COORDINATES))
    geometric = np.einsum("ebcu,bc->bue", bent.imag / COMPLEX_STEP, bushing_force)
    thicker = np.einsum("ebcd,bd->bce", viscous(bushings, moved).imag / COMPLEX_STEP, rate)
    transposed = np.swapaxes(g, -1, -2)
    D = transposed @ damping @ g
    K = transposed @ (bushings.stiffness @ g + damping @ g_dot + thicker) - geometric
    return _blocks(bushings, len(pose.position) - 1, D), _blocks(bushings, len(pose.position) - 1, K)


def _at_pose(bushings: Bushings, pose: Pose) -> tuple[Deflection, Array]:
    return _BushingBodies.pose(bushings, pose).deflect(np.zeros(3), np.zeros(4))


def _blocks(bushings: Bushings, bodies: int, matrices: Array) -> Blocks:
    """Return the matrices (B, 12, 12) over the two bodies of each bushing as blocks."""
    value = matrices.reshape(-1, 2, 6, 2, 6).swapaxes(2, 3).reshape(-1, 6, 6)
    row, column = np.repeat(bushings.body, 2, axis=1).ravel(), np.tile(bushings.body, 2).ravel()
    return Blocks.of(bodies, row, column, value)


# --- Derivatives of the forces of laws, of given forces, and of the rates of elements' states -------------------------
# A law has slopes ∂F/∂s, ∂F/∂s' and slopes by the channels that it names. A given force changes because its arm and
# its axes turn with the body.


def law_slopes(instant: Instant, laws: LawState) -> tuple[Array, Array]:
    """Return ∂F/∂s and ∂F/∂s' of each law, (E,) each; not finite where a function has no slope."""
    forces = instant.system.forces
    by_variable = [-forces.laws.stiffness, -forces.laws.damping]
    for law in np.flatnonzero(forces.laws.program >= 0):
        at = instant.values(laws.value[law], laws.rate[law])
        for order, variable in enumerate((COORDINATE, RATE)):
            by_variable[order][law] += slope(forces.programs, int(forces.laws.program[law]), at, variable)
    return by_variable[0], by_variable[1]


def channel_slopes(instant: Instant) -> tuple[Array, Array]:
    """Return the derivatives by channels: of forces, (E + 3G, c), and of the rates x' of elements' states, (K, c).

    Forces are those of the E laws, and then the three components of each of G given forces. Without a slope a function
    counts as constant. The slope by a law's own coordinate, which is no channel, is in `law_slopes`."""
    forces, programs, rates = instant.system.forces, instant.system.programs, _rates_by_channels(instant)
    value, rate = law_coordinates(instant)
    of_laws = np.zeros((forces.laws.size, rates.shape[1]))
    for law in np.flatnonzero(forces.laws.program >= 0).tolist():
        of_laws[law] = slopes_by_channels(
            programs, int(forces.laws.program[law]), instant.values(value[law], rate[law])
        )
    on_bodies = [
        slopes_by_channels(programs, each, instant.values()) for each in forces.on_bodies.program.ravel().tolist()
    ]
    all_slopes = np.concatenate([of_laws, np.array(on_bodies).reshape(-1, rates.shape[1])])
    return tuple(np.nan_to_num(part, nan=0.0, posinf=0.0, neginf=0.0) for part in (all_slopes, rates))  # type: ignore[return-value]


def state_slopes(instant: Instant) -> Array:
    """Return f_x (K, K) of x' = f; where it has no slope a function counts as constant."""
    channels, slopes = instant.system.channels, _rates_by_channels(instant)
    matrix = np.zeros((len(slopes), len(slopes)))
    known = np.nan_to_num(slopes[:, channels.is_state], nan=0.0, posinf=0.0, neginf=0.0)
    matrix[:, channels.index[channels.is_state]] = known
    return matrix


def _rates_by_channels(instant: Instant) -> Array:
    """Return ∂x'/∂channel, (K, c)."""
    first, at = instant.system.first_rate, instant.values()
    rows = [slopes_by_channels(instant.system.programs, first + row, at) for row in range(instant.x.shape[-1])]
    return np.array(rows, dtype=float).reshape(len(rows), len(at) - CHANNELS)


def slopes_by_channels(programs: ProgramSet, program: int, at: list[Numbers]) -> Array:
    """Return the slopes of a program by each channel, (c,), at values of all variables; 0 for a channel it does not
    name."""
    by_channels, named = np.zeros(len(at) - CHANNELS), programs.channels(program)
    by_channels[named - CHANNELS] = slopes(programs, program, at, named)
    return by_channels


def given_rows(forces: Forces, pose: Pose) -> Rows:
    """Return the generalised force of a unit of each of the three components of each given force and torque, (3W,
    6n)."""
    on_bodies, turn = forces.on_bodies, pose.rotation[forces.on_bodies.body]
    # The three directions of each, (W, 3, 3), in body axes.
    unit = np.where(on_bodies.in_body[:, None, None], np.swapaxes(on_bodies.turn, -1, -2), turn)
    value = np.concatenate([np.zeros_like(unit), unit], axis=-1)
    moment, acts = np.cross(on_bodies.point[:, None, :], unit), ~on_bodies.is_torque
    value[acts] = np.concatenate([unit @ np.swapaxes(turn, -1, -2), moment], axis=-1)[acts]
    count = 3 * on_bodies.size
    return Rows.of(count, len(pose.position) - 1, np.arange(count), np.repeat(on_bodies.body, 3), value.reshape(-1, 6))


def given_derivative(instant: Instant) -> Blocks:
    """Return the derivative by ξ of the given forces and torques on the bodies, without the part through channels."""
    on_bodies, pose, vector = instant.system.forces.on_bodies, instant.pose, given_components(instant)
    bodies = len(pose.position) - 1
    carried = (on_bodies.turn @ vector[..., None])[..., 0]
    turn = pose.rotation[on_bodies.body]
    in_axes = np.where(on_bodies.in_body[:, None], carried, (np.swapaxes(turn, -1, -2) @ vector[..., None])[..., 0])
    value = np.zeros((on_bodies.size, 6, 6))
    follows, acts = on_bodies.in_body, ~on_bodies.is_torque
    value[follows & acts, :3, 3:] = -(turn @ tilde(in_axes))[follows & acts]
    value[~follows & acts, 3:, 3:] = (tilde(on_bodies.point) @ tilde(in_axes))[~follows & acts]
    value[~follows & ~acts, 3:, 3:] = tilde(in_axes)[~follows & ~acts]
    return Blocks.of(bodies, on_bodies.body, on_bodies.body, value)


# --- Derivatives of rows at velocity level by the pose ----------------------------------------------------------------
# With slip a(x)·x' of slots x, and δx = B ξ as in `row_derivatives`,
#
#    δ(a·x') = a·B ξ' + H ξ,      H = (x'ᵀ ∂a/∂x) B + a·B',
# Where x' multiplies the components of a, not its variables. Where a is the gradient of a function, ∂a/∂x is
# symmetric, so that both are the same, and H is G'.


@dataclass(frozen=True, eq=False)
class SlipMotion:
    """The rows at velocity level of a set, `rows` (k,), along a motion: H and H' (k, 6n)."""

    rows: Integers
    H: Rows
    H_dot: Rows


def slip_motion(bound: PrimitiveSet, carried: Carried) -> SlipMotion:
    """Return H and H' of a set along a motion."""
    rows, bodies = np.flatnonzero(bound.is_velocity), len(carried.position[0]) - 1
    groups = [group for group in bound.groups if not group.primitive.integrable]
    parts = [_of_group(bound, group, carried) for group in groups]
    at = [np.broadcast_to(group.rows[:, :, None], (*group.rows.shape, group.slots.shape[1])) for group in groups]
    body = [
        np.broadcast_to(bound.body[group.slots][:, None, :], each.shape) for group, each in zip(groups, at, strict=True)
    ]
    row, whose = (np.concatenate([each.ravel() for each in lists]) for lists in (at, body))
    H, H_dot = (
        Rows.of(bound.size, bodies, row, whose, np.concatenate([part[order] for part in parts])).chosen(rows)
        for order in range(2)
    )
    return SlipMotion(rows, H, H_dot)


def _of_group(bound: PrimitiveSet, group: Group, carried: Carried) -> tuple[Array, Array]:
    """Return H and H' of the entries of one group, (e, 6) each."""
    slots, primitive = group.slots, group.primitive
    x, x_dot, x_ddot = (carried.slots(bound, order)[slots] for order in range(3))
    B, B_dot, B_ddot = (carried.maps(bound, order)[slots] for order in range(3))
    k, s = slots.shape
    shape = (k, group.rows.shape[1], s, 3)
    a, bend = primitive.gradient(x), second_derivatives(primitive, x)

    def left_product(velocity: Array, matrix: Array) -> Array:
        return np.einsum("ki,krij->krj", velocity.reshape(k, 3 * s), matrix).reshape(shape)

    def times(gradient: Array, maps: Array) -> Array:
        return np.einsum("krai,kaiu->krau", gradient, maps)

    first, a_dot = left_product(x_dot, bend), (bend @ x_dot.reshape(k, 1, 3 * s, 1)).reshape(shape)
    first_dot = left_product(x_ddot, bend) + left_product(x_dot, turned_derivatives(primitive, x, x_dot))
    H = times(first, B) + times(a, B_dot)
    H_dot = times(first_dot, B) + times(first + a_dot, B_dot) + times(a, B_ddot)
    return H.reshape(-1, 6), H_dot.reshape(-1, 6)


# --- The equations of motion near a motion, linearised exactly, for virtual displacements ξ ---------------------------


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
