"""A steady turn: all bodies turn as one about the axis of a joint to the ground, at a given speed."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array, cross
from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinate_values
from mbproj.equations.derivatives import constraint_rows
from mbproj.equations.kinematics import attached, pose_of, slots_of
from mbproj.equations.motions import NO_DRIVE, drive_at
from mbproj.equations.rank.row_space import NO_CONDITIONS
from mbproj.linear.equilibrium.balance import EquilibriumProblem, SteadyTurn
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import Conditions, System


def steady_turn(system: System, start: State, name: str, rate: float) -> tuple[SteadyTurn, Conditions]:
    """Return the turn in which the coordinate `name` grows at `rate` in rad/s, and the held coordinate: this one,
    unless a motion drives it. Raises InputError where it is no angle of a joint to the ground, or joints keep the
    mechanism from turning as one."""
    names, coordinates = system.names.coordinates, system.coordinates
    if name not in names:
        raise InputError(Problem(f"unknown joint coordinate '{name}'", hint=choose_from(name, names)))
    index = names.index(name)
    joint = int(coordinates.owner[index])
    body, place = int(system.reaction_body[joint]), system.joint_places[joint]
    first, second, arm = (int(slot) for slot in np.flatnonzero(_slots(system, index))[:3])
    ground = system.bodies
    on_ground = [int(coordinates.body[slot]) == ground for slot in (first, arm)]
    if coordinates.is_length[index] or not any(on_ground):
        said = f"'{name}' is not an angle between the ground and a body, about which the mechanism could turn"
        raise InputError(Problem(said, place, "give one that is, A.angle=60rpm say"))
    pose = pose_of(start.q)
    x = attached(pose, *slots_of(coordinates))
    axis = cross(x[first], x[second])
    sign = 1.0 if on_ground[0] else -1.0
    point = pose.position[body] + pose.rotation[body] @ system.reaction_local[joint]
    turning = SteadyTurn(sign * rate * axis / np.linalg.norm(axis), point)
    _refuse_what_does_not_turn(system, start, turning)
    driven = index in system.motions.joint_coordinate
    value = coordinate_values(system, pose)[index : index + 1]
    return turning, NO_CONDITIONS if driven else Conditions(np.array([index], dtype=np.intp), value)


def _slots(system: System, index: int) -> Array:
    """Return which slots of the coordinates' set belong to one coordinate."""
    bound = system.coordinates
    chosen = np.zeros(len(bound.body), dtype=bool)
    chosen[bound.entry_slot[bound.entry_row == index]] = True
    return chosen


def _refuse_what_does_not_turn(system: System, start: State, turning: SteadyTurn) -> None:
    motion = turning.motion(start.t, start.q, np.zeros(0), start.x)
    rates = constraint_rows(system, motion).times(motion.u)
    rates[system.joints.size :] -= drive_at(system, start.t).rate
    off = np.abs(rates) / system.row_scale[system.bodies :]
    speed = float(np.linalg.norm(turning.rate))
    if off.max(initial=0.0) > THRESHOLDS.same_written * speed:
        whose = system.row_owner(int(np.argmax(off)) + system.bodies)
        said = f"{whose} keeps the mechanism from turning as one at this speed"
        raise InputError(Problem(said, hint="turn about the axis on which it stands, at the speed of its motions"))


def refuse_unsteady(rest: Equilibrium, turning: SteadyTurn, held: Conditions) -> None:
    """Raise InputError where some forces do not turn with the mechanism, as weight across the axis."""
    motion, system = rest.reference.motion, rest.reference.system
    half = 0.5 * turning.rate / np.linalg.norm(turning.rate)
    turn = np.array([np.cos(0.5), *(np.sin(0.5) * 2.0 * half)])
    A = rotation_matrix(turn)
    rows = motion.q.reshape(-1, 7)
    position = turning.point + (rows[:, :3] - turning.point) @ A.T
    q = np.concatenate([position, product(np.tile(turn, (len(rows), 1)), rows[:, 3:])], axis=1).ravel()
    before, after = (
        EquilibriumProblem.of(system, motion.t, motion.q, NO_DRIVE, held, motion.x, turning).at(x, motion.expected)
        for x in (motion.q, q)
    )
    turned = before.force.reshape(-1, 6).copy()
    turned[:, :3] = turned[:, :3] @ A.T
    off = np.abs((after.force - turned.ravel()) * before.space.lengths).max(initial=0.0)
    off = float(off / max(before.largest, float(np.finfo(float).tiny)))
    if off > THRESHOLDS.no_motion:
        said = f"forces do not turn with the mechanism: after a turn by 1 rad they are off by {off:.2g} of the largest"
        hint = "let gravity lie along the axis, and put springs and forces on bodies that turn"
        raise InputError(Problem(said, hint=hint))
