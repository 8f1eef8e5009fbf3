"""What others computed as the `expect` block of a scene: at half of the time and at the end, with its tolerances."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array

from .case import Case
from .compare import reference
from .quantities import COORDINATES, Column
from .readable import number, vector

#: What of a table is expected: the others are in other axes or at other points than what mbproj records.
RECORDED = {"position", "orientation", "velocity", "acceleration", "angular_velocity", "force_on_first", *COORDINATES}
#: Besides: the joints are closed, and the energy balance holds, to these bounds.
CLOSED, DRIFT = 2e-13, 1e-8
#: The sources' own about zero.
ROUND_OFF = 1e-12
WIDTH = 120


def expect_lines(case: Case) -> Iterator[str]:
    """The lines of the block."""
    table = reference(case)
    times = table["t"]
    rows = sorted({int(np.argmin(np.abs(times - times[-1] / 2))), len(times) - 1})
    yield "expect:                                  # the reference's numbers, as far as they are right"
    for row in rows:
        for column in _expected(table):
            values = [float(table[name][row]) for name in column.columns]
            yield from _entry(
                case,
                column,
                "at_the_end" if row == rows[-1] else "halfway",
                _time(case, times[row]),
                values,
                _tolerance(case, table, column),
            )
    yield f"  closed: {{diagnostic: position_violation, at: maximum, below: {CLOSED:g}, source: joints are closed}}"
    yield f"  energy: {{diagnostic: energy_drift_relative, at: maximum, below: {DRIFT:g}, source: balance of energy}}"


class _Expected(NamedTuple):
    """Columns of a table that are one quantity of mbproj, or one component of it."""

    owner: str
    quantity: str
    component: str
    columns: list[str]


def _expected(table: Mapping[str, Array]) -> Iterator[_Expected]:
    """What of the table is expected, whole vectors where the table has them."""
    names = [name for name in table if name != "t" and Column.of(name).quantity in RECORDED]
    for owner, quantity in dict.fromkeys(Column.of(name)[:2] for name in names):
        columns = sorted(name for name in names if Column.of(name)[:2] == (owner, quantity))
        if len(columns) in (1, 2) and Column.of(columns[0]).component:
            for column in columns:
                yield _Expected(owner, quantity, Column.of(column).component, [column])
        else:
            yield _Expected(owner, quantity, "", columns)


def _entry(
    case: Case, what: _Expected, when: str, time: str, values: Sequence[float], tolerance: float
) -> Iterator[str]:
    """One expectation, on as many lines as it takes."""
    of, quantity, sign = "marker" if what.owner in case.markers else "body", what.quantity, 1.0
    if quantity in COORDINATES:
        of, quantity = "joint", f"{quantity.replace('speed', 'angle')}_speed" if "speed" in quantity else quantity
    elif quantity == "force_on_first":
        of, quantity, sign = "joint", "reaction_force", -1.0
    part = f", component: {what.component}" if what.component else ""
    shown = [sign * value if abs(value) > ROUND_OFF else 0.0 for value in values]
    suffix = f"_{what.component}" if what.component else ""
    name = f"  {what.owner}_{quantity}{suffix}_{when}:"
    first = f"{{{of}: {what.owner}, quantity: {quantity}{part}, at: {time}, absolute: {tolerance:g},"
    value = f"value: {number(shown[0]) if len(shown) == 1 else vector(shown)},"
    source = f"source: {re.split('[,:;]', case.origin)[0]} (tests/data/validation/{case.name}.csv)}}"
    yield f"{name} {first}"
    if len(f"    {value} {source}") <= WIDTH:
        yield f"    {value} {source}"
    else:
        yield f"    {value}"
        yield f"    {source}"


def _tolerance(case: Case, table: Mapping[str, Array], what: _Expected) -> float:
    """The case's own absolute tolerance, or a part of the largest magnitude of the vector, of two digits."""
    largest = max(float(np.abs(table[column]).max()) for column in what.columns)
    tolerance = case.tolerances.get(what.quantity)
    return float(f"{case.relative[what.quantity] * largest if tolerance is None else tolerance:.2g}")


def _time(case: Case, time: float) -> str:
    """The time in s, as a multiple of the samples' interval where its digits are cut."""
    interval = case.simulation["output_step"]
    return f"{round(time / case.grid)} * {interval}" if "/" in interval else f"{time:g} s"
