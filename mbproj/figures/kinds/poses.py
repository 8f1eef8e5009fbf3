"""A pose of a mechanism as polygons: the outlines of its parts as seen by the viewer, the farthest first."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.pages.appearance.mechanism import DrawnSpan, Look
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.appearance.parts import Solid, bar
from mbproj.pages.appearance.plates import hull
from mbproj.pages.appearance.view import View

ROD, SPRING = "#5d6875", "#2f8f6b"
#: The colours of layers other than bodies.
LAYERS = {"joints": "#363d47", "ground": "#8a9099", "springs": SPRING}
#: The parts by which a face towards the viewer is lightened, and its edges are darkened.
LIGHT, EDGE = 0.28, 0.45
#: The turns of a spring, and the points of each.
TURNS, ROUND = 8, 12


@dataclass(frozen=True, eq=False)
class Polygon:
    """A polygon (k, 2) in the picture, with its depth towards the viewer and its colour."""

    outline: Array
    depth: float
    colour: tuple[float, float, float]
    edge: float = EDGE


def draw_pose(
    axis: Axes, look: Look, view: View, motion: PoseHistory, *, opacity: float = 1.0, order: float = 2.0
) -> None:
    """Draw the first sample of the motion. `opacity` is that of all parts, `order` matplotlib's zorder."""
    shapes = sorted(_shapes(look, view, motion), key=lambda shape: shape.depth)
    axis.add_collection(
        PolyCollection(
            [shape.outline for shape in shapes],
            facecolors=[(*shape.colour, opacity) for shape in shapes],
            edgecolors=[(*_mixed(shape.colour, (0.0, 0.0, 0.0), shape.edge), opacity) for shape in shapes],
            linewidths=0.5,
            joinstyle="round",
            zorder=order,
        )
    )
    for span in look.spans:
        _draw_span(axis, span, look, view, motion, opacity, order)


def projected(points: Array, view: View) -> Array:
    """Global points (..., 3) in the picture's axes, right and up, (..., 2) in m."""
    return points @ np.column_stack(picture_axes(view))


def picture_axes(view: View) -> tuple[Array, Array]:
    """The global directions (3,) of right and up in the picture."""
    right = np.cross(view.up, view.eye)
    right = right / np.linalg.norm(right)
    return right, np.cross(view.eye, right)


def _shapes(look: Look, view: View, motion: PoseHistory) -> Iterator[Polygon]:
    """The polygons of all parts. Parts of a joint are in front of bodies at the same depth."""
    lift = {
        "bodies": 0.0,
        "joints": 0.8 * look.thickness,
        "ground": 0.2 * look.thickness,
        "springs": 0.9 * look.thickness,
    }
    for drawn in look.drawn:
        base = look.bodies[drawn.item].colour if drawn.layer == "bodies" else LAYERS[drawn.layer]
        if drawn.part.mesh is not None and not drawn.part.mesh.convex:
            yield from _triangles(drawn.part, drawn.carrier, base, view, motion)
            continue
        for points, light in _faces(drawn.part, drawn.carrier, view, motion):
            depth = float(points.mean(axis=0) @ view.eye) + lift[drawn.layer]
            colour = _mixed(to_rgb(base), (1.0, 1.0, 1.0), LIGHT * light)
            yield Polygon(hull(projected(points, view)), depth, colour)


def _faces(part: Solid, carrier: int, view: View, motion: PoseHistory) -> Iterator[tuple[Array, float]]:
    """Yield convex sets of global points (k, 3) that cover the part, each with its light (0 to 1)."""
    corners = _placed(part.outline(), carrier, motion)
    yield corners, 0.35
    if part.kind not in ("box", "cylinder", "tube"):
        return
    rotation = part.rotation
    for column, length in enumerate(part.size if part.kind == "box" else (0.0, 0.0, part.size[-1])):
        for side in (1.0, -1.0):
            normal = side * rotation[:, column]
            facing = float(motion.vector(carrier, normal)[0] @ view.eye)
            if length > 0.0 and facing > 0.05:
                own = part.outline()
                on_face = (own - part.position) @ normal > 0.5 * length * (1.0 - 1e-9)
                yield _placed(own[on_face], carrier, motion), 0.2 + 0.8 * facing


def _triangles(part: Solid, carrier: int, base: str, view: View, motion: PoseHistory) -> Iterator[Polygon]:
    """Yield the triangles of a mesh that face the viewer."""
    assert part.mesh is not None
    corners = _placed(part.outline(), carrier, motion)[part.mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = normals @ view.eye / np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    depths, outlines = corners.mean(axis=1) @ view.eye, projected(corners, view)
    for number in np.flatnonzero(facing > 0.0):
        colour = _mixed(to_rgb(base), (1.0, 1.0, 1.0), LIGHT * float(0.2 + 0.8 * facing[number]))
        yield Polygon(outlines[number], float(depths[number]), colour, edge=0.0)


def _placed(points: Array, carrier: int, motion: PoseHistory) -> Array:
    """The global positions of a carrier's points at the first sample."""
    origin = motion.point(carrier, np.zeros(3))[0]
    axes = np.stack([motion.vector(carrier, unit)[0] for unit in np.eye(3)])
    placed: Array = origin + points @ axes
    return placed


def _draw_span(
    axis: Axes, span: DrawnSpan, look: Look, view: View, motion: PoseHistory, opacity: float, order: float
) -> None:
    """Draw a rod as a bar, a spring as a wave, a damper as a thick line on a thin one."""
    start, end = span.ends(motion)
    if span.kind == "rod":
        outline = np.concatenate([part.outline() for part in bar(start, end, span.radius)])
        colour = _mixed(to_rgb(ROD), (1.0, 1.0, 1.0), 0.3 * LIGHT)
        axis.add_collection(
            PolyCollection([hull(projected(outline, view))], facecolors=[(*colour, opacity)], zorder=order)
        )
        return
    first, last = projected(np.stack([start, end]), view)
    if span.kind in ("spring", "strut"):
        x, y = _spring_line(first, last, span.radius).T
        axis.plot(x, y, color=SPRING, linewidth=0.9, alpha=opacity, zorder=order)
    if span.kind in ("damper", "strut"):
        axis.plot(*np.stack([first, last]).T, color=SPRING, linewidth=0.8, alpha=opacity, zorder=order)
        thick = first + np.outer([0.25, 0.6], last - first)
        axis.plot(*thick.T, color=SPRING, linewidth=3.0, alpha=opacity, zorder=order, solid_capstyle="butt")


def _spring_line(first: Array, last: Array, radius: float) -> Array:
    """The line (k, 2) of a spring between two points of the picture."""
    part = np.linspace(0.0, 1.0, TURNS * ROUND + 1)
    along = last - first
    across = np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), 1e-300)
    swing = radius * np.sin(2.0 * np.pi * TURNS * np.clip((part - 0.1) / 0.8, 0.0, 1.0))
    return first + part[:, None] * along + swing[:, None] * across


def _mixed(
    colour: tuple[float, float, float], other: tuple[float, float, float], part: float
) -> tuple[float, float, float]:
    """The colour with a part of another colour mixed in."""
    red, green, blue = ((1.0 - part) * own + part * its for own, its in zip(colour, other, strict=True))
    return red, green, blue
