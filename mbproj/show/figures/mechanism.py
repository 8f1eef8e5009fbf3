"""The mechanism itself: one pose with the paths of its markers, or several poses in one picture."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.results.output_files import MARK, film, replacing
from mbproj.results.record import Results
from mbproj.show.appearance.mechanism import DrawnSpan, Look, View, look_of, view_of
from mbproj.show.appearance.motion import PoseHistory, motion_of
from mbproj.show.appearance.parts import Solid, bar, hull
from mbproj.show.figures import fitted_text, panels
from mbproj.show.figures.fitted_text import literal
from mbproj.show.figures.style import line, page_width, sizes, styled

# --- A pose of a mechanism as polygons --------------------------------------------------------------------------------
# The outlines of its parts as seen by the viewer, the farthest first.


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
                outline = part.outline()
                on_face = (outline - part.position) @ normal > 0.5 * length * (1.0 - 1e-9)
                yield _placed(outline[on_face], carrier, motion), 0.2 + 0.8 * facing


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
    red, green, blue = ((1.0 - part) * first + part * second for first, second in zip(colour, other, strict=True))
    return red, green, blue


# --- The mechanism itself ---------------------------------------------------------------------------------------------


#: The opacity of the first and of the last but one of several poses; the last pose is opaque.
FAINT, FAINTEST_LAST = 0.18, 0.5
#: The opacity of a second run's pose.
GHOST = 0.3
#: The least and the largest height of a picture, in parts of its width.
HEIGHTS = (0.3, 1.1)
#: The most markers whose paths are drawn.
MOST_PATHS = 7
#: The most panels in a row, and the least and largest height of a panel in parts of its width.
MOST_COLUMNS, PANEL_HEIGHTS = 8, (0.4, 2.0)


@styled
def draw_mechanism(results: Sequence[Results], labels: Sequence[str], times: Sequence[float] = ()) -> Figure:
    """Draw the first result's poses at `times` (s; by default its start), earlier poses fainter. The other results'
    poses at the last time are drawn paler."""
    scene, motion = results[0].scene, motion_of(results[0])
    look = look_of(scene, motion, results[0].meshes())
    view = view_of(scene, motion, look)
    figure, axis = canvas(view)
    for other in results[1:]:
        its_scene, its_motion = other.scene, motion_of(other)
        row = nearest(its_motion, times[-1] if times else None)
        its_look = look_of(its_scene, its_motion, other.meshes())
        draw_pose(axis, its_look, view, its_motion.at([row]), opacity=GHOST, order=1.5)
    _draw_paths(axis, look, motion, view)
    rows = [nearest(motion, time) for time in sorted(times)] or [nearest(motion, None)]
    for number, row in enumerate(rows):
        last = number == len(rows) - 1
        faint = 1.0 if last else FAINT + (FAINTEST_LAST - FAINT) * number / (len(rows) - 1)
        draw_pose(axis, look, view, motion.at([row]), opacity=faint, order=2.0 + 0.1 * number)
    limits(axis, view)
    remark = "at t = " + ", ".join(f"{motion.time[row]:.6g}" for row in rows) + " s"
    return panels.finish(figure, remark=remark, with_legend=bool(look.markers or look.touching))


@styled
def draw_start(look: Look, view: View, motion: PoseHistory) -> Figure:
    """Draw the start of a scene that was not run."""
    figure, axis = canvas(view)
    draw_pose(axis, look, view, motion)
    limits(axis, view)
    return panels.finish(figure, with_legend=False)


@styled
def draw_side_by_side(look: Look, view: View, motion: PoseHistory) -> Figure:
    """Draw a panel for each sample of the motion, numbered from 1 on."""
    count = len(motion.time)
    columns = min(MOST_COLUMNS, int(np.ceil(np.sqrt(count))) if count > 4 else count)
    rows = -(-count // columns)
    width, height = np.ptp(projected(view.points, view), axis=0)
    shape = float(np.clip(height / width if width else 1.0, *PANEL_HEIGHTS))
    figure = Figure(figsize=(page_width(), page_width() / columns * shape * rows + 0.25 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for number, axis in enumerate(axes):
        axis.set_axis_off()
        if number >= count:
            continue
        axis.set_aspect("equal", adjustable="box")
        draw_pose(axis, look, view, motion.at([number]))
        limits(axis, view)
        axis.set_title(f"{number + 1}{' (the start)' if number == 0 else ''}", fontsize="small")
    return figure


def nearest(motion: PoseHistory, time: float | None) -> int:
    """The sample with a finite pose that is nearest to the time; the first where no time is given."""
    whole = motion.finite
    return int(whole[0] if time is None else whole[np.argmin(np.abs(motion.time[whole] - time))])


def canvas(view: View) -> tuple[Figure, Axes]:
    """A panel with equal scales, as high as the mechanism needs. Its axes have numbers where they are global axes."""
    width, height = np.ptp(projected(view.points, view), axis=0)
    low, high = HEIGHTS
    figure = Figure(
        figsize=(page_width(), page_width() * float(np.clip(height / width if width else 1.0, low, high))),
        layout="constrained",
    )
    axis = figure.subplots()
    axis.set_aspect("equal", adjustable="box")
    axis.grid(False)
    right, up = picture_axes(view)
    if max(right) > 1.0 - 1e-9 and max(up) > 1.0 - 1e-9:
        axis.set_xlabel(f"{'xyz'[int(np.argmax(right))]} (m)")
        axis.set_ylabel(f"{'xyz'[int(np.argmax(up))]} (m)")
    else:
        axis.set_axis_off()
        _triad(axis, view)
    return figure, axis


def limits(axis: Axes, view: View) -> None:
    """Set the limits to all that moves, with a margin."""
    points = projected(view.points, view)
    margin = 0.03 * float(np.ptp(points, axis=0).max())
    axis.set_xlim(points[:, 0].min() - margin, points[:, 0].max() + margin)
    axis.set_ylim(points[:, 1].min() - margin, points[:, 1].max() + margin)


def _triad(axis: Axes, view: View) -> None:
    """Draw the global axes in the corner, and a bar of a round length."""
    points = projected(view.points, view)
    size = float(np.ptp(points, axis=0).max())
    corner = points.min(axis=0) + 0.06 * size
    for unit, name in zip(np.eye(3), "xyz", strict=True):
        tip = corner + 0.07 * size * projected(unit, view)
        axis.annotate("", tip, corner, arrowprops={"arrowstyle": "-|>", "linewidth": 0.8, "color": "#444444"})
        x, y = corner + 0.095 * size * projected(unit, view)
        axis.text(x, y, name, ha="center", va="center", color="#444444")
    length = _round_below(0.2 * size)
    start = np.array([points[:, 0].max() - length, points[:, 1].min()])
    axis.plot([start[0], start[0] + length], [start[1], start[1]], color="#444444", linewidth=1.5)
    axis.text(
        start[0] + 0.5 * length, start[1] + 0.012 * size, f"{length:g} m", ha="center", va="bottom", color="#444444"
    )


def _round_below(length: float) -> float:
    """The largest number of the form 1, 2 or 5 times a power of ten that is not above `length`."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9)))


