"""The linear model. Its states are displacements and speeds along the tangent space, value and rate of each motion that
is an input, and the states s of elements. Such an input is the motion's second derivative.

With ξ = N η + B w, where B w is the smallest displacement by which motions change, and Φ s the forces of states,

    NᵀMN η'' + NᵀDN η' + NᵀKN η = Nᵀ(F u + Φ s) - NᵀM B w'' - NᵀD B w' - NᵀK B w,      s' = f_x s + f_ξ ξ + f_ξ' ξ',
    δλ = (G⁺)ᵀ (F u + Φ s - M ξ'' - D ξ' - K ξ).


Motions without mass have no states: they follow the others, the motions and the forces at once, by K.

A mechanism that rolls has displacements a and speeds a' of motions without slip, and further displacements b. With
ξ = N (Z a + W b) as in `reduction/projected.py`

    M a'' + D a' + K (a, b) = (N Z)ᵀ F u,      b' = -E (Z a + W b).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.blocks import on_diagonal
from mbproj.errors import InputError, Place, Problem, placed_at
from mbproj.linear.eigenvalues import heavy_and_light, held_by, is_damped
from mbproj.linear.kinks import refuse_kinks
from mbproj.linear.reduction.projected import Projected, projected
from mbproj.linear.reference import LinearReference
from mbproj.linear.state_space.inputs import Inputs, inputs_named
from mbproj.linear.state_space.outputs import Outputs, outputs_named
from mbproj.model.system import System
from mbproj.results.views.table import Table, Tabled
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix
    from scipy.sparse.linalg import LinearOperator


@dataclass(frozen=True, eq=False)
class LinearModel(Tabled):
    """x' = A x + B u, y = C x + D u, for small changes from the reference, with names and units of x, u and y."""

    reference: LinearReference
    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]

    @property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """A, B, C, D, as `scipy.signal.StateSpace(*model.matrices)` and python-control's `ss` take them."""
        return self.A, self.B, self.C, self.D

    @property
    def table(self) -> Table:
        """The matrices [A B; C D] as a table: a row for each derivative or output, a column for each state or input."""
        rows = np.block([[self.A, self.B], [self.C, self.D]]).tolist()
        names = [*(f"{name}'" for name in self.states), *self.outputs]
        named = ((name, *row) for name, row in zip(names, rows, strict=True))
        return Table(("of", *self.states, *self.inputs), tuple(named))

    @property
    def line(self) -> str:
        """The size of the model and its reference, in words."""
        return (
            f"{len(self.states)} states, {', '.join(self.inputs)} -> {', '.join(self.outputs)}, {self.reference.words}"
        )

    __repr__ = Tabled.__repr__


def linear_model(reference: LinearReference, inputs: Sequence[str], outputs: Sequence[str]) -> LinearModel:
    """Return the model at a reference where the tangent space does not turn. Raises InputError for unknown names, and
    where the mechanism moves or has too many degrees of freedom. Raises it also where motions without mass are damped
    or have no stiffness."""
    refuse_kinks(reference)
    with placed_at(Place("--inputs")):
        u = inputs_named(reference, inputs)
    with placed_at(Place("--outputs")):
        y = outputs_named(reference, outputs)
    if reference.system.rolls:
        refuse_beside_rolling(reference.system, bool(y.of_multiplier.any()))
    return assembled(reference, u, y)


def assembled(reference: LinearReference, u: Inputs, y: Outputs) -> LinearModel:
    """Return the model for known inputs and outputs; the caller checks for kinks."""
    here = projected(reference)
    if np.abs(here.N_dot).max(initial=0.0) > THRESHOLDS.rounding * np.abs(here.space.N).max(initial=1.0):
        said = "the mechanism moves here, so that its linear model changes with time"
        raise InputError(Problem(said, hint="linearise where it rests: --at equilibrium"))
    return _assembled(reference, here, u, y) if here.slip is None else _rolling(reference, here, u, y)


def _rolling(reference: LinearReference, here: Projected, u: Inputs, y: Outputs) -> LinearModel:
    """Return the model of a mechanism that rolls, which has fewer speeds than displacements."""
    to_body = _to_body(reference)
    states = rolling_states(here, to_body.T @ u.force)
    names = [f"displacement_{i + 1}" for i in range(len(states.A) - states.free)]
    free, rest = names[: states.free], names[states.free :]
    return LinearModel(
        reference,
        states.A,
        states.B,
        y.of_displacement @ to_body @ states.displacement + y.of_rate @ to_body @ states.rate,
        np.zeros((len(y.names), len(u.names))),
        (*free, *(f"{name}_speed" for name in free), *rest),
        (*["1"] * states.free, *["1/s"] * states.free, *["1"] * len(rest)),
        u.names,
        u.units,
        y.names,
        y.units,
    )


