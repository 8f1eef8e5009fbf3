"""Outputs of a linear model by their names: joint coordinates and speeds, markers, reactions, states of elements."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.derivatives.row_derivatives import COMPLEX_STEP, row_motion
from mbproj.dynamics.derivatives.tangent import velocities
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.observe.reactions import reactions
from mbproj.errors import InputError, Problem, choose_from
from mbproj.linear.reference import LinearReference


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
    of_states = np.array([[own == name for own in states] for name in names]).reshape(len(names), len(states))
    return Outputs(tuple(names), tuple(entry[0] for entry in chosen), displacement, rate, multiplier, of_states)


def _as_signals_do(name: str, known: Collection[str]) -> str:
    """Return the name of an output; a rate may also be named as in signals, "A.angle_dot" and "tip.x_dot"."""
    own, _, last = name.rpartition(".")
    rates = (f"{own}.{last.removesuffix('_dot')}_speed", f"{own}.velocity_{last.removesuffix('_dot')}")
    return next((rate for rate in rates if last.endswith("_dot") and rate in known), name)


#: The unit of an output, and its coefficients of displacements, rates and multipliers; computed when asked for.
Part = Array | float
Entry = Callable[[], tuple[str, Part, Part, Part]]


def _coordinates(reference: LinearReference) -> dict[str, Entry]:
    """Return the joint coordinates "A.angle" and their rates "A.angle_speed"."""
    system = reference.system
    rows = row_motion(system.coordinates, reference.motion.carried())

    def speed(row: int, unit: str) -> tuple[str, Part, Part, Part]:
        return f"{unit}/s", rows.G_dot.at(row), rows.G.at(row), 0.0

    entries: dict[str, Entry] = {}
    for row, (name, unit) in enumerate(zip(system.names.coordinates, system.names.coordinate_units, strict=True)):
        entries[name] = partial(lambda row, unit: (unit, rows.G.at(row), 0.0, 0.0), row, unit)
        entries[f"{name}_speed"] = partial(speed, row, unit)
    return entries


def _states(reference: LinearReference) -> dict[str, Entry]:
    """Return the states of elements, by their own names."""
    names = zip(reference.system.names.states, reference.system.names.state_units, strict=True)
    return {name: partial(lambda unit: (unit, 0.0, 0.0, 0.0), unit) for name, unit in names}


def _markers(reference: LinearReference) -> dict[str, Entry]:
    """Return the coordinates of markers "tip.x", and at rest their velocities "tip.velocity_x"."""
    system, pose = reference.system, reference.motion.pose

    def moves(marker: int, axis: int) -> Array:
        row, body = np.zeros((system.bodies + 1, 6)), system.marker_body[marker]
        row[body, axis] = 1.0
        row[body, 3:] = np.cross(system.marker_local[marker], pose.rotation[body, axis])
        return row[:-1].ravel()

    entries: dict[str, Entry] = {}
    for marker, name in enumerate(system.names.markers):
        for axis, letter in enumerate("xyz"):
            row = partial(moves, marker, axis)
            entries[f"{name}.{letter}"] = partial(lambda row: ("m", row(), 0.0, 0.0), row)
            if not reference.moves:
                entries[f"{name}.velocity_{letter}"] = partial(lambda row: ("m/s", 0.0, row(), 0.0), row)
    return entries


def _reactions(reference: LinearReference) -> dict[str, Entry]:
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
    pose, own = motion.pose, reference.multipliers[: bound.size]
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
            turned[body, way] = reactions(system, there, own)[kind][joint, axis].imag / COMPLEX_STEP
    return "N" if kind == 0 else "N m", turned[:-1].ravel(), 0.0, by_multiplier
