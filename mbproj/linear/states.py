"""States to linearise at: the start of a scene, a time of its run, a time of a results file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, cross
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinate_values, is_angle
from mbproj.equations.kinematics import pose_of
from mbproj.equations.tangent_space import velocities
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System
from mbproj.motion.simulate import simulate
from mbproj.results.record import Results
from mbproj.scene.scene import Scene
from mbproj.scene.settings import settings_to_run


def state_at(scene: Scene, system: System, time: float) -> State:
    """Return the state at a time in s, by a run from the scene's initial state. Raises SimulationError where the run
    does not reach it."""
    start = start_state(scene, system)
    if time <= start.t:
        return replace(start, t=time)
    last = _Last()
    settings = replace(scene.settings, duration=time - start.t, output_step=None)
    simulate(system, start, settings_to_run(replace(scene, settings=settings)), last)
    return sampled_state(system, last.block, -1)


def stored_state(system: System, results: Results, time: float) -> State:
    """Return the sample at this time. Raises InputError where there is none, or where the results are of other
    bodies."""
    if tuple(results.names("bodies")) != system.names.bodies:
        said = f"'{results.path}' has other bodies than the scene"
        raise InputError(Problem(said, hint="give results of this scene, or the scene of these results"))
    times = results.time
    span = max(float(np.abs(times).max(initial=0.0)), abs(time))
    nearest = int(np.argmin(np.abs(times - time))) if len(times) else -1
    if nearest < 0 or abs(times[nearest] - time) > THRESHOLDS.same_written * span:
        have = f"its nearest is at {times[nearest]:.9g} s" if len(times) else "it has no samples"
        raise InputError(Problem(f"'{results.path}' has no sample at t = {time:.9g} s", hint=have))
    paths = [f"bodies/{name}" for name in ("position", "orientation", "velocity", "angular_velocity")]
    block = {path: results[path][nearest][None] for path in (*paths, "joints/coordinate", *system.layout.recorded)}
    return sampled_state(system, {"time": times[nearest : nearest + 1], **block}, 0)


@final
class _Last:
    """A recorder that keeps the last block of a run."""

    def __init__(self) -> None:
        self.block: Mapping[str, npt.NDArray[Any]] = {}

    def write(self, block: Mapping[str, npt.NDArray[Any]]) -> None:
        """Keep a block."""
        self.block = block


def sampled_state(system: System, block: Mapping[str, npt.NDArray[Any]], sample: int) -> State:
    """Return one sample of the scene's bodies as a state of the carriers; the pose of a carrier is that of its first
    body."""
    first = np.array([np.flatnonzero(system.body_carrier == carrier)[0] for carrier in range(system.bodies)])
    position, orientation, velocity, ω = (
        np.asarray(block[f"bodies/{name}"][sample], dtype=float)[first]
        for name in ("position", "orientation", "velocity", "angular_velocity")
    )
    turn, offset = system.body_turn[first], system.body_offset[first]
    back = turn * [1.0, -1.0, -1.0, -1.0]
    Λ: Array = product(orientation / np.linalg.norm(orientation, axis=1, keepdims=True), back)
    rate = (rotation_matrix(turn) @ ω[..., None])[..., 0]
    A = rotation_matrix(Λ)
    r = position - (A @ offset[..., None])[..., 0]
    r_dot = velocity - (A @ cross(rate, offset)[..., None])[..., 0]
    q = np.concatenate([r, Λ], axis=1).ravel()
    pose = pose_of(q)
    counted = np.asarray(block["joints/coordinate"][sample], dtype=float)
    turns = np.round((counted - coordinate_values(system, pose)) / (2.0 * np.pi)).astype(np.intp) * is_angle(system)
    u = np.concatenate([r_dot, rate], axis=1).ravel()
    recorded = {name: block[path][sample] for path, name in system.layout.recorded.items()}
    blocks = {"positions": q, "velocities": velocities(pose, u), "turns": turns}
    return State.of(system, float(block["time"][sample]), **blocks, **recorded)