def _assembled(reference: LinearReference, here: Projected, u: Inputs, y: Outputs) -> LinearModel:
    system = reference.system
    N, pseudoinverse = here.space.N, here.space.pseudoinverse
    M, D, K = (part.matrix() for part in (here.equations.M, here.equations.D, here.equations.K))
    push = here.equations.states.push.dense().T
    to_body = _to_body(reference)
    force = to_body.T @ u.force
    driven = [int(motion) for motion in u.motion if motion >= 0]
    asked = np.zeros((system.constraints - system.bodies, len(driven)))
    asked[[system.joints.size + motion for motion in driven], np.arange(len(driven))] = 1.0
    B_w = pseudoinverse @ asked
    N, heavy, B_w, by_states, at_once = _without_mass(here, N, B_w, K, push, force)
    f, k, p = N.shape[1], len(driven), len(u.names)
    w_ddot = np.zeros((k, p))
    w_ddot[np.arange(k), np.flatnonzero(u.motion >= 0)] = 1.0
    # ξ'', ξ', ξ and the states s of elements by x = (η, w, η', w', s) and u.
    ξ = np.concatenate([N, B_w, np.zeros_like(N), np.zeros_like(B_w), by_states], axis=1)
    ξ_dot = np.concatenate([np.zeros_like(N), np.zeros_like(B_w), N, B_w, np.zeros_like(by_states)], axis=1)
    half, count = f + k, push.shape[1]
    s = np.eye(2 * half + count)[2 * half :]
    s_x, s_u = _rates_of_states(here, by_states, at_once, ξ, ξ_dot, s)
    ξ_dot = ξ_dot + by_states @ s_x
    mass = heavy.T @ (M @ N)
    of_x = -np.linalg.solve(mass, heavy.T @ (K @ ξ + D @ ξ_dot - push @ s))
    of_u = np.linalg.solve(mass, heavy.T @ (force - M @ (B_w @ w_ddot) - K @ at_once))
    A, B = np.zeros((2 * half + count,) * 2), np.zeros((2 * half + count, p))
    A[:half, half : 2 * half] = np.eye(half)
    A[half : half + f], B[half : half + f] = of_x, of_u
    B[half + f : 2 * half] = w_ddot
    A[2 * half :], B[2 * half :] = s_x, s_u
    borne_x = _reaction_outputs(y, pseudoinverse, push @ s - M @ (N @ of_x) - D @ ξ_dot - K @ ξ)
    borne_u = _reaction_outputs(y, pseudoinverse, force - M @ (N @ of_u + B_w @ w_ddot) - K @ at_once)
    _refuse_rates_of_inputs(y, to_body, at_once)
    C = y.of_displacement @ to_body @ ξ + y.of_rate @ to_body @ ξ_dot + borne_x + y.of_state @ s
    names = [*(f"displacement_{i + 1}" for i in range(f)), *(system.names.motions[motion] for motion in driven)]
    units = [*["1"] * f, *(system.names.motion_units[motion] for motion in driven)]
    return LinearModel(
        reference,
        A,
        B,
        C,
        y.of_displacement @ to_body @ at_once + borne_u,
        (*names, *(f"{name}_speed" for name in names), *system.names.states),
        (*units, *("1/s" if unit == "1" else f"{unit}/s" for unit in units), *system.names.state_units),
        u.names,
        u.units,
        y.names,
        y.units,
    )


def _reaction_outputs(y: Outputs, pseudoinverse: Array | LinearOperator, left: Array) -> Array:
    """Return the parts of outputs, (r, k), from the multipliers that balance forces (6n, k); these are costly."""
    if not y.of_multiplier.any():
        return np.zeros((len(y.names), left.shape[1]))
    return np.asarray(y.of_multiplier @ (pseudoinverse.T @ left)[: y.of_multiplier.shape[1]], dtype=float)


def _rates_of_states(
    here: Projected, by_states: Array, at_once: Array, ξ: Array, ξ_dot: Array, s: Array
) -> tuple[Array, Array]:
    """Return s' of the states of elements by x and by u, where ξ' is `ξ_dot` x + `by_states` s'. Raises InputError
    where they follow the rate of an input."""
    states = here.equations.states
    P, Q = states.by_displacement.matrix(), states.by_rate.matrix()
    if np.any(np.abs(Q @ at_once) > THRESHOLDS.rounding * (np.abs(Q) @ np.abs(at_once))):
        said = "a state of an element follows the rate of an input, as nothing between them has mass"
        raise InputError(Problem(said, hint="give the moving bodies mass, or take other inputs"))
    left = np.eye(len(s)) - Q @ by_states
    by_x, by_u = P @ ξ + Q @ ξ_dot + states.by_states @ s, P @ at_once
    rates = np.asarray(np.linalg.solve(left, np.hstack([by_x, by_u])), dtype=float)
    return rates[:, : ξ.shape[1]], rates[:, ξ.shape[1] :]


