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

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from, placed_at
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.blocks import on_diagonal
from mbproj.equations.derivatives import COMPLEX_STEP, MotionAtTime, given_rows, row_motion, rows_at
from mbproj.equations.kinematics import Pose, pose_of
from mbproj.equations.reactions import reactions
from mbproj.equations.tangent_space import velocities
from mbproj.linear.eigenvalues import heavy_and_light, held_by, is_damped
from mbproj.linear.kinks import refuse_kinks
from mbproj.linear.reduction import Projected, projected
from mbproj.linear.reference import LinearReference
from mbproj.model.system import System
from mbproj.results.views import Table, Tabled

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix
    from scipy.sparse.linalg import LinearOperator


# --- Inputs of a linear model by their names --------------------------------------------------------------------------
# Forces of the scene, forces along joint coordinates, motions.


@dataclass(frozen=True, eq=False)
class Inputs:
    """p inputs with names and units. `force` (6n, p): the forces on the bodies by a unit of each input, torques in body
    axes. `motion` (p,): the number of the motion that each accelerates, -1 for forces."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    force: Array
    motion: Integers


def inputs_named(reference: LinearReference, names: Sequence[str]) -> Inputs:
    """Return the inputs of these names. Raises InputError for a name that does not exist."""
    known = forces_known(reference.system, reference.motion)
    motions = reference.system.names.motions
    able = [*known, *motions]
    problems = [Problem(f"unknown input '{name}'", hint=choose_from(name, able)) for name in names if name not in able]
    if problems:
        raise InputError(problems)
    columns = [known[name][1]() if name in known else np.zeros(6 * reference.system.bodies) for name in names]
    return Inputs(
        tuple(names),
        tuple(known[name][0] if name in known else _motion_unit(reference.system, name) for name in names),
        np.array(columns).reshape(len(names), 6 * reference.system.bodies).T,
        np.array([motions.index(name) if name in motions else -1 for name in names], dtype=np.intp),
    )


def _motion_unit(system: System, name: str) -> str:
    return f"{system.names.motion_units[system.names.motions.index(name)]}/s^2"


#: The unit of an input, and the forces (6n,) on the bodies by a unit of it.
InputEntry = tuple[str, Callable[[], Array]]


def forces_known(system: System, motion: MotionAtTime) -> dict[str, InputEntry]:
    """Return every force by name: along joint coordinates "A.angle", along the coordinate of a force of the scene, and
    components of forces and torques on bodies, "push.x"."""
    pose, entries = motion.pose, dict[str, InputEntry]()
    laws = system.forces.laws.coordinates, system.forces.law_owners
    for bound, names in ((system.coordinates, system.names.coordinates), laws):
        rows = rows_at(bound, pose)
        for row, (name, unit) in enumerate(zip(names, bound.units, strict=True)):
            entries[name] = ("N" if unit == "m" else "N m", partial(rows.at, row))
    return entries | _on_bodies(system, pose)


def _on_bodies(system: System, pose: Pose) -> dict[str, InputEntry]:
    loads, owners = system.forces.on_bodies, system.forces.program_owners
    rows = given_rows(system.forces, pose)
    return {
        f"{owners[int(program)]}.{'xyz'[row % 3]}": ("N m" if loads.is_torque[row // 3] else "N", partial(rows.at, row))
        for row, program in enumerate(loads.program.ravel())
        if loads.body[row // 3] < system.bodies
    }


# --- Outputs of a linear model by their names -------------------------------------------------------------------------
# Joint coordinates and speeds, markers, reactions, states of elements.


@dataclass(frozen=True, eq=False)
class Outputs:
    """r outputs with names and units. They are linear in virtual displacements and their rates, turns in body axes, in
    the multipliers of the joints' rows, and in states of elements. The coefficients are `of_displacement`, `of_rate`
    (r, 6n), `of_multiplier` (r, m) and `of_state` (r, K)."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    of_displacement: Array
    of_rate: Array
    of_multiplier: Array
    of_state: Array


def outputs_named(reference: LinearReference, names: Sequence[str]) -> Outputs:
    """Return the outputs of these names. Raises InputError for a name that does not exist."""
    system = reference.system
    joints = system.joints.size
    known = {**_coordinates(reference), **_markers(reference), **_reactions(reference), **_states(reference)}
    called = [_as_signals_do(name, known) for name in names]
    problems = [
        Problem(f"unknown output '{name}'", hint=choose_from(name, known)) for name in called if name not in known
    ]
    if problems:
        raise InputError(problems)
    chosen = [known[name]() for name in called]
    n, states = 6 * system.bodies, system.names.states
    displacement, rate, multiplier = (np.zeros((len(names), size)) for size in (n, n, joints))
    for row, entry in enumerate(chosen):
        _, displacement[row], rate[row], multiplier[row] = entry
    of_states = np.array([[state == name for state in states] for name in names]).reshape(len(names), len(states))
    return Outputs(tuple(names), tuple(entry[0] for entry in chosen), displacement, rate, multiplier, of_states)


