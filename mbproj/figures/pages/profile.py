"""A curve for the workshop: its profile beside its radius, pressure angle and curvature."""

from __future__ import annotations

from math import degrees, inf

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mbproj.figures import panels
from mbproj.figures.style import AXIS_HEIGHT, line, page_width, styled
from mbproj.figures.units import tick_degrees
from mbproj.scene.blocks.curves.sheet import Sheet

#: The relative widths of the profile and of the panels beside it.
WIDTHS = (1.15, 1.0)
HEIGHT = 1.35
#: The pressure angle in degrees above which a sliding follower may jam (Norton 2009, Cam Design, ch. 7).
JAMS = 30.0
OUTLINE, GUIDE, LIMIT = 0, 1, 2


@styled
def draw_profile(sheet: Sheet) -> Figure:
    """Draw the profile with equal scales on the left, and its numbers along it on the right."""
    words = ["radius", *(["pressure angle"] if sheet.closed else []), "curvature"]
    figure = Figure(figsize=(page_width(), max(3, len(words)) * HEIGHT + AXIS_HEIGHT), layout="constrained")
    grid = figure.add_gridspec(len(words), 2, width_ratios=WIDTHS, height_ratios=[HEIGHT] * len(words))
    _outline(figure.add_subplot(grid[:, 0]), sheet)
    turns = sheet.closed and abs(abs(sheet.angle[-1] - sheet.angle[0]) - 2.0 * np.pi) < 1e-6
    at = np.degrees(sheet.angle) if turns else 1e3 * sheet.arc
    values = {
        "radius": (1e3 * sheet.radius, "mm"),
        "pressure angle": (np.degrees(sheet.pressure), "degrees"),
        "curvature": (1e-3 * sheet.curvature, "1/mm"),
    }
    axes: list[Axes] = []
    for row, word in enumerate(words):
        axis = figure.add_subplot(grid[row, 1], sharex=axes[0] if axes else None)
        shown, unit = values[word]
        panels.plot(axis, at, shown, "", OUTLINE)
        panels.name(axis, word, unit)
        axis.tick_params(labelbottom=row + 1 == len(words))
        axes.append(axis)
    if sheet.closed and np.degrees(sheet.pressure).max() > 0.5 * JAMS:
        axes[1].axhline(JAMS, label="usual limit of the pressure angle", **line(LIMIT))
    panels.hold_still(axes[:1], 1e3 * float(sheet.radius.max()))
    axes[-1].set_xlabel("angle about the origin (degrees)" if turns else "arc length (mm)")
    if turns:
        tick_degrees(axes[-1], along_x=True)
    return panels.finish(
        figure, remark=remark(sheet), with_legend=any(axis.get_legend_handles_labels()[0] for axis in figure.axes)
    )


def _outline(axis: Axes, sheet: Sheet) -> None:
    """Draw the profile, the path of the roller's centre, and the roller at its first place."""
    panels.plot(axis, 1e3 * sheet.x, 1e3 * sheet.y, "profile" if sheet.roller else "", OUTLINE)
    if sheet.roller:
        panels.plot(axis, 1e3 * sheet.line_x, 1e3 * sheet.line_y, "centre of the roller", GUIDE)
        place = (1e3 * sheet.line_x[0], 1e3 * sheet.line_y[0])
        axis.add_patch(Circle(place, 1e3 * sheet.roller, fill=False, edgecolor="#808080", linewidth=0.8))
    axis.plot([0.0], [0.0], "+", color="#404040")
    axis.set_aspect("equal", adjustable="box")
    axis.margins(0.08)
    axis.set(xlabel="x (mm)", ylabel="y (mm)")


def remark(sheet: Sheet) -> str:
    """The small print: the name of the curve, the largest pressure angle, and the largest rollers."""
    said = [f"curve '{sheet.name}'"]
    if sheet.closed:
        worst = float(np.max(sheet.pressure))
        said.append(f"largest pressure angle {degrees(worst):.1f} degrees")
    return "; ".join([*said, *rollers_said(sheet)])


def rollers_said(sheet: Sheet) -> list[str]:
    """The largest roller on each side, in words."""
    return [
        f"any roller fits {side}" if radius == inf else f"largest roller {side}: {1e3 * radius:.4g} mm"
        for side, radius in sheet.rollers.items()
    ]
