"""The glyphs of a scene's joints on their bodies, and the pedestals on the ground.

The wheels of gears are drawn at their pitch circles on the second body of each coupled joint. So are the two parts of a
Geneva drive.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.model.compile.frames import poses_of
from mbproj.pages.appearance.glyphs import GLYPHS, STANDING, GlyphFrame, pedestal, sketch_of
from mbproj.pages.appearance.layout import PartNumbers
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.appearance.parts import Solid, bar, cylinder, triad
from mbproj.pages.appearance.plates import Outline, both_outlines, track, wire_of
from mbproj.scene.read import Scene
from mbproj.scene.records import Joint

#: Axes are parallel where the sine of their angle is below this.
PARALLEL = 1e-6


def radii(points: Sequence[Array], axes: Sequence[Array], teeth: Sequence[float]) -> tuple[float, float] | None:
    """The pitch radii of two wheels with `teeth` (negative for inner teeth) about global axes (3,) through `points`.
    None where the axes are not parallel, or coincide, as these give no radii."""
    first, second = (axis / np.linalg.norm(axis) for axis in axes)
    if np.linalg.norm(np.cross(first, second)) > PARALLEL:
        return None
    between = points[1] - points[0]
    distance = float(np.linalg.norm(between - (between @ first) * first))
    whole = abs(teeth[0] + teeth[1])
    if distance == 0.0 or whole == 0.0:
        return None
    return abs(teeth[0]) * distance / whole, abs(teeth[1]) * distance / whole


def wheel(point: Array, axis: Array, normal: Array, radius: float, r: float) -> Iterator[Solid]:
    """A ring with two spokes, for links with the radius r."""
    yield Solid("tube", (radius + 0.3 * r, max(radius - 1.2 * r, 0.5 * radius), 1.2 * r), point, triad(axis, normal))
    for spoke in (normal, np.cross(axis, normal)):
        yield bar(point - 0.9 * radius * spoke, point + 0.9 * radius * spoke, 0.4 * r)[0]


def pin(point: Array, axis: Array, along: Array, crank: float, r: float) -> Iterator[Solid]:
    """The arm of a Geneva driver with its pin."""
    yield bar(point, point + crank * along, r)[0]
    yield cylinder(0.7 * r, 4.0 * r, point + crank * along, axis)


def slotted(point: Array, axis: Array, along: Array, distance: float, slots: int, r: float) -> Solid:
    """The slotted wheel of a Geneva drive, with one slot in the direction `along`. Slots reach as far as the pin comes,
    and widen outward so that the whole rim is visible from the centre."""
    rim, bottom = distance * np.cos(np.pi / slots), distance * (1.0 - np.sin(np.pi / slots)) - 0.8 * r
    wide, step = 0.8 * r / rim, 2.0 * np.pi / slots
    corners = []
    for slot in range(slots):
        angles = slot * step + np.linspace(wide, step - wide, 7)
        corners += [(bottom, slot * step - 0.9 * wide), (bottom, slot * step + 0.9 * wide), *((rim, a) for a in angles)]
    radius, angle = np.array(corners).T
    outline = Outline(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]), True, True, 0.0, 0.0)
    return track(outline, point, triad(axis, along), r)


#: The longest half of a pin, in thicknesses: a pin need not pass through the whole length of a long body.
LONGEST_PIN = 6.0
#: A pedestal stands above a joint that is higher than the middle of the motion by this part of the mechanism's size.
HANGS = 0.05


@dataclass(frozen=True, eq=False)
class DrawnPart:
    """A part with the number of its carrier body (-1 for the ground) and its layer ("bodies", "joints", "ground",
    "springs"). `item` is the number of the body, joint or force that it shows."""

    part: Solid
    carrier: int
    layer: str
    item: int


def joint_parts(
    scene: Scene, layout: PartNumbers, motion: PoseHistory, bodies: Sequence[Sequence[Solid]], up: Array
) -> Iterator[DrawnPart]:
    """The parts of all joints. `bodies` are the parts of each body; `up` (3,) points against gravity."""
    middle = motion.position[motion.finite].mean(axis=(0, 1)) if len(motion.finite) else np.zeros(3)
    for item, joint in enumerate(scene.joints):
        if joint.couples is not None:
            yield from _wheels(joint, item, layout, motion)
            continue
        frame = _frame(joint, layout, motion, bodies)
        pair = layout.bodies[joint.name]
        sketch = sketch_of(joint.type)
        for side, part in GLYPHS[sketch](frame):
            yield DrawnPart(part, pair[side - 1], "ground" if pair[side - 1] < 0 else "joints", item)
        if "path" in joint.parameters:
            yield from _rope_circles(scene, joint, item, layout)
        if sketch in STANDING and frame.ground:
            point = frame.points[frame.ground - 1]
            hangs = float((point - middle) @ up) > HANGS * layout.size
            for part in pedestal(point, up if hangs else -up, _pedestal_front(frame, up), layout.thickness):
                yield DrawnPart(part, -1, "ground", item)


def _frame(joint: Joint, layout: PartNumbers, motion: PoseHistory, bodies: Sequence[Sequence[Solid]]) -> GlyphFrame:
    symbols, pair, r = layout.frames[joint.name], layout.bodies[joint.name], layout.thickness
    ends = [motion.point(body, symbols[f"p{side}"]) for side, body in enumerate(pair, 1)]
    slid = np.einsum("ti,ti->t", ends[1] - ends[0], motion.vector(pair[0], symbols["z1"]))[motion.finite]
    clears = [
        float(np.abs((part.outline() - symbols[f"p{side}"]) @ symbols[f"z{side}"]).max(initial=0.0))
        for side, body in enumerate(pair, 1)
        if body >= 0
        for part in bodies[body]
        if _box_holds(part, symbols[f"p{side}"], r)
    ]
    return GlyphFrame(
        points=(symbols["p1"], symbols["p2"]),
        z=(symbols["z1"], symbols["z2"]),
        x=(symbols["x1"], symbols["x2"]),
        r=r,
        reach=min(max([1.3 * r, *clears]) + 0.35 * r, LONGEST_PIN * r),
        travel=(float(slid.min(initial=0.0)), float(slid.max(initial=0.0))),
        ground=1 + pair.index(-1) if -1 in pair else 0,
        radius=abs(joint.parameters["radius"]) if "radius" in joint.parameters else 0.0,
        semi_axes=joint.parameters.get("semi_axes", ()),
        outlines=both_outlines(joint),
        wire=wire_of(joint),
    )


def _rope_circles(scene: Scene, joint: Joint, item: int, layout: PartNumbers) -> Iterator[DrawnPart]:
    """The sheaves, wheels and drums of a rope."""
    poses, path = poses_of(scene), joint.parameters["path"]
    for node in path.nodes:
        if node.radius:
            position, turn = poses[node.body]
            centre, axis = turn.T @ (np.array(node.at.vector) - position), turn.T @ np.array(path.normal)
            carrier = layout.number[node.body]
            disc = cylinder(node.radius - 0.4 * layout.thickness, 1.6 * layout.thickness, centre, axis)
            yield DrawnPart(disc, carrier, "ground" if carrier < 0 else "joints", item)


def _box_holds(part: Solid, point: Array, r: float) -> bool:
    """Whether the point is in the part's box, enlarged by r."""
    corners = (part.outline() - part.position) @ part.rotation
    local = (point - part.position) @ part.rotation
    return bool(((local >= corners.min(axis=0) - r) & (local <= corners.max(axis=0) + r)).all())


