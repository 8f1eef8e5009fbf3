"""Forces, motions, stops, dry frictions and ropes over time: the coordinate of each, its force, torque or tensions, and
the energy lost by friction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from mbproj.analysis.contacts.friction import sticking
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import fitting_names, rows
from mbproj.figures.differences import SIGN, alike
from mbproj.figures.margins import small_print
from mbproj.figures.rows import PanelGroup, PanelQuantity, Row
from mbproj.figures.style import styled
from mbproj.figures.units import AxisUnit, units_of
from mbproj.results import Results
from mbproj.results.layout import ALL_NAMES
from mbproj.results.members import Friction

#: The kind of action along a coordinate with this unit, and the unit of the action.
ACTION = {"m": ("force", AxisUnit("N", "N")), "rad": ("torque", AxisUnit("N m", "N m"))}
ENERGY, POWER = AxisUnit("J", "J"), AxisUnit("W", "W")
#: The colour behind the curves while a friction sticks, and its opacity with one result.
STICKS, OPAQUE = "#56B4E9", 0.22
TENSION = AxisUnit("N", "N")


@dataclass(frozen=True)
class DatasetColumns:
    """A reader of the columns `names` (T, k) of a dataset; None where a result lacks one of them."""

    kind: str
    names: tuple[str, ...]
    dataset: str

    def __call__(self, result: Results) -> Array | None:
        present = result.names(self.kind)
        if not set(self.names) <= set(present):
            return None
        columns = [present.index(name) for name in self.names]
        values: Array = result[f"{ALL_NAMES[self.kind].group}/{self.dataset}"][:, columns]
        return values


@dataclass(frozen=True)
class FrictionReader:
    """A reader of a quantity (T) of the friction `name`; None where a result lacks the friction."""

    name: str
    quantity: Callable[[Friction], Array]

    def __call__(self, result: Results) -> Array | None:
        return self.quantity(result.friction(self.name)) if self.name in result.names("frictions") else None


@styled
def draw_forces(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each coordinate or length along which forces act, beside these forces."""
    return _draw(results, labels, "forces", "coordinate")


