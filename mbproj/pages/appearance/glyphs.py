"""The glyph of each type of joint: small solids on its two bodies that show what it holds, and about which axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.joints import JOINTS
from mbproj.pages.appearance.parts import Solid, box, cylinder, ellipsoid, sphere, triad
from mbproj.pages.appearance.plates import Outline, Wire, track, wire


@dataclass(frozen=True, eq=False)
class GlyphFrame:
    """The points (3,) and axes z, x (3,) of a joint in the axes of its bodies 1 and 2, and the sizes that its glyph
    needs.

    `r` is the radius of a link, `reach` half the length of a pin, in m. `travel` is the range of body 2's point along
    z1 in m. `ground` is the side that is the ground, or 0. `radius` is that of the joint, or 0; `semi_axes` are those
    of an ellipsoid. `outlines` are the curves of bodies 1 and 2, `wire` that of body 1 in space."""

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
    wire: Wire | None = None

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
    """The space curve of body 1, and on it the ball of body 2."""
    assert frame.wire is not None
    yield 1, wire(frame.wire, frame.points[0], frame.triad(1), frame.r)
    yield from _ball(frame)


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
    from mbproj.pages.appearance.parts import UPRIGHT, Mesh

    side = np.cross(down, across)
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    foot = [3.6 * r * down + r * (2.0 * a * side + 1.2 * b * across) for a, b in corners]
    triangles = np.array([[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4], [1, 2, 3], [1, 3, 4]])
    yield Solid("mesh", (), point, np.array(UPRIGHT), Mesh(np.array([0.0 * down, *foot]), triangles))
    yield box([6.0 * r, 3.4 * r, 0.5 * r], point + 3.85 * r * down, triad(down, side))