def _draw_paths(axis: Axes, look: Look, motion: PoseHistory, view: View) -> None:
    """Draw the paths of the first markers and of rolling contacts."""
    for each in look.touching:
        path = projected(each.path(motion), view)
        axis.plot(
            path[:, 0],
            path[:, 1],
            label=literal(f"contact of {each.name}"),
            color="#333333",
            linewidth=0.8,
            linestyle=":",
            zorder=1.7,
        )
    for number, marker in enumerate(look.markers[:MOST_PATHS]):
        path = projected(motion.point(marker.body, marker.point), view)
        look_of_line = line(number + 1) | {"linewidth": 0.8, "zorder": 1.8}
        axis.plot(path[:, 0], path[:, 1], label=literal(marker.name), **look_of_line)


# --- The paths of the markers and of the places where curves are touched ----------------------------------------------
# They are drawn in the coordinate plane of the motion, or in three views where the motion leaves every plane.


#: The mark at the start of a path.
DOT: dict[str, Any] = {"marker": "o", "markersize": 3}
#: The opacity of untrusted parts of a path.
PALE = 0.25
#: A motion is flat where its extent out of a plane is less than this part of its length. It is a line where its extent
#: in the plane is less than that part.
FLAT, LINE = 0.02, 1e-3
#: The views of a motion in space, with their places in a grid: from above, the front and the side.
VIEWS = (((0, 1), (0, 0)), ((0, 2), (1, 0)), ((1, 2), (1, 1)))


