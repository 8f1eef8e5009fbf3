"""The view of a mechanism: along the normal of the plane in which it moves, or otherwise from above and one side."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.pages.appearance.joints import up_of
from mbproj.pages.appearance.mechanism import Look
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.scene.read import Scene

#: The tolerances for parallel axes and for a motion in one plane.
PARALLEL, IN_PLANE = 1e-6, 1e-6
#: A mechanism is flat where its depth is less than this part of its size.
FLAT = 0.12
#: The view of a mechanism that is not flat: its front, turned and raised by these angles in degrees.
TURNED, RAISED = 32.0, 22.0
#: The samples from which the view is computed, and the directions in which outermost points are searched.
SAMPLES, DIRECTIONS = 60, 150


@dataclass(frozen=True, eq=False)
class View:
    """The direction `eye` (3,) from the `middle` (3,) to the viewer, and the direction `up` (3,). All that moves is
    within `radius` of the middle; `points` (k, 3) are its outermost points, m. `flat`: the view is along the normal of
    the motion's plane, without perspective."""

    middle: Array
    eye: Array
    up: Array
    radius: float
    points: Array
    flat: bool


def view_of(scene: Scene, motion: PoseHistory, look: Look) -> View:
    """The view that shows the whole motion."""
    whole = motion.finite
    some = motion.at(whole[np.unique(np.linspace(0, len(whole) - 1, SAMPLES).astype(int))])
    cloud = _cloud(look, some)
    low, high = cloud.min(axis=(0, 1)), cloud.max(axis=(0, 1))
    middle, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    points = outermost(cloud.reshape(-1, 3), 2.0 * look.thickness)
    normal = _normal(look, some)
    up = up_of(scene)
    if normal is None:
        return View(middle, _raised(np.array([0.0, -1.0, 0.0]), up), up, radius, points, False)
    if abs(normal @ up) > 0.9:
        up = np.eye(3)[1] if abs(normal[2]) > 0.7 else np.eye(3)[2]
    up = up - (up @ normal) * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    eye = normal if right[np.argmax(np.abs(right))] > 0.0 else -normal
    depth = float(np.ptp(cloud @ normal))
    flat = depth <= FLAT * 2.0 * radius
    return View(middle, eye if flat else _raised(eye, up), up, radius, points, flat)


def outermost(cloud: Array, margin: float) -> Array:
    """The points of `cloud` (.., 3) that reach farthest in many directions, moved outward by `margin`."""
    count = np.arange(DIRECTIONS)
    height, turn = 1.0 - (2.0 * count + 1.0) / DIRECTIONS, count * np.pi * (3.0 - np.sqrt(5.0))  # a Fibonacci sphere
    flat = np.sqrt(1.0 - height**2)
    directions = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    points: Array = cloud[np.argmax(cloud @ directions.T, axis=0)] + margin * directions
    return points


def _cloud(look: Look, motion: PoseHistory) -> Array:
    """Points (T, k, 3) over which the mechanism extends: corners of its bodies, joints, markers, ends of springs,
    wheels and contacts."""
    rolls = {each.name for each in look.touching}
    points = [(joint.bodies[1], joint.point) for joint in look.joints]
    points += [(marker.body, marker.point) for marker in look.markers]
    points += [end for span in look.spans for end in zip(span.carriers, span.points, strict=True)]
    for drawn in look.drawn:
        is_plate = drawn.layer == "springs" and drawn.part.kind == "box"  # the plane of a stop
        is_wheel = drawn.layer == "joints" and look.joints[drawn.item].name in rolls
        if drawn.layer == "bodies" or is_plate or is_wheel:
            corners = drawn.part.outline()
            points += [(drawn.carrier, corner) for corner in _corners(corners.min(axis=0), corners.max(axis=0))]
    moved = [motion.point(body, local) for body, local in points]
    return np.stack(moved + [each.path(motion) for each in look.touching], axis=1)


def _corners(low: Array, high: Array) -> Array:
    """The corners (8, 3) of a box."""
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def _normal(look: Look, motion: PoseHistory) -> Array | None:
    """The normal (3,) of the plane of the motion, from the common direction of the axes or from the paths. None where
    bodies leave the plane."""
    axes = [motion.vector(joint.bodies[1], joint.axis)[0] for joint in look.joints if joint.axis is not None]
    moved = (motion.position - motion.position[:1]).reshape(-1, 3)
    _, sizes, directions = np.linalg.svd(moved, full_matrices=False)
    if axes:
        normal = axes[0] / np.linalg.norm(axes[0])
        if any(np.linalg.norm(np.cross(axis, normal)) > PARALLEL for axis in axes):
            return None
    elif len(sizes) == 3 and sizes[1] > IN_PLANE * sizes[0]:
        normal = directions[2]
    else:
        return None
    leaves = float(np.abs(moved @ normal).max(initial=0.0))
    turns = rotation_matrix(motion.orientation)
    tilts = float(
        np.abs(turns @ (np.swapaxes(turns[0], -1, -2) @ normal)[:, :, None] - normal[:, None]).max(initial=0.0)
    )
    travel = float(np.abs(moved).max(initial=0.0))
    return normal if leaves <= IN_PLANE * max(travel, look.thickness) and tilts <= IN_PLANE else None


def _raised(front: Array, up: Array) -> Array:
    """The direction `front`, turned and raised."""
    level = front - (front @ up) * up
    if np.linalg.norm(level) < 0.1:
        level = np.eye(3)[0] - up[0] * up
    level /= np.linalg.norm(level)
    right = np.cross(up, level)
    turn, raised = np.radians(TURNED), np.radians(RAISED)
    direction: Array = np.cos(raised) * (np.cos(turn) * level + np.sin(turn) * right) + np.sin(raised) * up
    return direction
