"""The glyphs of a scene's joints on their bodies, and the pedestals on the ground.

The wheels of gears are drawn at their pitch circles on the second body of each coupled joint. So are the two parts of a
Geneva drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Line
from mbproj.joints.table import JOINTS
from mbproj.model.compile.frames import poses_of
from mbproj.scene.records import Joint
from mbproj.scene.scene import Scene
from mbproj.show.appearance.layout import PartNumbers
from mbproj.show.appearance.motion import PoseHistory
from mbproj.show.appearance.parts import (
    Outline,
    Solid,
    bar,
    both_outlines,
    box,
    cylinder,
    ellipsoid,
    sphere,
    track,
    triad,
    wire,
    wires_of,
)

# --- The glyph of each type of joint ----------------------------------------------------------------------------------
# Small solids on its two bodies that show what it holds, and about which axes.


@dataclass(frozen=True, eq=False)
class GlyphFrame:
    """The points (3,) and axes z, x (3,) of a joint in the axes of its bodies 1 and 2, and the sizes that its glyph
    needs.

    `r` is the radius of a link, `reach` half the length of a pin, in m. `travel` is the range of body 2's point along
    z1 in m. `ground` is the side that is the ground, or 0. `radius` is that of the joint or its roller, or 0.
    `semi_axes` are those of an ellipsoid. `outlines` are the curves of bodies 1 and 2, `wires` are lines of body 1 in
    space."""

    points: tuple[Array, Array]
    z: tuple[Array, Array]
    x: tuple[Array, Array]
    r: float
    reach: float
    travel: tuple[float, float]
    ground: int
    radius: float = 0.0
    semi_axes: tuple[float, ...] = ()
    outlines: tuple[Outline, ...] = ()
    wires: tuple[Line, ...] = ()

    def triad(self, side: int) -> Array:
        """The rotation (4,) of the frame in body `side`."""
        return triad(self.z[side - 1], self.x[side - 1])


#: A function that yields the parts of a glyph, each with the side of the joint that carries it: 1 or 2.
Glyph = Callable[[GlyphFrame], Iterator[tuple[int, Solid]]]


def _pin(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A pin along the axis, with a head at both ends."""
    yield 1, cylinder(0.95 * frame.r, 2.0 * frame.reach, frame.points[0], frame.z[0])
    for end in (-1.0, 1.0):
        at = frame.points[0] + end * frame.reach * frame.z[0]
        yield 1, cylinder(1.35 * frame.r, 0.4 * frame.r, at, frame.z[0])


