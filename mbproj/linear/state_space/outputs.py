"""Outputs of a linear model by their names: joint coordinates and speeds, markers, reactions, states of elements."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.derivatives.row_derivatives import COMPLEX_STEP, row_motion
from mbproj.dynamics.derivatives.tangent import velocities
from mbproj.dynamics.equations.kinematics import attached_velocity, pose_of, twist_of
from mbproj.dynamics.observe.reactions import reactions
from mbproj.errors import InputError, Problem
from mbproj.linear.reference import Reference
from mbproj.scene.text.suggestions import choose_from


@dataclass(frozen=True, eq=False)
class Outputs:
    """r outputs, linear in virtual displacements, their rates, turns in body axes, the multipliers of the joints' rows,
    and states of elements: `of_displacement`, `of_rate` (r, 6n), `of_multiplier` (r, m) and `of_state` (r, K). Names
    and units in their order."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    of_displacement: Array
    of_rate: Array
    of_multiplier: Array
    of_state: Array


def outputs_named(reference: Reference, names: Sequence[str]) -> Outputs:
    """The outputs of these names. Raises InputError for one that there is not."""
    system = reference.system
    joints = system.joints.size
    known = {**_coordinates(reference), **_markers(reference), **_reactions(reference), **_states(reference)}
    problems = [
        Problem(f"unknown output '{name}'", hint=choose_from(name, known)) for name in names if name not in known
    ]
    if problems:
        raise InputError(problems)
    chosen = [known[name] for name in names]
    n, states = 6 * system.bodies, system.names.states
    return Outputs(
        tuple(names),
        tuple(entry[0] for entry in chosen),
        np.array([entry[1] for entry in chosen]).reshape(len(names), n),
        np.array([entry[2] for entry in chosen]).reshape(len(names), n),
        np.array([entry[3] for entry in chosen]).reshape(len(names), joints),
        np.array([[own == name for own in states] for name in names]).reshape(len(names), len(states)),
    )


#: Unit, and what it is by displacements, rates and multipliers.
Entry = tuple[str, Array, Array, Array]


def _coordinates(reference: Reference) -> dict[str, Entry]:
    """ "A.angle" and "A.angle_speed"."""
    system = reference.system
    rows = row_motion(system.coordinates, reference.motion.carried())
    G, G_dot, none = rows.G.dense(), rows.G_dot.dense(), np.zeros(system.joints.size)
    found: dict[str, Entry] = {}
    names = zip(system.names.coordinates, system.names.coordinate_units, G, G_dot, strict=True)
    for name, unit, row, change in names:
        found[name] = (unit, row, np.zeros_like(row), none)
        found[f"{name}_speed"] = (f"{unit}/s", change, row, none)
    return found


def _states(reference: Reference) -> dict[str, Entry]:
    """Those of elements, by their own names."""
    system = reference.system
    nothing, none = np.zeros(6 * system.bodies), np.zeros(system.joints.size)
    names = zip(system.names.states, system.names.state_units, strict=True)
    return {name: (unit, nothing, nothing, none) for name, unit in names}


def _markers(reference: Reference) -> dict[str, Entry]:
    """ "tip.x", and its velocity where the mechanism is at rest there, "tip.velocity_x"."""
    system, pose = reference.system, reference.motion.pose
    n, none = 6 * system.bodies, np.zeros(system.joints.size)
    is_point = np.ones(len(system.names.markers))
    moves = np.array(
        [
            attached_velocity(twist_of(pose, velocities(pose, ξ)), system.marker_body, system.marker_local, is_point)
            for ξ in np.eye(n)
        ]
    ).reshape(n, len(is_point), 3)
    found: dict[str, Entry] = {}
    for marker, name in enumerate(system.names.markers):
        for axis, letter in enumerate("xyz"):
            row = moves[:, marker, axis]
            found[f"{name}.{letter}"] = ("m", row, np.zeros(n), none)
            if not reference.moves:
                found[f"{name}.velocity_{letter}"] = ("m/s", np.zeros(n), row, none)
    return found


def _reactions(reference: Reference) -> dict[str, Entry]:
    """ "A.force_x" and "A.torque_x", on body 2 of the joint at its point, global axes."""
    system, motion = reference.system, reference.motion
    pose, n, joints = motion.pose, 6 * system.bodies, system.joints.size
    own, count = reference.multipliers[:joints], len(system.names.joints)
    unit = np.array([reactions(system, pose, row) for row in np.eye(joints)]).reshape(joints, 2, count, 3)
    turned = np.array(
        [
            [part.imag / COMPLEX_STEP for part in reactions(system, pose_of(motion.q + 1j * COMPLEX_STEP * v), own)]
            for v in (velocities(pose, ξ) for ξ in np.eye(n))
        ]
    ).reshape(n, 2, count, 3)
    found: dict[str, Entry] = {}
    for joint, name in enumerate(system.names.joints[: count - len(reference.held)]):
        for kind, word in enumerate(("force", "torque")):
            for axis, letter in enumerate("xyz"):
                entry = ("N" if kind == 0 else "N m", turned[:, kind, joint, axis], np.zeros(n))
                found[f"{name}.{word}_{letter}"] = (*entry, unit[:, kind, joint, axis])
    return found
