"""Linear equations on the tangent space: with ξ = N η, N a null space matrix that changes along the motion,

NᵀMN η'' + Nᵀ(D N + 2 M N') η' + Nᵀ(K N + D N' + M N'') η = 0.

First-order states x are coordinates without mass that resist their rates: their part of M is 0, of D the identity, and
of K -f_x.

With rows at velocity level there are fewer speeds than positions.

On the tangent space N of the rows at position level, ξ = N η, rows at velocity level require A η' + H η = 0. Let Z span
null(A) and W the rest: η = Z a + W b. Then b has no inertia of its own; it follows

    b' = -E η,    E = (A W)⁻¹ H,    A W b'' = -(A' + H) η' - H' η,

and the forces along Z are those of motions without slip. Where nothing moves, b stays where it is: a wheel rests
anywhere.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.blocks import Blocks, Rows, added, summed
from mbproj.equations.derivatives import (
    LinearEquations,
    MotionAtTime,
    RowMotion,
    SlipMotion,
    StateEquations,
    linear_equations,
    tangent_force,
    tilde,
)
from mbproj.equations.kinematics import Pose
from mbproj.equations.of_motion import tangent_gradients
from mbproj.equations.tangent_space import TangentSpace, tangent_lengths
from mbproj.linear.bordered import tangent_space_of
from mbproj.linear.eigenvalues import ReducedEquations
from mbproj.linear.reference import LinearReference
from mbproj.model.system import System

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


# --- Linear equations in global axes, or in axes that turn with a rotating mechanism ----------------------------------
# Coordinates in which a steady motion has constant coefficients.
# With ξ = P(t) η, P = diag(R, AᵀR) of each body and R' = Ω~ R, the equations in η follow with ξ' = P η' + P' η and
# ξ'' = P η'' + 2 P' η' + P'' η. At the reference time the axes are the global ones, R = 1.


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


# --- Linear equations on the tangent space ----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Projected:
    """The linear equations at a reference in its axes: `reduced` to the tangent space of rows at position level, dense,
    and before. `N_dot` (6n, f): the rate of the tangent space along the motion. `slip`: rows at velocity level on
    it."""

    equations: LinearEquations
    space: TangentSpace
    N_dot: Array
    reduced: ReducedEquations
    slip: SlipEquations | None = None

    @property
    def freedom(self) -> int:
        """The degrees of freedom of velocities."""
        return self.space.freedom - (0 if self.slip is None else self.slip.rank)

    def solvable(self, scale: Array) -> tuple[ReducedEquations, Array]:
        """Return the equations whose eigenvalues are those of the mechanism, and (η, states / scale) by their
        coordinates."""
        reduced = self.with_states(scale)
        return (reduced, np.eye(len(reduced.M))) if self.slip is None else without_slip(reduced, self.slip, len(scale))

    def with_states(self, scale: Array) -> ReducedEquations:
        """Return the equations with the states of elements after η, each in its `scale` (K,); slip is still allowed."""
        count, reduced, N = len(scale), self.reduced, self.space.N
        if not count:
            return reduced
        states = self.equations.states
        P, Q, push = (part.matrix() for part in (states.by_displacement, states.by_rate, states.push))
        mass = float(np.abs(reduced.M).max(initial=0.0)) or 1.0
        unit = mass / scale[:, None]
        none, pushed = np.zeros((reduced.M.shape[0], count)), -(push @ N).T * scale
        M = np.block([[reduced.M, none], [none.T, np.zeros((count, count))]])
        D, D_size = (
            np.block([[part, none], [sign(-unit * (Q @ N)), mass * np.eye(count)]])
            for part, sign in ((reduced.D, np.positive), (reduced.D_size, np.abs))
        )
        K, K_size = (
            np.block(
                [[part, sign(pushed)], [sign(-unit * (P @ N + Q @ self.N_dot)), sign(-unit * states.by_states * scale)]]
            )
            for part, sign in ((reduced.K, np.positive), (reduced.K_size, np.abs))
        )
        weighs = np.block([[reduced.weighs, np.zeros((len(reduced.weighs), count))], [none.T, np.eye(count)]])
        return ReducedEquations(M, D, K, D_size, K_size, weighs)


def projected(reference: LinearReference) -> Projected:
    """Return the linear equations at a reference, on its tangent space."""
    system, motion = reference.system, reference.motion
    refuse_large_rolling(system)
    equations = in_axes(linear_equations(system, motion, reference.multipliers), motion, reference.turning)
    rows, scale = equations.rows, system.row_scale[system.bodies :]
    if system.rolls:
        at_positions = np.flatnonzero(~system.is_velocity[system.bodies :])
        rows, scale = (
            RowMotion(*(each.chosen(at_positions) for each in (rows.G, rows.G_dot, rows.G_ddot))),
            scale[at_positions],
        )
    G_dot, G_ddot = rows.G_dot.matrix(), rows.G_ddot.matrix()
    space = tangent_space_of(system, motion.pose, rows.G, scale)
    N, (N_dot, N_ddot) = space.N, space.rates(G_dot, G_ddot)
    M, D, K = (part.matrix() for part in (equations.M, equations.D, equations.K))
    D_size, K_size = (_sizes(part) for part in (equations.D, equations.K))
    acts = (np.abs(tangent_force(system, motion)) / tangent_lengths(system))[:, None]
    size, M_size = np.abs(N), np.abs(M)
    reduced = ReducedEquations(
        N.T @ (M @ N),
        N.T @ (D @ N + 2.0 * M @ N_dot),
        N.T @ (K @ N + D @ N_dot + M @ N_ddot),
        size.T @ (D_size @ size + 2.0 * M_size @ np.abs(N_dot)),
        size.T @ (K_size @ size + acts * size + D_size @ np.abs(N_dot) + M_size @ np.abs(N_ddot)),
        weighing(system, motion.pose, N),
    )
    slip = None if equations.slip is None else _slip(system, equations, space.N, N_dot, N_ddot)
    return Projected(equations, space, N_dot, reduced, slip)


def _slip(system: System, equations: LinearEquations, N: Array, N_dot: Array, N_ddot: Array) -> SlipEquations:
    """Return the rows at velocity level on the tangent space, and their derivatives along the motion."""
    slip = equations.slip
    assert slip is not None
    scale = system.row_scale[system.bodies :][slip.rows, None]
    A, A_dot, H, H_dot = (
        part.dense() / scale
        for part in (equations.rows.G.chosen(slip.rows), equations.rows.G_dot.chosen(slip.rows), slip.H, slip.H_dot)
    )
    return SlipEquations(
        A @ N,
        A_dot @ N + A @ N_dot,
        A @ N_dot + H @ N,
        A_dot @ N_dot + A @ N_ddot + H_dot @ N + H @ N_dot,
    )


def refuse_large_rolling(system: System) -> None:
    """Raise InputError where a large mechanism has rows at velocity level."""
    if system.rolls and system.bodies > THRESHOLDS.large:
        most = f"up to {THRESHOLDS.large} bodies"
        said = f"the linear equations of rolling mechanisms are dense, for {most}, and this one has {system.bodies}"
        raise InputError(Problem(said, key=("bodies",), hint="take fewer bodies"))


def weighing(system: System, pose: Pose, N: Array) -> Array:
    """Return rows (w, f) that vanish on displacements N (6n, f) in global axes without mass: shifts of bodies with
    mass, turns about axes with inertia, and coordinates with reflected inertia. The amount of mass does not count."""
    n = system.bodies
    moments, axes = np.linalg.eigh(system.inertia)
    resists = moments > np.finfo(float).eps * np.maximum(moments[:, -1:], np.finfo(float).tiny)
    in_global = resists[:, :, None] * np.swapaxes(pose.rotation[:-1] @ axes, -1, -2)
    moved = N.reshape(n, 6, -1)
    shifts = (system.mass > 0.0)[:, None, None] * moved[:, :3] / system.length
    weighed = np.concatenate([shifts, in_global @ moved[:, 3:]], axis=1).reshape(N.shape)
    g = tangent_gradients(system.reflected, pose)[:, :-1].copy()
    g[..., 3:] = (pose.rotation[:-1] @ g[..., 3:, None])[..., 0]
    unit = np.where(system.reflected.rows.is_length, system.length, 1.0)
    return np.concatenate([weighed, g.reshape(len(g), 6 * n) @ N / unit[:, None]])


def _sizes(matrix: Blocks) -> Array | csr_matrix:
    """Return the matrix with the sum of its parts' absolute values."""
    return Blocks(matrix.bodies, matrix.row, matrix.column, np.abs(matrix.value)).matrix()


