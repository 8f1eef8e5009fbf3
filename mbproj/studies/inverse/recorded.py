"""The motion that a run recorded: poses, velocities and accelerations of its samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array, cross
from mbproj.dynamics.assembly.assemble import coordinate_values
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime
from mbproj.dynamics.derivatives.tangent import tangent_velocities
from mbproj.dynamics.equations.gaps import gaps
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.errors import InputError, Place, Problem
from mbproj.linear.states import sampled_state
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.system import System
from mbproj.results import Results

_MOTION = tuple(
    f"bodies/{name}"
    for name in ("position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration")
)


def motions_of(system: System, results: Results) -> Iterator[MotionAtTime]:
    """Yield the motion at each sample. Raises InputError where the results are of other bodies."""
    if tuple(results.names("bodies")) != system.names.bodies:
        said = f"'{results.path}' has other bodies than the scene"
        raise InputError(Problem(said, hint="give results of this scene, or the scene of these results"))
    paths = ("time", *_MOTION, "joints/coordinate", *system.layout.recorded)
    block = {path: results[path] for path in paths}
    for sample in range(len(results.time)):
        state = sampled_state(system, block, sample)
        pose = pose_of(state.q)
        u = tangent_velocities(pose, state.v)
        expected = coordinate_values(system, pose) + 2.0 * np.pi * state.turns
        change = _change(
            system, block["bodies/acceleration"][sample], block["bodies/angular_acceleration"][sample], u, state.q
        )
        yield MotionAtTime(state.t, state.q, u, change, expected, state.x)


def _change(system: System, acceleration: Array, angular: Array, u: Array, q: Array) -> Array:
    """The accelerations u' (6n,) of the carriers, each from the first body fixed to it."""
    first = np.array([np.flatnonzero(system.body_carrier == carrier)[0] for carrier in range(system.bodies)])
    turn, offset = rotation_matrix(system.body_turn[first]), system.body_offset[first]
    ω, ω_dot = u.reshape(-1, 6)[:, 3:], (turn @ angular[first][..., None])[..., 0]
    swung = cross(ω_dot, offset) + cross(ω, cross(ω, offset))
    r_ddot = acceleration[first] - (pose_of(q).rotation[:-1] @ swung[..., None])[..., 0]
    return np.concatenate([r_ddot, ω_dot], axis=1).ravel()


def refuse_unknown_forces(system: System, motion: MotionAtTime, *, states_known: bool) -> None:
    """Raises InputError where forces act that the motion does not determine. These are friction by the load of a
    bearing or at a stop, a stop in contact, and element states that are not given."""
    frictions = system.frictions
    loaded = [] if frictions is None else np.flatnonzero((frictions.bearing >= 0) | (frictions.stop >= 0)).tolist()
    if loaded or (system.forces.laws.bearing >= 0).any():
        name = system.names.frictions[loaded[0]] if loaded else "a bearing's friction"
        message = f"dry friction '{name}' depends on the reactions of joints, which the actuators change"
        raise _refused(message, "drive the scene by motions: mbproj run SCENE, then mbproj info RESULTS --loads")
    if system.states.size and not states_known:
        message = f"state '{system.names.states[0]}' of an element does not follow from a motion"
        raise _refused(message, "run the scene with motions, and give its results")
    if system.stops is not None:
        turns = np.round((motion.expected - coordinate_values(system, motion.pose)) / (2.0 * np.pi)).astype(np.intp)
        gap = gaps(system.stops, motion.pose, turns)
        if gap.min(initial=1.0) <= 0.0:
            touched = system.names.stops[int(np.argmin(gap))]
            message = f"stop '{touched}' is touched at t = {motion.t:.6g} s, and its force is not known"
            raise _refused(message, "give a motion that stays off the stops")


def _refused(message: str, hint: str) -> InputError:
    return InputError(Problem(message, Place("loads"), hint))
