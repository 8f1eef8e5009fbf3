"""The data of a design's figures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array
from mbproj.results.design_file import Drawn, Matched
from mbproj.scene.ranges.family import column_of, with_unit
from mbproj.studies.design.run import FoundDesign
from mbproj.studies.design.spec import Goal
from mbproj.studies.design.target import PATH, TIME


def data_to_draw(design: FoundDesign) -> Drawn:
    """The data to draw: for matches the run beside the data, for several goals their front; and the traces of the
    searches."""
    names = tuple(column_of(path) for path in design.spec.paths)
    if design.searches[0].goals.size:
        front = np.stack([signs(design) * each.goals for each in design.searches])
        goals = tuple(_axis_label(goal) for goal in design.spec.goals)
        return Drawn(f"{design.engine}, {design.runs} runs", goals[0], names, goals=goals, front=front)
    return Drawn(
        remark=f"{design.engine}, {len(design.searches)} starts, {design.runs} runs",
        value="rms of the residuals" if design.spec.targets else _axis_label(design.spec.goals[0]),
        names=names,
        matches=tuple(_matched(design)),
        traces=tuple(_trace(design, each.trace) for each in design.searches),
        correlation=None if design.knowledge is None else design.knowledge.correlation,
    )


def signs(design: FoundDesign) -> Array:
    """The signs, (g,), by which goals to be minimised become measured values."""
    return np.array([goal.sign for goal in design.spec.goals])


def _axis_label(goal: Goal) -> str:
    """The label of an axis."""
    return with_unit(goal.measure.name, goal.measure.unit)


def _trace(design: FoundDesign, trace: Array) -> Array:
    """The numbers of runs and the values to draw, (n, 2): the rms of residuals, or the measured goal."""
    runs, values = trace[:, 0], trace[:, 1]
    if design.spec.targets:
        return np.stack([runs, np.sqrt(2.0 * values / len(design.trial.residuals))], axis=1)
    return np.stack([runs, design.spec.goals[0].sign * values], axis=1)


def _matched(design: FoundDesign) -> Iterator[Matched]:
    for target, off in design.deviations:
        yield Matched(
            name=target.name,
            abscissa=None if target.over == PATH else target.abscissa,
            along="time (s)" if target.over == TIME else target.over,
            unit=target.unit,
            components=tuple(each.component for each in target.measures),
            given=target.values,
            reached=target.values + off,
        )
