"""From where a mechanism is looked at: along the normal of a plane that it moves in, else from above and one side."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.pages.appearance.joints import up_of
from mbproj.pages.appearance.mechanism import Look
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.scene.records import Scene

#: Axes are parallel, and a motion is in a plane, to this.
PARALLEL, IN_PLANE = 1e-6, 1e-6
#: A mechanism is flat where it is less than this part of its size deep.
FLAT = 0.12
#: The view of what is not flat: from its front, turned and raised by so many degrees.
TURNED, RAISED = 32.0, 22.0
#: Samples that are looked at, and directions in which the outermost points are looked for.
SAMPLES, DIRECTIONS = 60, 150


@dataclass(frozen=True, eq=False)
class View:
    """From the `middle` (3,) the eye is in the direction `eye` (3,), `up` (3,) is up; all that moves is within `radius`
    of it, and `points` (k, 3) are the outermost of it, m. `flat`: seen along the normal of its plane, without
    perspective."""

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
    """Of points (.., 3) those that reach farthest in many directions, moved out by `margin`."""
    count = np.arange(DIRECTIONS)
    height, turn = 1.0 - (2.0 * count + 1.0) / DIRECTIONS, count * np.pi * (3.0 - np.sqrt(5.0))  # a Fibonacci sphere
    flat = np.sqrt(1.0 - height**2)
    directions = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])
    found: Array = cloud[np.argmax(cloud @ directions.T, axis=0)] + margin * directions
    return found


def _cloud(look: Look, motion: PoseHistory) -> Array:
    """Points (T, k, 3) that show where the mechanism is: corners of its bodies' parts, joints, markers, springs, what
    rolls and where it touches."""
    rolls = {each.name for each in look.touching}
    points = [(joint.bodies[1], joint.point) for joint in look.joints]
    points += [(marker.body, marker.point) for marker in look.markers]
    points += [end for span in look.spans for end in zip(span.carriers, span.points, strict=True)]
    for drawn in look.drawn:
        is_plate = drawn.layer == "springs" and drawn.part.kind == "box"  # where something is stopped
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
    """The normal (3,) of the plane of the motion: the common direction of the axes, or what nothing moves along and all
    turn about. None where there is none."""
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
    """A direction turned from the front and raised."""
    level = front - (front @ up) * up
    if np.linalg.norm(level) < 0.1:
        level = np.eye(3)[0] - up[0] * up
    level /= np.linalg.norm(level)
    right = np.cross(up, level)
    turn, raised = np.radians(TURNED), np.radians(RAISED)
    found: Array = np.cos(raised) * (np.cos(turn) * level + np.sin(turn) * right) + np.sin(raised) * up
    return found
