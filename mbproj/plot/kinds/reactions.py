"""Reaction forces and torques of the joints over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.analysis.reactions import in_words, reactions_not_unique
from mbproj.arrays import Array
from mbproj.plot import panels, shown
from mbproj.plot.style import styled
from mbproj.results import Results

ROWS = (("reaction_force", "N"), ("reaction_torque", "N m"))
#: Torques are noise where they are less than a millionth of the forces at this arm, in m.
FORCE_ARM = 1e-3
#: How what redundant joints share at will looks, and what the legend says of it.
OPEN: Mapping[str, Any] = {"color": "#A0A0A0", "linewidth": 0.8}
NOT_UNIQUE = "not unique"


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row for forces, a row for torques, a column a result. One joint: its components; several: magnitudes.

    Components that are not unique are grey, and magnitudes are of the others, or grey where there are none.
    """
    names, remark = shown.largest_joints(results, "joints/reaction_force")
    figure, axes = panels.panels(2, len(results), height=2.1, share="row")
    for column, (result, label) in enumerate(zip(results, labels, strict=True)):
        for row, (member, _) in enumerate(ROWS):
            _plot(axes[row, column], result.time, _lines(result, names, member))
        if len(results) > 1:
            axes[0, column].set_title(panels.literal(label))
    forces = max(panels.span(axis)[1] for axis in axes[0])
    panels.hold_still(list(axes[1]), least=max(panels.LEAST, FORCE_ARM * forces))
    for row, (member, unit) in enumerate(ROWS):
        reaction = member.replace("_", " ")
        what = f"{reaction} of {names[0]}" if len(names) == 1 else f"|{reaction}|"
        axes[row, 0].set_ylabel(panels.literal(f"{what} ({unit})"))
    return panels.finish(figure, remark="; ".join(part for part in (remark, *_left_out(results, names)) if part))


def _plot(axis: Axes, time: Array, lines: Sequence[tuple[str, Array, bool]]) -> None:
    """The lines; those that are not unique keep their dashes and lose their colour, which the legend shows all the
    same."""
    for index, (text, values, is_unique) in enumerate(lines):
        part = slice(None) if is_unique else slice(0)
        panels.plot(axis, time[part], values[part], text, index)
    for index, (_, values, is_unique) in enumerate(lines):
        if not is_unique:
            panels.plot(axis, time, values, NOT_UNIQUE, index, **OPEN)


def _lines(result: Results, names: Sequence[str], member: str) -> list[tuple[str, Array, bool]]:
    """What each line is called, its values, and whether they are unique."""
    marks, found = result.constant(f"joints/{member}_unique"), []
    for place, name in enumerate(result.names("joints")):
        if name not in names:
            continue
        value: Array = getattr(result.joint(name), member)
        unique = np.ones(3, dtype=bool) if marks is None else marks[place]
        if len(names) == 1:
            found += [(component, value[:, axis], bool(unique[axis])) for axis, component in enumerate("xyz")]
        else:
            parts = value[:, unique] if unique.any() else value
            found.append((name, np.linalg.norm(parts, axis=1), bool(unique.any())))
    return sorted(found, key=lambda line: names.index(line[0])) if len(names) > 1 else found


def _left_out(results: Sequence[Results], names: Sequence[str]) -> Iterator[str]:
    """What magnitudes leave out."""
    if len(names) == 1:
        return
    words: dict[str, str] = {}
    for result in results:
        words |= {joint: open_ for joint, open_ in (reactions_not_unique(result) or {}).items() if joint in names}
    if words:
        yield f"not unique, and left out of magnitudes (grey where nothing else is left): {in_words(words)}"