def _without_mass(
    here: Projected, N: Array, B_w: Array, K: Array | csr_matrix, push: Array, force: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Eliminate motions without mass. Return N, the directions that move mass, B, and the displacements by states and
    inputs.

    N and B include the motions without mass, which follow the others. Such motions respond at once to the states of
    elements, which exert `push` (6n, K), and to the inputs, (6n, p)."""
    U, light = heavy_and_light(here.reduced)
    if not light.size:
        return N, N, B_w, np.zeros_like(push), np.zeros_like(force)
    if is_damped(here.reduced, light):
        said = "a motion moves no mass and is damped: it has a rate of its own, which this linear model does not know"
        raise InputError(Problem(said, hint="give the moving bodies mass; `mbproj modes` needs none"))
    held, moves = held_by(here.reduced, light), N @ light
    follows = [-moves @ np.linalg.solve(held, moves.T @ (K @ part)) for part in (N @ U, B_w)]
    by_states, at_once = (moves @ np.linalg.solve(held, moves.T @ part) for part in (push, force))
    return N @ U + follows[0], N @ U, B_w + follows[1], by_states, at_once


def _refuse_rates_of_inputs(y: Outputs, to_body: Array | csr_matrix, at_once: Array) -> None:
    """Raise InputError where an output is the rate of a displacement that follows inputs at once: it needs rates of
    inputs."""
    rate = np.abs(y.of_rate @ to_body @ at_once)
    largest = np.abs(y.of_rate) @ np.abs(to_body @ at_once)
    problems = [
        Problem(f"output '{name}' has the rate of an input, as nothing between them has mass")
        for name, part, size in zip(y.names, rate, largest, strict=True)
        if np.any(part > THRESHOLDS.rounding * size)
    ]
    if problems:
        raise InputError(problems)


def _to_body(reference: LinearReference) -> Array | csr_matrix:
    """Return the matrix (6n, 6n) from virtual displacements in global axes to those in body axes."""
    n = reference.system.bodies
    blocks = np.zeros((n, 6, 6))
    blocks[:, :3, :3] = np.eye(3)
    blocks[:, 3:, 3:] = np.swapaxes(reference.motion.pose.rotation[:-1], -1, -2)
    return on_diagonal(blocks).matrix()


@dataclass(frozen=True, eq=False)
class RollingStates:
    """x' = A x + B u of x = (a, a', b), with the displacements (6n, x) and rates (6n, x) that belong to x. `free`: the
    number of coordinates a."""

    A: Array
    B: Array
    displacement: Array
    rate: Array
    free: int


def rolling_states(here: Projected, force: Array) -> RollingStates:
    """Return the model for forces (6n, p) on the bodies, in the axes of the equations. Raises InputError where a motion
    has no mass."""
    reduced, back = here.solvable(np.zeros(0))
    free, N = here.freedom, here.space.N
    M, D, K = reduced.M[:free, :free], reduced.D[:free, :free], reduced.K[:free]
    if heavy_and_light(here.reduced)[1].size:
        said = "a rolling motion moves no mass, which this linear model does not cover"
        raise InputError(Problem(said, hint="give the moving bodies mass; `mbproj modes` needs none"))
    rest = len(reduced.M) - free
    follows = np.asarray(-np.linalg.solve(reduced.D[free:, free:], reduced.K[free:]), dtype=float)  # b' by (a, b)
    pull = np.linalg.solve(M, np.hstack([K, D, (N @ back[:, :free]).T @ force]))
    size = 2 * free + rest
    A, B = np.zeros((size, size)), np.zeros((size, force.shape[1]))
    A[:free, free : 2 * free] = np.eye(free)
    A[free : 2 * free] = -_placed(pull[:, : free + rest], free)
    A[free : 2 * free, free : 2 * free] -= pull[:, free + rest : 2 * free + rest]
    A[2 * free :] = _placed(follows, free)
    B[free : 2 * free] = pull[:, 2 * free + rest :]
    moved = N @ back
    displacement = _placed(moved, free)
    rate = moved[:, free:] @ A[2 * free :]
    rate[:, free : 2 * free] += moved[:, :free]
    return RollingStates(A, B, displacement, rate, free)


def _placed(of: Array, free: int) -> Array:
    """Return columns for (a, b) as columns for (a, a', b)."""
    return np.hstack([of[:, :free], np.zeros((len(of), free)), of[:, free:]])


def refuse_beside_rolling(system: System, asks_reactions: bool) -> None:
    """Raise InputError for parts that this model lacks: states of elements, motions and reactions."""
    reasons = {
        "states of elements": system.states.size,
        "motions": system.driven,
        "reactions as outputs": asks_reactions,
    }
    for what, has in reasons.items():
        if has:
            joint = int(system.joints.owner[np.argmax(system.joints.is_velocity)])
            said = f"joint '{system.names.joints[joint]}' rolls, and linear models of rolling mechanisms have no {what}"
            raise InputError(Problem(said, system.joint_places[joint], "`mbproj modes` knows them; or leave them out"))
