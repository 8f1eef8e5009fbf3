"""Linear equations in global axes, or in axes that turn with a rotating mechanism: coordinates in which a steady motion
has constant coefficients.

With ξ = P(t) η, P = diag(R, AᵀR) of each body and R' = Ω~ R, the equations in η follow with ξ' = P η' + P' η and ξ'' =
P η'' + 2 P' η' + P'' η. At the reference time the axes are the global ones, R = 1.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.blocks import Blocks, Rows, added, summed
from mbproj.dynamics.derivatives.linear_equations import LinearEquations, MotionAtTime, StateEquations
from mbproj.dynamics.derivatives.row_derivatives import RowMotion, tilde
from mbproj.dynamics.derivatives.slip_derivatives import SlipMotion


def in_axes(equations: LinearEquations, motion: MotionAtTime, turning: Array) -> LinearEquations:
    """Return the equations of virtual displacements (δr, δπ) in global axes, which turn with Ω (3,) in rad/s."""
    P, P_dot, P_ddot = _axes(motion, turning)
    M, D, K = equations.M, equations.D, equations.K
    bodies, rows, states = M.bodies, equations.rows, equations.states
    return LinearEquations(
        _between(M, P, P),
        added(bodies, [_between(D, P, P), _between(M, P, P_dot).scaled(2.0)]),
        added(bodies, [_between(K, P, P), _between(D, P, P_dot), _between(M, P, P_ddot)]),
        RowMotion(
            _times(rows.G, P),
            summed([_times(rows.G_dot, P), _times(rows.G, P_dot)]),
            summed([_times(rows.G_ddot, P), _times(rows.G_dot, 2.0 * P_dot), _times(rows.G, P_ddot)]),
        ),
        StateEquations(
            states.by_states,
            summed([_times(states.by_displacement, P), _times(states.by_rate, P_dot)]),
            _times(states.by_rate, P),
            _times(states.push, P),
        ),
        None if equations.slip is None else _slip_in_axes(equations.slip, rows, (P, P_dot, P_ddot)),
    )


def _slip_in_axes(slip: SlipMotion, rows: RowMotion, axes: tuple[Array, Array, Array]) -> SlipMotion:
    """Return the slip A ξ' + H ξ in other axes, with rows A of those in body axes."""
    P, P_dot, P_ddot = axes
    A, A_dot = (part.chosen(slip.rows) for part in (rows.G, rows.G_dot))
    return SlipMotion(
        slip.rows,
        summed([_times(slip.H, P), _times(A, P_dot)]),
        summed([_times(slip.H_dot, P), _times(slip.H, P_dot), _times(A_dot, P_dot), _times(A, P_ddot)]),
    )


def _axes(motion: MotionAtTime, turning: Array) -> tuple[Array, Array, Array]:
    """Return P, P' and P'' of each body, (n, 6, 6)."""
    A, A_dot, A_ddot = (np.swapaxes(part[:-1], -1, -2) for part in motion.carried().rotation)
    spin = tilde(turning)
    P, P_dot, P_ddot = np.zeros((3, len(A), 6, 6))
    P[:, :3, :3], P_dot[:, :3, :3], P_ddot[:, :3, :3] = np.eye(3), spin, spin @ spin
    P[:, 3:, 3:], P_dot[:, 3:, 3:] = A, A_dot + A @ spin
    P_ddot[:, 3:, 3:] = A_ddot + 2.0 * A_dot @ spin + A @ spin @ spin
    return P, P_dot, P_ddot


def _between(matrix: Blocks, left: Array, right: Array) -> Blocks:
    value = np.swapaxes(left, -1, -2)[matrix.row] @ matrix.value @ right[matrix.column]
    return Blocks(matrix.bodies, matrix.row, matrix.column, value)


def _times(rows: Rows, right: Array) -> Rows:
    value = (rows.value[:, None, :] @ right[rows.body])[:, 0]
    return Rows(rows.count, rows.bodies, rows.row, rows.body, value)
