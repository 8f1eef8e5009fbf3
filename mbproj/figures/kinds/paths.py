"""The paths of the markers and of the places where curves are touched. They are drawn in the coordinate plane of the
motion, or in three views where the motion leaves every plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import fitting_names, panels, untrusted
from mbproj.figures.style import page_width, styled
from mbproj.figures.units import sizes
from mbproj.results import Results

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
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
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
        for line, (result, name) in zip(list(axis.lines), drawn, strict=True):
            since = untrusted.since(result, limit, name)
            if since is not None:
                pale, late = True, result.time >= since
                x, y = (np.asarray(values) for values in line.get_data())
                axis.plot(x[late], y[late], color=line.get_color(), alpha=PALE, linewidth=0.8)
                line.set_data(np.where(late, np.nan, x), np.where(late, np.nan, y))
    return f"pale: {untrusted.exceeds(limit)}" if pale else ""


def _names(results: Sequence[Results], of: Moving) -> tuple[list[str], str]:
    """The first names, as many as there are distinct lines, and a remark where these are not all."""
    names = fitting_names.all_names(results, of[0])
    drawn = names[: max(1, fitting_names.MAX_LINES // len(results))]
    what = "markers" if of is MARKERS else "places of contact"
    return drawn, fitting_names.note(what, len(drawn), len(names), of[2])


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
