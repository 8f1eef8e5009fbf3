"""What pictures show of a design."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array
from mbproj.results.design.drawn import Drawn, Matched
from mbproj.scene.ranges.family import column_of, with_unit
from mbproj.studies.design.run import FoundDesign
from mbproj.studies.design.spec import Goal
from mbproj.studies.design.target import PATH, TIME


def drawn(found: FoundDesign) -> Drawn:
    """Of a match how the run meets it, of several goals their front, and how the searches went down."""
    names = tuple(column_of(path) for path in found.spec.paths)
    if found.searches[0].goals.size:
        front = np.stack([signs(found) * each.goals for each in found.searches])
        goals = tuple(_named(goal) for goal in found.spec.goals)
        return Drawn(f"{found.engine}, {found.runs} runs", goals[0], names, goals=goals, front=front)
    return Drawn(
        remark=f"{found.engine}, {len(found.searches)} starts, {found.runs} runs",
        value="rms of the residuals" if found.spec.targets else _named(found.spec.goals[0]),
        names=names,
        matches=tuple(_matched(found)),
        traces=tuple(_trace(found, each.trace) for each in found.searches),
        correlation=None if found.knowledge is None else found.knowledge.correlation,
    )


def signs(found: FoundDesign) -> Array:
    """By which goals that are to be small become what is measured, (g,)."""
    return np.array([goal.sign for goal in found.spec.goals])


def _named(goal: Goal) -> str:
    """Below an axis."""
    return with_unit(goal.measure.name, goal.measure.unit)


def _trace(found: FoundDesign, trace: Array) -> Array:
    """The runs and what is drawn of the value: the rms of residuals, or the goal as it is measured."""
    runs, values = trace[:, 0], trace[:, 1]
    if found.spec.targets:
        return np.stack([runs, np.sqrt(2.0 * values / len(found.trial.residuals))], axis=1)
    return np.stack([runs, found.spec.goals[0].sign * values], axis=1)


def _matched(found: FoundDesign) -> Iterator[Matched]:
    for target, off in found.off:
        yield Matched(
            name=target.name,
            abscissa=None if target.over == PATH else target.abscissa,
            along="time (s)" if target.over == TIME else target.over,
            unit=target.unit,
            components=tuple(each.component for each in target.measures),
            given=target.values,
            reached=target.values + off,
        )
