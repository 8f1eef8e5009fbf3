"""The mechanism itself: one pose with the paths of its markers, or several poses in one picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.figures import panels
from mbproj.figures.fitted_text import literal
from mbproj.figures.kinds.poses import draw_pose, picture_axes, projected
from mbproj.figures.style import line, page_width, styled
from mbproj.pages.appearance.mechanism import Look, look_of
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.appearance.recorded import motion_of
from mbproj.pages.appearance.view import View, view_of
from mbproj.results import Results

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
def draw(results: Sequence[Results], labels: Sequence[str], times: Sequence[float] = ()) -> Figure:
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
    _paths(axis, look, motion, view)
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


def _paths(axis: Axes, look: Look, motion: PoseHistory, view: View) -> None:
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