@styled
def draw_motions(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each motion: the joint coordinate that it prescribes, and the driving force or torque."""
    return _draw(results, labels, "motions", "value")


@styled
def draw_stops(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each stop: its gap and its force."""
    return _draw(results, labels, "stops", "gap")


@styled
def draw_friction(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw two rows for each friction: rate and force or torque, then lost energy and lost power."""
    names = fitting_names.all_names(results, "frictions")
    groups = rows.fitting([group for name in names for group in _of_friction(results, name)], results)
    drawn = len({group.name for group in groups})
    remark = fitting_names.note("dry frictions", drawn, len(names), "`mbproj export` writes all")
    figure = rows.draw(results, labels, groups, remark)
    if _shade(figure, results):
        small_print(figure, "shaded: it sticks" + (", the darker in the more results" if len(results) > 1 else ""))
    return figure


def _draw(results: Sequence[Results], labels: Sequence[str], kind: str, dataset: str) -> Figure:
    names = fitting_names.all_names(results, kind)
    together = _grouped_by_coordinate(results, kind, dataset, names)
    groups = rows.fitting([_group(results, kind, dataset, own, names) for own in together], results)
    count = sum(map(len, together[: len(groups)]))
    return rows.draw(results, labels, groups, fitting_names.note(kind, count, len(names), "`mbproj export` writes all"))


def _grouped_by_coordinate(
    results: Sequence[Results], kind: str, dataset: str, names: Sequence[str]
) -> list[tuple[str, ...]]:
    """Group the names that act along the same coordinate in all results."""
    groups: list[tuple[str, ...]] = []
    for name in names:
        for place, own in enumerate(groups):
            if _unit(results, kind, own[0]) != _unit(results, kind, name):
                continue
            pairs = [[DatasetColumns(kind, (one,), dataset)(result) for one in (own[0], name)] for result in results]
            if all(a is not None and b is not None and np.array_equal(a, b) for a, b in pairs):
                groups[place] = (*own, name)
                break
        else:
            groups.append((name,))
    return groups


def _unit(results: Sequence[Results], kind: str, name: str) -> str:
    """The unit (m or rad) of the coordinate of `name`, in the first result that has it."""
    first = next(result for result in results if name in result.names(kind))
    return first.names(f"{kind[:-1]}_units")[first.names(kind).index(name)]


def _group(
    results: Sequence[Results], kind: str, dataset: str, own: tuple[str, ...], names: Sequence[str]
) -> PanelGroup:
    """The rows of forces along one coordinate. With one result it is a row with a line for each name. With several it
    is a row for each name, and the coordinate once."""
    first = next(result for result in results if own[0] in result.names(kind))
    si = _unit(results, kind, own[0])
    read, act = DatasetColumns(kind, own[:1], dataset), DatasetColumns(kind, own, "force")
    unit = units_of(si, [values for result in results if (values := read(result)) is not None]).value
    words, acts_in = ACTION[si]
    label = f"{own[0]}: gap" if kind == "stops" else _coordinate_label(first, own, si, read)
    along = PanelQuantity(label, unit, read)
    if len(own) == 1:
        listed: list[Row] = [(along, PanelQuantity(words, acts_in, act))]
    elif len(results) == 1:
        listed = [(along, PanelQuantity(words, acts_in, act, tuple((name, names.index(name)) for name in own)))]
    else:
        each = [PanelQuantity(f"{words} of {name}", acts_in, DatasetColumns(kind, (name,), "force")) for name in own]
        listed = [(along, each[0]), *((None, other) for other in each[1:])]
    return PanelGroup(tuple(listed), (PanelQuantity(SIGN, unit, read), PanelQuantity(SIGN, acts_in, act)))


def _coordinate_label(result: Results, own: tuple[str, ...], si: str, read: DatasetColumns) -> str:
    """The label of the coordinate along which `own` acts: the joint coordinate with the same values, or a length."""
    values, of = read(result), ""
    for coordinate, unit in zip(result.names("coordinates"), result.names("coordinate_units"), strict=True):
        if unit == si and values is not None and alike(result.coordinate(coordinate).value, values[:, 0]):
            of = coordinate
            break
    if len(own) == 1:
        return f"{own[0]}: {of}" if of else own[0]
    return of or (f"length of {own[0]}" if si == "m" else own[0])


def _of_friction(results: Sequence[Results], name: str) -> tuple[PanelGroup, PanelGroup]:
    having = [result for result in results if name in result.names("frictions")]
    si = having[0].names("friction_units")[having[0].names("frictions").index(name)]
    word, acts_in = ACTION[si]
    rate, force, energy, power = (
        FrictionReader(name, of)
        for of in (
            lambda each: each.rate,
            lambda each: each.force,
            lambda each: each.dissipation,
            lambda each: -each.force * each.rate,
        )
    )
    speed = units_of(si, [_distance_slid(result, name) for result in having]).speed
    motion = PanelQuantity(f"{name}: rate", speed, rate), PanelQuantity(word, acts_in, force)
    cost = PanelQuantity("energy lost", ENERGY, energy), PanelQuantity("power lost", POWER, power)
    return (
        PanelGroup((motion,), (PanelQuantity(SIGN, speed, rate), PanelQuantity(SIGN, acts_in, force)), name),
        PanelGroup((cost,), (PanelQuantity(SIGN, ENERGY, energy), PanelQuantity(SIGN, POWER, power)), name),
    )


def _distance_slid(result: Results, name: str) -> Array:
    """About the whole distance that a friction has slid."""
    return np.array([np.trapezoid(np.abs(result.friction(name).rate), result.time)])


def _shade(figure: Figure, results: Sequence[Results]) -> bool:
    """Shade the panels of each friction while it sticks; return whether any does."""
    any_sticks = False
    if any(result.shown_over for result in results):  # spans of sticking are spans of time
        return False
    for axis in figure.axes:
        limits, name = axis.get_xlim(), str(axis.get_label())
        for result in results if axis.get_visible() else ():
            spans = list(sticking(result, name)) if name in result.names("frictions") else []
            if spans:  # one artist for all, as there may be thousands
                corners = [[(begin, 0.0), (begin, 1.0), (end, 1.0), (end, 0.0)] for begin, end in spans]
                look: dict[str, Any] = {"color": STICKS, "alpha": OPAQUE / len(results), "linewidth": 0, "zorder": 0.1}
                shade = PolyCollection(corners, transform=axis.get_xaxis_transform(), **look)
                axis.add_collection(shade, autolim=False)
                any_sticks = True
        axis.set_xlim(limits)
    return any_sticks


@styled
def draw_ropes(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw the length of each rope, and the tensions of its portions: a row for each rope, or, with several results, a
    row for each portion."""
    names = fitting_names.all_names(results, "tensions")
    ropes = list(dict.fromkeys(name.rpartition(".")[0] for name in names))
    own = [tuple(name for name in names if name.rpartition(".")[0] == rope) for rope in ropes]
    groups = rows.fitting([_of_rope(results, *each) for each in zip(ropes, own, strict=True)], results)
    return rows.draw(
        results, labels, groups, fitting_names.note("ropes", len(groups), len(ropes), "`mbproj export` writes all")
    )


def _of_rope(results: Sequence[Results], rope: str, names: tuple[str, ...]) -> PanelGroup:
    read = DatasetColumns("coordinates", (f"{rope}.length",), "coordinate")
    pulls = DatasetColumns("tensions", names, "tension")
    unit = units_of("m", [np.asarray(values) for result in results if (values := read(result)) is not None]).value
    length = PanelQuantity(f"{rope}: length", unit, read)
    if len(names) == 1 or len(results) == 1:
        lines = tuple((name, number) for number, name in enumerate(names)) if len(names) > 1 else ()
        listed: list[Row] = [(length, PanelQuantity("tension", TENSION, pulls, lines))]
    else:
        each = [PanelQuantity(name, TENSION, DatasetColumns("tensions", (name,), "tension")) for name in names]
        listed = [(length, each[0]), *((None, other) for other in each[1:])]
    return PanelGroup(tuple(listed), (PanelQuantity(SIGN, unit, read), PanelQuantity(SIGN, TENSION, pulls)))
