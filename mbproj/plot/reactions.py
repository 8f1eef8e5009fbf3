"""Reaction forces and torques of the joints over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.plot import panels, shown
from mbproj.plot.style import styled
from mbproj.results import Results

ROWS = (("reaction_force", "N"), ("reaction_torque", "N m"))
#: Torques are noise where they are less than a millionth of the forces at this arm, in m.
FORCE_ARM = 1e-3


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row for forces, a row for torques, a column a result. One joint: its components; several: magnitudes."""
    names, remark = shown.largest_joints(results, "joints/reaction_force")
    figure, axes = panels.panels(2, len(results), height=2.1, share="row")
    for column, (result, label) in enumerate(zip(results, labels, strict=True)):
        for row, (member, _) in enumerate(ROWS):
            for index, (text, values) in enumerate(_lines(result, names, member)):
                panels.plot(axes[row, column], result.time, values, text, index)
        if len(results) > 1:
            axes[0, column].set_title(panels.literal(label))
    forces = max(panels.span(axis)[1] for axis in axes[0])
    panels.hold_still(list(axes[1]), least=max(panels.LEAST, FORCE_ARM * forces))
    for row, (member, unit) in enumerate(ROWS):
        reaction = member.replace("_", " ")
        what = f"{reaction} of {names[0]}" if len(names) == 1 else f"|{reaction}|"
        axes[row, 0].set_ylabel(panels.literal(f"{what} ({unit})"))
    return panels.finish(figure, remark=remark)


def _lines(result: Results, names: Sequence[str], member: str) -> list[tuple[str, Array]]:
    present = [name for name in names if name in result.names("joints")]
    values: dict[str, Array] = {name: getattr(result.joint(name), member) for name in present}
    if len(names) > 1:
        return [(name, np.linalg.norm(value, axis=1)) for name, value in values.items()]
    return [(component, value[:, index]) for value in values.values() for index, component in enumerate("xyz")]
