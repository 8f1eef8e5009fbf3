"""Derivatives of a set of primitives along the tangent coordinates of the bodies that they bind.

A slot's point or vector x moves by δx = B ξ with B = [1, -A s~] of (δr, δθ), or [0, -A s~] of a vector; a row of G is g
= ∂C/∂x B. Along a motion, ξ constant,

    g'  = (C_xx x') B + C_x B',      g'' = (C_xx x'' + C_xxx x' x') B + 2 (C_xx x') B' + C_x B'',


and a generalised force gᵀw changes by ∂(gᵀw)/∂ξ = Bᵀ (w C_xx) B + s~ (Aᵀ w C_x)~, the last in the turns. The primitives
define all of it: C_xx follows from their curvature by polarisation, and C_xxx is the complex step of their curvature,
exact to round-off (Squire and Trapp 1998).
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import Primitive
from mbproj.dataclass import dataclass
from mbproj.dynamics.blocks import Blocks, Rows, added
from mbproj.dynamics.equations.constraint_equations import tangent_entries
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.model.primitive_set import Group, PrimitiveSet

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
