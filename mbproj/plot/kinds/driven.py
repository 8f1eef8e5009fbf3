"""Forces and motions over time: what each acts along, and the force or torque along it."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

from matplotlib.figure import Figure

from mbproj.plot import panels, shown
from mbproj.plot.style import styled
from mbproj.results import Results

#: What acts along a coordinate in this unit, and its own unit.
ACTION = MappingProxyType({"m": "force (N)", "rad": "torque (N m)"})


@styled
def draw_forces(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row a force: the length or joint coordinate that it acts along, and its size."""
    return _rows(results, labels, "forces", "coordinate")


@styled
def draw_motions(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row a motion: the joint coordinate that it prescribes, and the driving force or torque."""
    return _rows(results, labels, "motions", "value")


def _rows(results: Sequence[Results], labels: Sequence[str], kind: str, coordinate: str) -> Figure:
    """A row a name of `kind` ("forces", "motions"): its dataset `coordinate`, and the force or torque beside it; a line
    a result."""
    names = shown.all_names(results, kind)
    drawn = names[: shown.MAX_ROWS]
    remark = "" if drawn == names else f"the first {len(drawn)} of {len(names)} {kind}: `mbproj export` writes all"
    figure, axes = panels.panels(len(drawn), 2)
    for (left, right), name in zip(axes, drawn, strict=True):
        for index, (result, label) in enumerate(zip(results, labels, strict=True)):
            if name in result.names(kind):
                column = result.names(kind).index(name)
                unit = result.names(f"{kind[:-1]}_units")[column]
                panels.plot(left, result.time, result[f"{kind}/{coordinate}"][:, column], label, index)
                panels.plot(right, result.time, result[f"{kind}/force"][:, column], label, index)
                left.set_ylabel(panels.literal(f"{name} ({unit})"))
                right.set_ylabel(ACTION[unit])
    return panels.finish(figure, remark=remark, with_legend=len(results) > 1)