def _ball(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    yield 2, sphere(1.6 * frame.r, frame.points[1])


def _cross(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """The cross of a universal joint: a pin in each body."""
    for side in (1, 2):
        yield side, cylinder(0.75 * frame.r, 6.0 * frame.r, frame.points[side - 1], frame.z[side - 1])
    yield 1, sphere(1.3 * frame.r, frame.points[0])


def _weld(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    yield 1, box([2.6 * frame.r] * 3, frame.points[0], frame.triad(1))


def _rail(frame: GlyphFrame) -> tuple[int, Solid, int]:
    """The side that carries the rail of a sliding joint, the rail, and the side of the slider. The ground, where it is
    one of the bodies, carries the rail."""
    side = 2 if frame.ground == 2 else 1
    low, high = frame.travel if side == 1 else (-frame.travel[1], -frame.travel[0])
    low, high = low - 4.0 * frame.r, high + 4.0 * frame.r
    middle = frame.points[side - 1] + 0.5 * (low + high) * frame.z[side - 1]
    return side, cylinder(0.55 * frame.r, high - low, middle, frame.z[side - 1]), 3 - side


def _slider(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A square block on a rail, or a square collar between two bodies that move."""
    side, rail, other = _rail(frame)
    if frame.ground:
        yield side, rail
    r = frame.r
    yield other, box([3.4 * r, 3.4 * r, 5.0 * r], frame.points[other - 1], frame.triad(other))


def _sleeve(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A round sleeve on a rail, because it can turn too."""
    side, rail, other = _rail(frame)
    yield side, rail
    turn = frame.triad(other)
    yield other, Solid("tube", (1.9 * frame.r, 0.6 * frame.r, 5.0 * frame.r), frame.points[other - 1], turn)


def _screw(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A nut on a rail whose rings are its thread."""
    side, rail, other = _rail(frame)
    yield side, rail
    length = rail.size[1]
    for at in np.linspace(-0.5 * length, 0.5 * length, max(3, min(40, int(length / (1.2 * frame.r))))):
        yield side, cylinder(0.8 * frame.r, 0.25 * frame.r, rail.position + at * frame.z[side - 1], frame.z[side - 1])
    yield (
        other,
        Solid("tube", (2.2 * frame.r, 0.8 * frame.r, 3.0 * frame.r), frame.points[other - 1], frame.triad(other)),
    )


def _on_line(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A ball on the line of body 1."""
    low, high = frame.travel[0] - 4.0 * frame.r, frame.travel[1] + 4.0 * frame.r
    middle = frame.points[0] + 0.5 * (low + high) * frame.z[0]
    yield 1, cylinder(0.55 * frame.r, high - low, middle, frame.z[0])
    yield from _ball(frame)


def _sheet(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A piece of the plane of body 1."""
    half = 8.0 * frame.r
    yield 1, box([2.0 * half, 2.0 * half, 0.2 * frame.r], frame.points[0], frame.triad(1))


def _puck(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A disc that slides and turns on a plane."""
    yield from _sheet(frame)
    yield 2, cylinder(2.4 * frame.r, 0.9 * frame.r, frame.points[1], frame.z[1])


def _on_plane(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    yield from _sheet(frame)
    yield from _ball(frame)


def _wheel(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A rim with two spokes, which show its rotation."""
    width = 0.9 * frame.r
    wall = min(0.5 * frame.r, 0.15 * frame.radius)
    yield 2, Solid("tube", (frame.radius, frame.radius - wall, width), frame.points[1], frame.triad(2))
    for first, second in ((1.0, 0.0), (0.0, 1.0)):
        size = [
            2.0 * frame.radius * first + 0.35 * frame.r * second,
            2.0 * frame.radius * second + 0.35 * frame.r * first,
        ]
        yield 2, box([*size, 0.5 * width], frame.points[1], frame.triad(2))


def _rolling_ball(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A ball with a band, which shows its rotation."""
    yield 2, sphere(frame.radius, frame.points[1])
    yield 2, cylinder(1.01 * frame.radius, 0.2 * frame.radius, frame.points[1], frame.x[1])


def _ellipsoid(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """An ellipsoid with a small ball at one end, which shows its rotation."""
    yield 2, ellipsoid(frame.semi_axes, frame.points[1], frame.triad(2))
    yield 2, sphere(0.12 * min(frame.semi_axes), frame.points[1] + frame.semi_axes[0] * frame.x[1])


def _blade(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """A blade along its edge."""
    yield 2, box([7.0 * frame.r, 2.0 * frame.r, 0.3 * frame.r], frame.points[1], frame.triad(2))


def _pin_and_ball(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """The ends of a rod: a pin in body 1 and a ball in body 2."""
    yield 1, cylinder(0.95 * frame.r, 4.0 * frame.r, frame.points[0], frame.z[0])
    yield from _ball(frame)


def _track(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """The curve of body 1, and on it the pin or roller of body 2."""
    (outline,) = frame.outlines
    yield 1, track(outline, frame.points[0], frame.triad(1), frame.r)
    yield 2, cylinder(outline.roller or 0.8 * frame.r, 2.4 * frame.r, frame.points[1], frame.z[1])


def _wire(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """The lines of body 1 in space, and on them the ball of body 2."""
    for each in frame.wires:
        yield 1, wire(each, frame.points[0], frame.triad(1), frame.r)
    yield 2, sphere(frame.radius or 1.6 * frame.r, frame.points[1])


def _tappet(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """The disc of body 1, and the flat face of body 2, as wide as the disc needs, with a stem."""
    (outline,) = frame.outlines
    yield 1, track(outline, frame.points[0], frame.triad(1), frame.r)
    edges = [2.4 * frame.r, 2.0 * (outline.face + frame.r), 0.8 * frame.r]
    yield 2, box(edges, frame.points[1] + 0.4 * frame.r * frame.z[1], frame.triad(2))
    yield 2, cylinder(0.8 * frame.r, 4.0 * frame.r, frame.points[1] + 2.4 * frame.r * frame.z[1], frame.z[1])


def _tracks(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    """The curve of each body."""
    for side, outline in enumerate(frame.outlines, 1):
        yield side, track(outline, frame.points[side - 1], frame.triad(side), frame.r)


def _two_balls(frame: GlyphFrame) -> Iterator[tuple[int, Solid]]:
    yield 1, sphere(1.4 * frame.r, frame.points[0])
    yield 2, sphere(1.4 * frame.r, frame.points[1])


#: The glyphs by the `sketch` of the table of joints. Gears, which have no frame of their own, are in `gears`.
GLYPHS: Mapping[str, Glyph] = MappingProxyType(
    {
        "pin": _pin,
        "ball": _ball,
        "cross": _cross,
        "slider": _slider,
        "sleeve": _sleeve,
        "puck": _puck,
        "weld": _weld,
        "two_balls": _two_balls,
        "pin_and_ball": _pin_and_ball,
        "on_plane": _on_plane,
        "on_line": _on_line,
        "screw": _screw,
        "wheel": _wheel,
        "rolling_ball": _rolling_ball,
        "ellipsoid": _ellipsoid,
        "blade": _blade,
        "track": _track,
        "tappet": _tappet,
        "tracks": _tracks,
        "wire": _wire,
    }
)
#: The glyph of a joint without a `sketch`, by its kind of frame.
OF_FRAMES = MappingProxyType({"point": "ball", "axis": "pin", "normal": "on_plane", "axes": "cross"})
#: The glyphs that get a pedestal where they hold a body to the ground.
STANDING = frozenset({"pin", "ball", "cross", "two_balls", "pin_and_ball"})


def sketch_of(type_name: str) -> str:
    """The name of the glyph of a joint of this type."""
    kind = JOINTS[type_name]
    return kind.sketch or OF_FRAMES[kind.frame]


def pedestal(point: Array, down: Array, across: Array, r: float) -> Iterator[Solid]:
    """The pedestal of a joint on the ground: a pyramid below `point` on a plate. Its front faces `across`."""
    from mbproj.show.appearance.parts import UPRIGHT, Mesh

    side = np.cross(down, across)
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    foot = [3.6 * r * down + r * (2.0 * a * side + 1.2 * b * across) for a, b in corners]
    triangles = np.array([[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4], [1, 2, 3], [1, 3, 4]])
    yield Solid("mesh", (), point, np.array(UPRIGHT), Mesh(np.array([0.0 * down, *foot]), triangles))
    yield box([6.0 * r, 3.4 * r, 0.5 * r], point + 3.85 * r * down, triad(down, side))


# --- The glyphs of a scene's joints on their bodies, and the pedestals on the ground ----------------------------------


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
        radius=abs(joint.parameters.get("radius", joint.parameters.get("roller", 0.0))),
        semi_axes=joint.parameters.get("semi_axes", ()),
        outlines=both_outlines(joint),
        wires=wires_of(joint),
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
    numbers = joint.parameters
    if "slots" in numbers:
        yield from _geneva(joint, item, layout, start, points, axes)
    sizes = [abs(radius) for radius in numbers.get("radii", (numbers["radius"],) if "radius" in numbers else ())]
    if "teeth" in numbers:
        sizes += radii(points, axes, numbers["teeth"]) or ()
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
