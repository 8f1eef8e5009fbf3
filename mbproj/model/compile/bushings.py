"""The scene's bushings as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem
from mbproj.lanes import numbers
from mbproj.model.bushings import Bushings
from mbproj.model.compile.frames import Pose
from mbproj.model.compile.rigid_groups import Seat
from mbproj.scene.fields.rotations import from_matrix, to_matrix
from mbproj.scene.records import Bushing, Matrix, Scene


def compile_bushings(
    scene: Scene, bushings: Sequence[Bushing], seats: Mapping[str, Seat], poses: Mapping[str, Pose]
) -> Bushings:
    """Return all bushings. Raises InputError where a bushing connects two frames of one rigid body."""
    frames = [[_frame(bushing, side, seats, poses) for side in (0, 1)] for bushing in bushings]
    body = np.array([[seats[name].carrier for name in bushing.bodies] for bushing in bushings], dtype=np.intp)
    for bushing, (first, second) in zip(bushings, body.reshape(-1, 2), strict=True):
        if first == second:
            what = f"force '{bushing.name}' acts between two frames of one rigid body"
            raise InputError(Problem(what, scene.place("forces", bushing.name), "fixed joints have merged its bodies"))
    return Bushings(
        body=body.reshape(-1, 2),
        origin=numbers([[origin for origin, _ in pair] for pair in frames]).reshape(-1, 2, 3),
        turn=numbers([[turn for _, turn in pair] for pair in frames]).reshape(-1, 2, 4),
        stiffness=_blocks([bushing.stiffness for bushing in bushings]),
        damping=_blocks([bushing.damping for bushing in bushings]),
        preload=numbers([bushing.preload for bushing in bushings]).reshape(-1, 6),
    )


def _frame(
    bushing: Bushing, side: int, seats: Mapping[str, Seat], poses: Mapping[str, Pose]
) -> tuple[Array, tuple[float, ...]]:
    """Return the origin (3,) of a bushing's frame in the axes of its carrier, and the Euler parameters of the rotation
    from frame to carrier."""
    name = bushing.bodies[side]
    position, rotation = poses[name]
    point = numbers((bushing.points.first, bushing.points.second)[side])
    axes = numbers(to_matrix((bushing.axes.first, bushing.axes.second)[side]))
    origin = point if bushing.points.local else rotation.T @ (point - position)
    turn = axes if bushing.axes.local else rotation.T @ axes
    return seats[name].point(origin), from_matrix((seats[name].turn @ turn).tolist())


def _blocks(pairs: Sequence[tuple[Matrix, Matrix]]) -> Array:
    """Return block-diagonal matrices (B, 6, 6) from pairs of blocks (3, 3), translation and rotation."""
    blocks = numbers(pairs).reshape(-1, 2, 3, 3)
    found = np.zeros((len(pairs), 6, 6), like=blocks)
    found[:, :3, :3], found[:, 3:, 3:] = blocks[:, 0], blocks[:, 1]
    return found
