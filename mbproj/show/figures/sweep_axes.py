"""The part of a sweep that is drawn: its measures, and its varied quantities, those asked for first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem, choose_from
from mbproj.figures.sweeps.scales import Scale, scale_of
from mbproj.results.sweep.table import GRID, Column, SweepCases

#: Marks of cases (N,).
Cases: TypeAlias = npt.NDArray[np.bool_]
#: The most measures on a page.
MOST = 6
SALTELLI = "saltelli"


@dataclass(frozen=True, eq=False)
class Chosen:
    """A table of a sweep, the measures to draw, and the quantities that have more than one value."""

    table: SweepCases
    measures: tuple[Column, ...]
    over: tuple[Column, ...]
    left_out: str

    @property
    def numbers(self) -> tuple[Column, ...]:
        """The varied quantities that are numbers."""
        return tuple(column for column in self.over if column.is_number)

    @property
    def independent(self) -> slice:
        """The cases that are independent samples: in Saltelli's design the first two blocks, otherwise all."""
        return slice(2 * self.table.samples if self.table.combine == SALTELLI else None)

    def remark(self, *more: str) -> str:
        """The small print: the given remarks, the measures left out, the title, and the number of cases."""
        table = self.table
        bad = int(np.count_nonzero(table.failed))
        cases = f"{table.combine}, {len(table.status)} cases" + (f", {bad} failed" if bad else "")
        return "; ".join(part for part in (*more, self.left_out, table.title, cases) if part)

    def scaled(self, column: Column) -> tuple[Scale, Array]:
        """The scale of a column of numbers, and its values on that scale."""
        scale = scale_of(column)
        return scale, scale.factor * column.values


def choose(table: SweepCases, of: Sequence[str], over: Sequence[str]) -> Chosen:
    """Choose the measures `of` and the quantities `over` to draw; all of them where none are named. Raises InputError
    for a name that the table does not have."""
    telling = [column for column in table.measured if column.varies] or table.measured
    measures = _columns_named(table.measured, of, "--of", "measure") or tuple(telling[:MOST])
    first = _columns_named(table.varied, over, "--over", "quantity that varies")
    for column in first:
        if not column.varies:
            raise InputError(Problem(f"--over {column.name}: it has one value in this sweep"))
    others = tuple(column for column in table.varied if column.varies and column not in first)
    left_out = "" if of else _left_out(table, measures)
    return Chosen(table, measures, first + others, left_out)


def _left_out(table: SweepCases, measures: Sequence[Column]) -> str:
    others = [column.name for column in table.measured if column not in measures]
    return f"not drawn: {', '.join(others)}; choose with --of" if others else ""


def _columns_named(columns: Sequence[Column], names: Sequence[str], option: str, what: str) -> tuple[Column, ...]:
    known = {column.name: column for column in columns}
    for name in names:
        if name not in known:
            raise InputError(Problem(f"{option}: the sweep has no {what} '{name}'", hint=choose_from(name, known)))
    return tuple(known[name] for name in dict.fromkeys(names))


def middle_of_others(chosen: Chosen, drawn: Sequence[Column]) -> tuple[Cases, str]:
    """Mark the cases (N,) of a grid in which all quantities but those `drawn` have their middle value, with a remark on
    these. In other designs mark all cases."""
    table = chosen.table
    kept = np.ones(len(table.status), dtype=bool)
    said = []
    for column in chosen.over if table.combine == GRID else ():
        if column not in drawn:
            values = list(dict.fromkeys(column.values.tolist()))
            middle = values[len(values) // 2]
            kept &= column.values == middle
            said.append(f"{column.name} = {scale_of(column).reads(middle)}")
    return kept, f"at {', '.join(said)}: choose others with --over" if said else ""
