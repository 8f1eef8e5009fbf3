"""Forces, motions and stops over time: what each acts along, and the force or torque along it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.plot import rows, shown
from mbproj.plot.differences import SIGN
from mbproj.plot.rows import Group, Quantity, Row
from mbproj.plot.same import alike
from mbproj.plot.style import styled
from mbproj.plot.units import Unit, units_of
from mbproj.results import Results

#: What acts along a coordinate in this unit, and its own unit.
ACTION = {"m": ("force", Unit("N", "N")), "rad": ("torque", Unit("N m", "N m"))}


@dataclass(frozen=True)
class Columns:
    """Reads the columns `names` (T, k) of a dataset; None where a result lacks one of them."""

    kind: str
    names: tuple[str, ...]
    dataset: str

    def __call__(self, result: Results) -> Array | None:
        present = result.names(self.kind)
        if not set(self.names) <= set(present):
            return None
        columns = [present.index(name) for name in self.names]
        values: Array = result[f"{self.kind}/{self.dataset}"][:, columns]
        return values


@styled
def draw_forces(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row for what forces act along, the length or joint coordinate and the forces along it side by side."""
    return _draw(results, labels, "forces", "coordinate")


@styled
def draw_motions(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row a motion: the joint coordinate that it prescribes, and the driving force or torque."""
    return _draw(results, labels, "motions", "value")


@styled
def draw_stops(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row a stop: how far the mechanism is from it, and how hard it pushes."""
    return _draw(results, labels, "stops", "gap")


def _draw(results: Sequence[Results], labels: Sequence[str], kind: str, dataset: str) -> Figure:
    names = shown.all_names(results, kind)
    together = _together(results, kind, dataset, names)
    groups = rows.fitting([_group(results, kind, dataset, own, names) for own in together], results)
    count = sum(map(len, together[: len(groups)]))
    return rows.draw(results, labels, groups, shown.cut(kind, count, len(names), "`mbproj export` writes all"))


def _together(results: Sequence[Results], kind: str, dataset: str, names: Sequence[str]) -> list[tuple[str, ...]]:
    """The names that act along the same in each of the results."""
    found: list[tuple[str, ...]] = []
    for name in names:
        for place, own in enumerate(found):
            if _unit(results, kind, own[0]) != _unit(results, kind, name):
                continue
            pairs = [[Columns(kind, (one,), dataset)(result) for one in (own[0], name)] for result in results]
            if all(a is not None and b is not None and np.array_equal(a, b) for a, b in pairs):
                found[place] = (*own, name)
                break
        else:
            found.append((name,))
    return found


def _unit(results: Sequence[Results], kind: str, name: str) -> str:
    """The unit, m or rad, of what this one acts along, in the first result that has it."""
    first = next(result for result in results if name in result.names(kind))
    return first.names(f"{kind[:-1]}_units")[first.names(kind).index(name)]


def _group(results: Sequence[Results], kind: str, dataset: str, own: tuple[str, ...], names: Sequence[str]) -> Group:
    """Of one result a row with a line a name; of several a row a name, what they act along once."""
    first = next(result for result in results if own[0] in result.names(kind))
    si = _unit(results, kind, own[0])
    read, act = Columns(kind, own[:1], dataset), Columns(kind, own, "force")
    unit = units_of(si, [values for result in results if (values := read(result)) is not None]).value
    words, acts_in = ACTION[si]
    label = f"{own[0]}: gap" if kind == "stops" else _along(first, own, si, read)
    along = Quantity(label, unit, read)
    if len(own) == 1:
        listed: list[Row] = [(along, Quantity(words, acts_in, act))]
    elif len(results) == 1:
        listed = [(along, Quantity(words, acts_in, act, tuple((name, names.index(name)) for name in own)))]
    else:
        each = [Quantity(f"{words} of {name}", acts_in, Columns(kind, (name,), "force")) for name in own]
        listed = [(along, each[0]), *((None, other) for other in each[1:])]
    return Group(tuple(listed), (Quantity(SIGN, unit, read), Quantity(SIGN, acts_in, act)))


def _along(result: Results, own: tuple[str, ...], si: str, read: Columns) -> str:
    """What they act along: the joint coordinate of these values, or a length; with the name where it is one."""
    values, of = read(result), ""
    for coordinate, unit in zip(result.names("coordinates"), result.names("coordinate_units"), strict=True):
        if unit == si and values is not None and alike(result.coordinate(coordinate).value, values[:, 0]):
            of = coordinate
            break
    if len(own) == 1:
        return f"{own[0]}: {of}" if of else own[0]
    return of or (f"length of {own[0]}" if si == "m" else own[0])