def _pedestal_front(frame: GlyphFrame, up: Array) -> Array:
    """The horizontal direction that a pedestal's front faces: the joint's axis, where it is not upright."""
    for axis in (frame.z[frame.ground - 1], np.eye(3)[1], np.eye(3)[0]):
        level = axis - (axis @ up) * up
        if np.linalg.norm(level) > 0.1:
            return level / np.linalg.norm(level)
    raise AssertionError("two coordinate axes are not both upright")


def _wheels(joint: Joint, item: int, layout: PartNumbers, motion: PoseHistory) -> Iterator[DrawnPart]:
    """The wheels of a gear, where its axes determine their radii; the pulleys of a belt, and the pinion of a rack."""
    assert joint.couples is not None
    start = motion.at([0])
    frames = [layout.frames[name] for name in joint.couples.joints]
    owners = [layout.bodies[name][1] for name in joint.couples.joints]
    points = [start.point(owner, frame["p2"])[0] for owner, frame in zip(owners, frames, strict=True)]
    axes = [start.vector(owner, frame["z2"])[0] for owner, frame in zip(owners, frames, strict=True)]
    given = joint.parameters
    if "slots" in given:
        yield from _geneva(joint, item, layout, start, points, axes)
    sizes = [abs(radius) for radius in given.get("radii", (given["radius"],) if "radius" in given else ())]
    if "teeth" in given:
        sizes += radii(points, axes, given["teeth"]) or ()
    for radius, owner, frame in zip(sizes, owners, frames, strict=False):
        for part in wheel(frame["p2"], frame["z2"], frame["x2"], radius, layout.thickness):
            yield DrawnPart(part, owner, "joints", item)


def _geneva(
    joint: Joint, item: int, layout: PartNumbers, start: PoseHistory, points: Sequence[Array], axes: Sequence[Array]
) -> Iterator[DrawnPart]:
    """The pin and the slotted wheel of a Geneva drive. Where both coordinates are zero the pin is on the line of
    centres, in a slot."""
    assert joint.couples is not None
    line = points[1] - points[0]
    line = line - (line @ axes[0]) * axes[0]
    distance, slots = float(np.linalg.norm(line)), int(joint.parameters["slots"])
    if distance == 0.0:
        return
    for side, name in enumerate(joint.couples.joints):
        frame, (carrier, owner) = layout.frames[name], layout.bodies[name]
        parts = [float(start.vector(carrier, frame[axis])[0] @ line) / distance for axis in ("x1", "y1")]
        along = (1.0 if side == 0 else -1.0) * (parts[0] * frame["x2"] + parts[1] * frame["y2"])
        if side == 0:
            drawn = [*pin(frame["p2"], frame["z2"], along, distance * np.sin(np.pi / slots), layout.thickness)]
        else:
            drawn = [slotted(frame["p2"], frame["z2"], along, distance, slots, layout.thickness)]
        for part in drawn:
            yield DrawnPart(part, owner, "joints", item)


def up_of(scene: Scene) -> Array:
    """The direction (3,) against gravity; z where there is no gravity."""
    gravity = np.array(scene.gravity)
    size = float(np.linalg.norm(gravity))
    return -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