@dataclass(frozen=True, eq=False)
class SlipEquations:
    """A, A', H and H' on the tangent space of the rows at position level, (k, f) each."""

    A: Array
    A_dot: Array
    H: Array
    H_dot: Array

    @property
    def rank(self) -> int:
        """The number of speeds that these rows remove."""
        σ = np.linalg.svd(self.A, compute_uv=False)
        return int(np.count_nonzero(σ > THRESHOLDS.dependent * σ.max(initial=0.0)))

    def beside(self, states: int) -> SlipEquations:
        """Return the rows with columns of zeros after them, for this number of states."""
        parts = (np.pad(part, ((0, 0), (0, states))) for part in (self.A, self.A_dot, self.H, self.H_dot))
        return SlipEquations(*parts)


def without_slip(reduced: ReducedEquations, slip: SlipEquations, states: int) -> tuple[ReducedEquations, Array]:
    """Return the equations in coordinates (a, b), then the `states` of elements, which come last in both; and (η, s) by
    these, (f + K, f + K)."""
    of = slip.beside(states)
    U, σ, V = np.linalg.svd(slip.A)
    rank = slip.rank
    pad = ((0, states), (0, 0))
    W, allowed = np.pad(V[:rank].T, pad), np.pad(V[rank:].T, pad)
    last = np.eye(len(reduced.M))[:, len(reduced.M) - states :]
    Z = np.hstack([allowed, last])
    P = (U[:, :rank] / σ[:rank]).T
    E, pull = P @ of.H, Z.T @ reduced.M @ W
    D = Z.T @ reduced.D - pull @ (P @ (of.A_dot + of.H))
    K = Z.T @ reduced.K - pull @ (P @ of.H_dot) - D @ W @ E
    size = np.abs(Z).T, np.abs(pull), np.abs(P)
    D_size = size[0] @ reduced.D_size + size[1] @ (size[2] @ np.abs(of.A_dot + of.H))
    K_size = size[0] @ reduced.K_size + size[1] @ (size[2] @ np.abs(of.H_dot)) + D_size @ np.abs(W @ E)
    mass = float(np.abs(reduced.M).max(initial=0.0)) or 1.0
    back, free = np.hstack([allowed, W, last]), allowed.shape[1]
    order = np.r_[:free, free + states : free + states + rank, free : free + states]  # rows: a, b, states
    none, one = np.zeros((rank, len(back))), mass * np.linalg.pinv(W) @ back

    def arranged(upper: Array, lower: Array) -> Array:
        return np.asarray(np.concatenate([upper, lower])[order], dtype=float)

    M = np.hstack([Z.T @ reduced.M @ allowed, np.zeros_like(pull), Z.T @ reduced.M @ last])
    moved = reduced.weighs @ _except(back, free, rank)
    follows = np.zeros((rank, len(back)))
    follows[:, free : free + rank] = np.eye(rank)
    without = ReducedEquations(
        arranged(M, none),
        arranged(D @ _except(back, free, rank), one),
        arranged(K @ back, mass * E @ back),
        arranged(D_size @ np.abs(back), np.abs(one)),
        arranged(K_size @ np.abs(back), mass * np.abs(E) @ np.abs(back)),
        np.concatenate([moved, follows]),
        chains=True,
    )
    return without, back


def _except(back: Array, first: int, count: int) -> Array:
    """Return a matrix with 0 in the columns of the coordinates b."""
    rest = back.copy()
    rest[:, first : first + count] = 0.0
    return rest