#: A kind of things that move along paths: their names in results, the dataset of their places, and a hint where some
#: are left out.
Moving = tuple[str, str, str]
MARKERS: Moving = ("markers", "markers/position", "choose others with --marker")
CONTACTS: Moving = ("touching", "curves/contact", "`mbproj export` writes all")


@styled
def draw_paths(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw one or three panels with equal scales: a line for each marker and result, with a dot at its start."""
    return _draw(results, labels, MARKERS)


@styled
def draw_contacts(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw the paths of the places where joints touch their curves, as `draw` draws those of markers."""
    return _draw(results, labels, CONTACTS)


def _draw(results: Sequence[Results], labels: Sequence[str], of: Moving) -> Figure:
    names, remark = _names(results, of)
    extent = _extent(results, names, of)
    flat = np.sort(extent)[0] <= FLAT * extent.max()
    figure, views = _plane(extent) if flat else _three_views(_paths(results, names, of))
    for axis, (first, second) in views:
        for number, (result, label) in enumerate(zip(results, labels, strict=True)):
            for place, name in enumerate(names):
                if name not in result.names(of[0]):
                    continue
                path, text = _path(result, name, of), name if len(results) == 1 else f"{name}, {label}"
                look = place + number * len(names)
                panels.plot(axis, path[:, first], path[:, second], text, look, markevery=[0], **DOT)
        axis.set_xlabel(f"{'xyz'[first]} (m)")
        axis.set_ylabel(f"{'xyz'[second]} (m)")
    return panels.finish(figure, remark=remark)


def nothing_to_see(results: Sequence[Results]) -> str | None:
    """The reason why the paths show nothing of interest; None where they do."""
    names, _ = _names(results, MARKERS)
    _, middle, largest = np.sort(_extent(results, names, MARKERS))
    if largest <= panels.ROUND_OFF * sizes(results)["m"]:
        return "no marker moves"
    return "the markers move along an axis, to and fro: see 'markers'" if middle <= LINE * largest else None


def mark_untrusted(figure: Figure, results: Sequence[Results], limit: float) -> str:
    """Draw the path of each marker in a pale colour from the time on at which its error may exceed the limit. Return a
    text on it."""
    names, _ = _names(results, MARKERS)
    drawn = [(result, name) for result in results for name in names if name in result.names("markers")]
    pale = False
    for axis in figure.axes:
        for drawn_line, (result, name) in zip(list(axis.lines), drawn, strict=True):
            since = panels.since(result, limit, name)
            if since is not None:
                pale, late = True, result.time >= since
                x, y = (np.asarray(values) for values in drawn_line.get_data())
                axis.plot(x[late], y[late], color=drawn_line.get_color(), alpha=PALE, linewidth=0.8)
                drawn_line.set_data(np.where(late, np.nan, x), np.where(late, np.nan, y))
    return f"pale: {panels.exceeds(limit)}" if pale else ""


def _names(results: Sequence[Results], of: Moving) -> tuple[list[str], str]:
    """The first names, as many as there are distinct lines, and a remark where these are not all."""
    names = fitted_text.all_names(results, of[0])
    drawn = names[: max(1, fitted_text.MAX_LINES // len(results))]
    what = "markers" if of is MARKERS else "places of contact"
    return drawn, fitted_text.note(what, len(drawn), len(names), of[2])


def _path(result: Results, name: str, of: Moving) -> Array:
    """The path (T, 3) with this name."""
    path: Array = result[of[1]][:, result.names(of[0]).index(name)]
    return path


def _paths(results: Sequence[Results], names: Sequence[str], of: Moving) -> list[Array]:
    """The named paths (T, 3) in all results, without samples that are not finite."""
    paths = [_path(result, name, of) for result in results for name in names if name in result.names(of[0])]
    return [path[np.all(np.isfinite(path), axis=1)] for path in paths]


def _extent(results: Sequence[Results], names: Sequence[str], of: Moving) -> Array:
    """The largest travel along x, y and z (3)."""
    travelled = [np.ptp(path, axis=0) for path in _paths(results, names, of) if len(path)]
    return np.max(travelled, axis=0, initial=0.0)


def _plane(extent: Array) -> tuple[Figure, list[tuple[Axes, tuple[int, int]]]]:
    """One panel with the two axes along which the markers travel most, in the order x, y, z."""
    figure = Figure(figsize=(page_width(), 0.8 * page_width()), layout="constrained")
    axis = figure.subplots()
    axis.set_aspect("equal", adjustable="datalim")
    first, second = sorted(np.argsort(-extent, kind="stable")[:2].tolist())
    return figure, [(axis, (first, second))]


def _three_views(paths: Sequence[Array]) -> tuple[Figure, list[tuple[Axes, tuple[int, int]]]]:
    """Three panels with equal scales. Panels that share an axis are beside or below each other."""
    figure = Figure(figsize=(page_width(), page_width()), layout="constrained")
    grid = figure.add_gridspec(2, 2)
    points = np.concatenate(paths)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.54 * float(np.max(high - low))
    views = []
    for (first, second), place in VIEWS:
        axis = figure.add_subplot(grid[place])
        axis.set_aspect("equal")
        axis.set_xlim(middle[first] - half, middle[first] + half)
        axis.set_ylim(middle[second] - half, middle[second] + half)
        views.append((axis, (first, second)))
    return figure, views


# --- The film of a mechanism ------------------------------------------------------------------------------------------
# Its picture (`mechanism`) at one time after another.


#: A picture (h, w, 3) of bytes, with even width and height.
Picture = npt.NDArray[np.uint8]
#: A function that writes pictures to a path, with a number of pictures a second.
Encoder = Callable[[Iterator[Picture], int, Path], None]


def gif(pictures: Iterator[Picture], rate: int, path: Path) -> None:
    """Write a GIF; each picture has its own colours, up to 256."""
    from PIL import Image

    first, *others = (Image.fromarray(picture).quantize(256, Image.Quantize.FASTOCTREE) for picture in pictures)
    options: dict[str, Any] = {"duration": 1000 // rate, "loop": 0, "comment": MARK.encode(), "optimize": False}
    first.save(path, format="GIF", save_all=True, append_images=others, **options)


def mp4(pictures: Iterator[Picture], rate: int, path: Path) -> None:
    """Write H.264, which browsers and slides play."""
    first = next(pictures)
    height, width, _ = first.shape
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(rate), "-i", "-"]
    film = ["-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p", "-metadata", f"comment={MARK}", "-f", "mp4"]
    command = [ffmpeg(), "-y", "-loglevel", "error", *source, *film, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None and process.stderr is not None
        try:
            process.stdin.write(first.tobytes())
            for picture in pictures:
                process.stdin.write(picture.tobytes())
            process.stdin.close()
        except BrokenPipeError:  # ffmpeg has ended; its message tells why
            pass
        said = process.stderr.read().decode("utf-8", "replace").strip()
    if process.returncode != 0:
        message = f"ffmpeg cannot make the film: {said.splitlines()[-1] if said else process.returncode}"
        raise InputError(Problem(message, hint="install one with libx264, or end the name in .gif"))


def ffmpeg() -> str:
    """The path of ffmpeg. Raises InputError where it is not installed."""
    program = shutil.which("ffmpeg")
    if program is None:
        message = "a film in MP4 needs ffmpeg, which is not here"
        raise InputError(Problem(message, hint="install it (apt install ffmpeg), or end the name in .gif"))
    return program


ENCODERS: Mapping[str, Encoder] = MappingProxyType({"gif": gif, "mp4": mp4})


#: Pictures a second, as a GIF can state exactly and browsers show; the shortest and the longest film, s.
RATE, SHORTEST, LONGEST = 20, 4.0, 15.0
DOTS_PER_INCH = 110


@styled
def save_film(results: Sequence[Results], path: Path, *, force: bool = False) -> Path:
    """Writes the film in the format that the ending names: the first result, with the others in paler colours.

    Raises InputError where ffmpeg is missing, or the file must not be replaced."""
    file_format = path.suffix[1:].lower()
    if file_format == "mp4":
        ffmpeg()  # raises before any work
    with replacing(path, film(file_format), force=force) as draft:
        ENCODERS[file_format](pictures(results), RATE, draft)
    return path


def duration_and_speed(span: float) -> tuple[float, float]:
    """The duration of a film of a motion of `span` seconds, and its speed relative to the motion."""
    if span <= 0.0:
        return 1.0 / RATE, 1.0
    seconds = float(np.clip(span, SHORTEST, LONGEST))
    return seconds, span / seconds


def times_of(time: Array) -> Array:
    """The times (s) of the pictures of a motion with samples at `time`."""
    seconds, _ = duration_and_speed(float(time[-1] - time[0]))
    return np.linspace(time[0], time[-1], round(RATE * seconds) + 1 if len(time) > 1 else 1)


def pictures(results: Sequence[Results]) -> Iterator[Picture]:
    """Yield all pictures of the film, in order."""
    scenes, motions = [each.scene for each in results], [motion_of(each) for each in results]
    looks = [look_of(*each) for each in zip(scenes, motions, [each.meshes() for each in results], strict=True)]
    view = view_of(scenes[0], motions[0], looks[0])
    stage = _Stage(looks[0], motions[0], view)
    for time in times_of(motions[0].time[motions[0].finite]):
        for number, (look, motion) in enumerate(zip(looks, motions, strict=True)):
            opacity, order = (GHOST, 1.5) if number else (1.0, 2.0)
            pose = motion.at([nearest(motion, time)])
            draw_pose(stage.axis, look, view, pose, opacity=opacity, order=order)
        yield stage.picture(float(time))


class _Stage:
    """The panel on which poses are drawn, with the paths of markers up to the current time."""

    def __init__(self, look: Look, motion: PoseHistory, view: View) -> None:
        figure, self.axis = canvas(view)
        figure.set_dpi(DOTS_PER_INCH)
        limits(self.axis, view)
        markers = look.markers[:MOST_PATHS]
        self._times = motion.time
        self._paths = [projected(motion.point(each.body, each.point), view) for each in markers]
        looks = [line(number + 1) | {"linewidth": 0.8, "zorder": 1.8} for number in range(len(markers))]
        self._trails = [self.axis.plot([], [], **each)[0] for each in looks]
        times = times_of(motion.time[motion.finite])
        _, self._speed = duration_and_speed(float(times[-1] - times[0]))
        self._title = self.axis.set_title(" ", fontsize="small", loc="left")
        self._canvas = FigureCanvasAgg(figure)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        figure.set_layout_engine("none")  # the layout is fixed from here on
        self._kept = set(self.axis.get_children())

    def picture(self, time: float) -> Picture:
        """Draw the panel at this time and return the picture; then remove the poses."""
        speed = "" if abs(self._speed - 1.0) < 1e-9 else f", {self._speed:.2g} times as fast"
        self._title.set_text(f"t = {time:.3f} s{speed}")
        so_far = self._times <= time + 1e-9 * max(abs(time), 1.0)
        for trail, path in zip(self._trails, self._paths, strict=True):
            trail.set_data(*path[so_far].T)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        drawn = np.array(memoryview(self._canvas.buffer_rgba()))[..., :3]  # type: ignore[no-untyped-call]
        for artist in set(self.axis.get_children()) - self._kept:
            artist.remove()
        return _even(drawn)


def _even(picture: Picture) -> Picture:
    """The picture without a last row or column that would make an odd number."""
    height, width, _ = picture.shape
    return np.ascontiguousarray(picture[: height - height % 2, : width - width % 2])
