"""The violation of the constraints over time: the largest, position and velocity, and that of each joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from mbproj.figures import fitting_names, panels
from mbproj.figures.rows import MAX_ROWS
from mbproj.figures.style import styled
from mbproj.results import Results

ROWS = (
    ("diagnostics/position_violation", r"$|C|_\infty$ (m or rad)"),
    ("diagnostics/velocity_violation", r"$|\dot{C}|_\infty$ (m/s or rad/s)"),
)
#: The attribute of a joint, its unit, and its name in the small print where no joint violates it.
VIOLATIONS = (("violation_length", "m", "lengths"), ("violation_angle", "rad", "angles"))


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw two panels with logarithmic axes and a line for each result."""
    figure, axes = panels.panels(2, height=2.1)
    for axis, (path, name) in zip(axes[:, 0], ROWS, strict=True):
        for index, (result, label) in enumerate(zip(results, labels, strict=True)):
            panels.plot_log(axis, result.abscissa, result[path], label, index)
        axis.set_ylabel(name)
    return panels.finish(figure, with_legend=len(results) > 1)


@styled
def draw_joints(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw violations on logarithmic axes. One result has a row of lengths and one of angles, with a line for each
    joint. Several have a row for each joint. The small print names violations that are always zero."""
    single = len(results) == 1
    names, remark = fitting_names.largest_joints(
        results, "joints/violation", fitting_names.MAX_LINES if single else MAX_ROWS
    )
    drawn = [entry for entry in VIOLATIONS if _is_seen(results, names, entry[0])] or [VIOLATIONS[0]]
    zero = [f"{what}: no violation above 10⁻¹⁷" for entry in VIOLATIONS if entry not in drawn for what in entry[2:]]
    grid = (len(drawn), 1) if single else (len(names), len(drawn))
    figure, axes = panels.panels(*grid, height=2.1 if single else 1.75, share=not single and "col")
    for place, (member, unit, _) in enumerate(drawn):
        for row, name in enumerate(names):
            axis = axes[place, 0] if single else axes[row, place]
            for index, (result, label) in enumerate(zip(results, labels, strict=True)):
                if name in result.names("joints"):
                    text, look = (name, row) if single else (label, index)
                    panels.plot_log(axis, result.abscissa, getattr(result.joint(name), member), text, look)
            panels.name(axis, "violation" if single else f"{name}: violation", unit)
    return panels.finish(figure, remark="; ".join(filter(None, [remark, *zero])))


def _is_seen(results: Sequence[Results], names: Sequence[str], member: str) -> bool:
    """Whether the violation of any joint is ever above the floor."""
    for result in results:
        for name in names:
            if name in result.names("joints"):
                values = getattr(result.joint(name), member)
                if np.any(np.abs(values) > panels.FLOOR):
                    return True
    return False
