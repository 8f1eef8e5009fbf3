"""Derivatives of rows at velocity level by the pose. With slip a(x)·x' of slots x, and δx = B ξ as in
`row_derivatives`,

    δ(a·x') = a·B ξ' + H ξ,      H = (x'ᵀ ∂a/∂x) B + a·B',


where x' multiplies the components of a, not its variables. Where a is the gradient of a function, ∂a/∂x is symmetric,
so that both are the same, and H is G'.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.blocks import Rows
from mbproj.dynamics.derivatives.row_derivatives import Carried, second_derivatives, turned_derivatives
from mbproj.model.primitive_set import Group, PrimitiveSet


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