def _as_signals_do(name: str, known: Collection[str]) -> str:
    """Return the name of an output; a rate may also be named as in signals, "A.angle_dot" and "tip.x_dot"."""
    owner, _, last = name.rpartition(".")
    rates = (f"{owner}.{last.removesuffix('_dot')}_speed", f"{owner}.velocity_{last.removesuffix('_dot')}")
    return next((rate for rate in rates if last.endswith("_dot") and rate in known), name)


#: The unit of an output, and its coefficients of displacements, rates and multipliers; computed when asked for.
Part = Array | float
OutputEntry = Callable[[], tuple[str, Part, Part, Part]]


def _coordinates(reference: LinearReference) -> dict[str, OutputEntry]:
    """Return the joint coordinates "A.angle" and their rates "A.angle_speed"."""
    system = reference.system
    rows = row_motion(system.coordinates, reference.motion.carried())

    def speed(row: int, unit: str) -> tuple[str, Part, Part, Part]:
        return f"{unit}/s", rows.G_dot.at(row), rows.G.at(row), 0.0

    entries: dict[str, OutputEntry] = {}
    for row, (name, unit) in enumerate(zip(system.names.coordinates, system.names.coordinate_units, strict=True)):
        entries[name] = partial(lambda row, unit: (unit, rows.G.at(row), 0.0, 0.0), row, unit)
        entries[f"{name}_speed"] = partial(speed, row, unit)
    return entries


def _states(reference: LinearReference) -> dict[str, OutputEntry]:
    """Return the states of elements, by their own names."""
    names = zip(reference.system.names.states, reference.system.names.state_units, strict=True)
    return {name: partial(lambda unit: (unit, 0.0, 0.0, 0.0), unit) for name, unit in names}


def _markers(reference: LinearReference) -> dict[str, OutputEntry]:
    """Return the coordinates of markers "tip.x", and at rest their velocities "tip.velocity_x"."""
    system, pose = reference.system, reference.motion.pose

    def moves(marker: int, axis: int) -> Array:
        row, body = np.zeros((system.bodies + 1, 6)), system.marker_body[marker]
        row[body, axis] = 1.0
        row[body, 3:] = np.cross(system.marker_local[marker], pose.rotation[body, axis])
        return row[:-1].ravel()

    entries: dict[str, OutputEntry] = {}
    for marker, name in enumerate(system.names.markers):
        for axis, letter in enumerate("xyz"):
            row = partial(moves, marker, axis)
            entries[f"{name}.{letter}"] = partial(lambda row: ("m", row(), 0.0, 0.0), row)
            if not reference.moves:
                entries[f"{name}.velocity_{letter}"] = partial(lambda row: ("m/s", 0.0, row(), 0.0), row)
    return entries


def _reactions(reference: LinearReference) -> dict[str, OutputEntry]:
    """Return the reactions "A.force_x" and "A.torque_x", on body 2 of the joint at its point, global axes."""
    system, count = reference.system, len(reference.system.names.joints)
    return {
        f"{name}.{word}_{letter}": partial(_reaction, reference, joint, kind, axis)
        for joint, name in enumerate(system.names.joints[: count - len(reference.held)])
        for kind, word in enumerate(("force", "torque"))
        for axis, letter in enumerate("xyz")
    }


def _reaction(reference: LinearReference, joint: int, kind: int, axis: int) -> tuple[str, Part, Part, Part]:
    """Return a reaction by the multipliers of the joint's own rows and the displacements of its bodies."""
    system, motion, bound = reference.system, reference.motion, reference.system.joints
    pose, multipliers = motion.pose, reference.multipliers[: bound.size]
    by_multiplier, turned = np.zeros(bound.size), np.zeros((system.bodies + 1, 6))
    mine = bound.owner == joint
    for row in np.flatnonzero(mine):
        unit = (np.arange(bound.size) == row).astype(float)
        by_multiplier[row] = reactions(system, pose, unit)[kind][joint, axis]
    for body in set(bound.body[bound.entry_slot[mine[bound.entry_row]]].tolist()) - {system.bodies}:
        for way in range(6):
            ξ = np.zeros_like(turned)
            ξ[body, way] = 1.0
            there = pose_of(motion.q + 1j * COMPLEX_STEP * velocities(pose, ξ[:-1].ravel()))
            turned[body, way] = reactions(system, there, multipliers)[kind][joint, axis].imag / COMPLEX_STEP
    return "N" if kind == 0 else "N m", turned[:-1].ravel(), 0.0, by_multiplier


# --- The linear model -------------------------------------------------------------------------------------------------


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
