"""Pictures of loads: forces along coordinates with the energy lost, reactions of joints, and polar diagrams."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.results.analysis.contacts import sticking
from mbproj.results.analysis.loads import in_words, loads_of, reactions_not_unique, recorded_in
from mbproj.results.layout import ALL_NAMES
from mbproj.results.record import Friction, Results
from mbproj.show.figures import fitted_text, panels, rows
from mbproj.show.figures.panels import by_turns, in_degrees, label_of, small_print
from mbproj.show.figures.rows import MAX_ROWS, SIGN, PanelGroup, PanelQuantity, Row, alike
from mbproj.show.figures.style import OPEN, AxisUnit, line, page_width, sizes, styled, units_of

# --- Forces, motions, stops, dry frictions and ropes over time: coordinates, forces, and energy lost ------------------

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
    names = fitted_text.all_names(results, "frictions")
    groups = rows.fitting([group for name in names for group in _of_friction(results, name)], results)
    drawn = len({group.name for group in groups})
    remark = fitted_text.note("dry frictions", drawn, len(names), "`mbproj export` writes all")
    figure = rows.draw_rows(results, labels, groups, remark)
    if _shade(figure, results):
        small_print(figure, "shaded: it sticks" + (", the darker in the more results" if len(results) > 1 else ""))
    return figure


def _draw(results: Sequence[Results], labels: Sequence[str], kind: str, dataset: str) -> Figure:
    names = fitted_text.all_names(results, kind)
    together = _grouped_by_coordinate(results, kind, dataset, names)
    groups = rows.fitting([_group(results, kind, dataset, group, names) for group in together], results)
    count = sum(map(len, together[: len(groups)]))
    return rows.draw_rows(
        results, labels, groups, fitted_text.note(kind, count, len(names), "`mbproj export` writes all")
    )


def _grouped_by_coordinate(
    results: Sequence[Results], kind: str, dataset: str, names: Sequence[str]
) -> list[tuple[str, ...]]:
    """Group the names that act along the same coordinate in all results."""
    groups: list[tuple[str, ...]] = []
    for name in names:
        for place, group in enumerate(groups):
            if _coordinate_unit(results, kind, group[0]) != _coordinate_unit(results, kind, name):
                continue
            pairs = [[DatasetColumns(kind, (one,), dataset)(result) for one in (group[0], name)] for result in results]
            if all(a is not None and b is not None and np.array_equal(a, b) for a, b in pairs):
                groups[place] = (*group, name)
                break
        else:
            groups.append((name,))
    return groups


def _coordinate_unit(results: Sequence[Results], kind: str, name: str) -> str:
    """The unit (m or rad) of the coordinate of `name`, in the first result that has it."""
    first = next(result for result in results if name in result.names(kind))
    return first.names(f"{kind[:-1]}_units")[first.names(kind).index(name)]


def _group(
    results: Sequence[Results], kind: str, dataset: str, group: tuple[str, ...], names: Sequence[str]
) -> PanelGroup:
    """The rows of forces along one coordinate. With one result it is a row with a line for each name. With several it
    is a row for each name, and the coordinate once."""
    first = next(result for result in results if group[0] in result.names(kind))
    si = _coordinate_unit(results, kind, group[0])
    read, act = DatasetColumns(kind, group[:1], dataset), DatasetColumns(kind, group, "force")
    unit = units_of(si, [values for result in results if (values := read(result)) is not None]).value
    words, acts_in = ACTION[si]
    label = f"{group[0]}: gap" if kind == "stops" else _coordinate_label(first, group, si, read)
    along = PanelQuantity(label, unit, read)
    if len(group) == 1:
        listed: list[Row] = [(along, PanelQuantity(words, acts_in, act))]
    elif len(results) == 1:
        listed = [(along, PanelQuantity(words, acts_in, act, tuple((name, names.index(name)) for name in group)))]
    else:
        each = [PanelQuantity(f"{words} of {name}", acts_in, DatasetColumns(kind, (name,), "force")) for name in group]
        listed = [(along, each[0]), *((None, other) for other in each[1:])]
    return PanelGroup(tuple(listed), (PanelQuantity(SIGN, unit, read), PanelQuantity(SIGN, acts_in, act)))


def _coordinate_label(result: Results, group: tuple[str, ...], si: str, read: DatasetColumns) -> str:
    """The label of the coordinate along which `group` acts: the joint coordinate with the same values, or a length."""
    values, of = read(result), ""
    for coordinate, unit in zip(result.names("coordinates"), result.names("coordinate_units"), strict=True):
        if unit == si and values is not None and alike(result.coordinate(coordinate).value, values[:, 0]):
            of = coordinate
            break
    if len(group) == 1:
        return f"{group[0]}: {of}" if of else group[0]
    return of or (f"length of {group[0]}" if si == "m" else group[0])


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
    names = fitted_text.all_names(results, "tensions")
    ropes = list(dict.fromkeys(name.rpartition(".")[0] for name in names))
    portions = [tuple(name for name in names if name.rpartition(".")[0] == rope) for rope in ropes]
    groups = rows.fitting([_of_rope(results, *each) for each in zip(ropes, portions, strict=True)], results)
    return rows.draw_rows(
        results, labels, groups, fitted_text.note("ropes", len(groups), len(ropes), "`mbproj export` writes all")
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


# --- Reaction forces and torques of the joints over time --------------------------------------------------------------


@dataclass(frozen=True)
class JointReaction:
    """A joint's "reaction_force" or "reaction_torque", with marks of the components that are unique in all results."""

    joint: str
    member: str
    unique: tuple[bool, bool, bool]

    @classmethod
    def of(cls, results: Sequence[Results], joint: str, member: str) -> JointReaction:
        """The reaction of a joint, with uniqueness as these results mark it."""
        unique = np.ones(3, dtype=bool)
        for result in results:
            marks = result.constant(f"joints/{member}_unique")
            if marks is not None and joint in result.names("joints"):
                unique &= marks[result.names("joints").index(joint)]
        first, second, third = unique.tolist()
        return cls(joint, member, (first, second, third))

    def components(self, result: Results) -> Array | None:
        """All three components (T, 3); None where the result has no such joint."""
        if self.joint not in result.names("joints"):
            return None
        values: Array = getattr(result.joint(self.joint), self.member)
        return values

    def vector(self, result: Results) -> Array | None:
        """The unique components (T, 3) with zeros for the others; all components where none is unique."""
        values = self.components(result)
        return values if values is None or not any(self.unique) else np.where(self.unique, values, 0.0)

    def size(self, result: Results) -> Array | None:
        """The length (T) of `vector`."""
        vector = self.vector(result)
        return None if vector is None else np.linalg.norm(vector, axis=1)

    def largest(self, results: Sequence[Results]) -> float:
        """The largest component in all results."""
        components = [values for result in results if (values := self.components(result)) is not None]
        of = [np.max(np.abs(values), where=np.isfinite(values), initial=0.0) for values in components]
        return float(max(of, default=0.0))


#: The attribute of a joint, its name, and its unit.
KINDS = (("reaction_force", "force", AxisUnit("N", "N")), ("reaction_torque", "torque", AxisUnit("N m", "N m")))
#: Torques count as round-off where they are less than this part of the largest force times the mechanism's length.
#: Planar mechanisms reach 4e-16 of it; the smallest torques by loads in the shipped mechanisms are 1e-7.
NOISE = 1e-11


@styled
def draw_reactions(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw one result with a row of forces and one of torques: components of a single joint, magnitudes of several.
    Draw several results with a row for each joint, force beside torque, and their differences.

    Components that are not unique are grey. Magnitudes leave them out, or are grey where all components are not unique.
    The small print names torques that are round-off.
    """
    single = len(results) == 1
    names, remark = fitted_text.largest_joints(
        results, "joints/reaction_force", fitted_text.MAX_LINES if single else MAX_ROWS // 2
    )
    reactions = [[JointReaction.of(results, name, member) for name in names] for member, _, _ in KINDS]
    force, torque = (max((each.largest(results) for each in of), default=0.0) for of in reactions)
    said = [remark]
    if torque <= NOISE * force * sizes(results)["m"]:
        said.append("reaction torques are zero" + (f" (at most {torque:.0e} N m)" if torque else ""))
        del reactions[1]
    said += _left_out(results, names)
    if not single:
        return rows.draw_rows(results, labels, list(_overlaid(reactions)), "; ".join(filter(None, said)))
    figure, axes = panels.panels(len(reactions), height=2.1)
    for axis, of, (_, word, unit) in zip(axes[:, 0], reactions, KINDS, strict=False):
        _plot(axis, results[0], of)
        panels.hold_still([axis], sizes(results)[unit.si])
        what = f"reaction {word}"
        panels.name(axis, f"{what} of {names[0]}" if len(names) == 1 else f"|{what}|", unit.reads)
    return panels.finish(figure, remark="; ".join(filter(None, said)))


def _plot(axis: Axes, result: Results, reactions: Sequence[JointReaction]) -> None:
    """Draw the lines. Those that are not unique keep their dashes but are grey; the legend shows their own colours."""
    lines = _lines(result, reactions)
    for index, (text, values, is_unique) in enumerate(lines):
        part = slice(None) if is_unique else slice(0)
        panels.plot(axis, result.abscissa[part], values[part], text, index)
    for index, (_, values, is_unique) in enumerate(lines):
        if not is_unique:
            panels.plot(axis, result.abscissa, values, panels.NOT_UNIQUE, index, **OPEN)


def _lines(result: Results, reactions: Sequence[JointReaction]) -> list[tuple[str, Array, bool]]:
    """The label of each line, its values, and whether they are unique."""
    if len(reactions) == 1:
        (reaction,) = reactions
        values = reaction.components(result)
        assert values is not None
        return [(component, values[:, axis], reaction.unique[axis]) for axis, component in enumerate("xyz")]
    sizes_of = [(reaction, reaction.size(result)) for reaction in reactions]
    return [(reaction.joint, size, any(reaction.unique)) for reaction, size in sizes_of if size is not None]


def _overlaid(reactions: Sequence[Sequence[JointReaction]]) -> Iterator[PanelGroup]:
    """The rows of overlaid results: a row for each component of a single joint, or for each joint with magnitudes. Rows
    of differences follow."""
    for of in zip(*reactions, strict=True):
        pairs = [(reaction, word, unit) for reaction, (_, word, unit) in zip(of, KINDS, strict=False)]
        apart = tuple(PanelQuantity(SIGN, unit, reaction.vector) for reaction, _, unit in pairs)
        if len(reactions[0]) > 1:
            row = [
                PanelQuantity(f"{each.joint}: |{word}|", unit, each.size, not_unique=not any(each.unique))
                for each, word, unit in pairs
            ]
            yield PanelGroup((tuple(row),), apart)
            continue
        listed = [tuple(_component(*pair, axis) for pair in pairs) for axis in range(3)]
        yield PanelGroup(tuple(listed), apart)


def _component(reaction: JointReaction, word: str, unit: AxisUnit, axis: int) -> PanelQuantity:
    def read(result: Results) -> Array | None:
        values = reaction.components(result)
        return None if values is None else values[:, axis]

    words = f"{reaction.joint}: {word} {'xyz'[axis]}"
    return PanelQuantity(words, unit, read, not_unique=not reaction.unique[axis])


def _left_out(results: Sequence[Results], names: Sequence[str]) -> Iterator[str]:
    """Yield a remark on the components that magnitudes leave out."""
    if len(names) == 1:
        return
    words: dict[str, str] = {}
    for result in results:
        words |= {joint: open_ for joint, open_ in (reactions_not_unique(result) or {}).items() if joint in names}
    if words:
        yield f"not unique, and left out of magnitudes (grey where nothing else is left): {in_words(words)}"


# --- Polar diagrams of the joints' forces, and the forces of motions over the cycle -----------------------------------


#: The mark where a force is largest.
DOT = {"marker": "o", "markersize": 4}
#: The height of the panel of motions, as a part of the height of the polar diagram.
BELOW = 0.55


@styled
def draw_loads(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw the force vector of each joint in the plane in which forces vary most, with a dot where it is largest.

    A panel below shows the force or torque of each motion over the coordinate of the first motion. An angle is in
    degrees modulo a turn."""
    most = max(1, fitted_text.MAX_LINES // len(results))
    names, remark = fitted_text.largest_joints(results, "joints/reaction_force", most)
    motions = fitted_text.all_names(results, "motions")[:most]
    ratios = [1.0, BELOW] if motions else [1.0]
    figure = Figure(figsize=(page_width(), 0.65 * page_width() * sum(ratios)), layout="constrained")
    polar, *below = figure.subplots(len(ratios), 1, height_ratios=ratios, squeeze=False)[:, 0]
    _polar(polar, results, labels, names)
    for axis in below:
        _over_the_cycle(axis, results, labels, motions, len(names))
    return panels.finish(figure, remark=remark)


def _polar(axis: Axes, results: Sequence[Results], labels: Sequence[str], names: Sequence[str]) -> None:
    first, second = _plane(results, names)
    axis.set_aspect("equal", adjustable="datalim")
    for number, (result, label) in enumerate(zip(results, labels, strict=True)):
        largest = {load.name: load.time for load in loads_of(result) if load.quantity == "reaction_force"}
        for place, name in enumerate(names):
            if name not in result.names("joints"):
                continue
            force, look = result.joint(name).reaction_force, place + number * len(names)
            text = name if len(results) == 1 else f"{name}, {label}"
            panels.plot(axis, force[:, first], force[:, second], text, look)
            row = int(np.argmin(np.abs(result.time - largest.get(name, 0.0))))
            axis.plot(force[row, first], force[row, second], **(line(look) | DOT))
    axis.set_xlabel(f"reaction force, {'xyz'[first]} (N)")
    axis.set_ylabel(f"{'xyz'[second]} (N)")


def _plane(results: Sequence[Results], names: Sequence[str]) -> tuple[int, int]:
    """The two axes along which the forces vary most, in the order x, y, z."""
    spans = [
        np.ptp(result.joint(name).reaction_force, axis=0)
        for result in results
        for name in names
        if name in result.names("joints")
    ]
    first, second = sorted(np.argsort(-np.max(spans, axis=0), kind="stable")[:2].tolist())
    return first, second


def _over_the_cycle(
    axis: Axes, results: Sequence[Results], labels: Sequence[str], motions: Sequence[str], looks: int
) -> None:
    """Draw the force or torque of each motion over the coordinate of the first, with a gap where a new turn begins."""
    for number, (result, label) in enumerate(zip(results, labels, strict=True)):
        cycle = recorded_in(result).cycle()
        for place, name in enumerate(motions):
            if cycle is None or name not in result.names("motions"):
                continue
            text = f"{name} ({_load_unit(result, name)})" + ("" if len(results) == 1 else f", {label}")
            at, force = in_degrees(cycle.values, cycle.unit), result.motion(name).force
            line_of = by_turns(at, force) if cycle.unit == "rad" else (at, force)
            panels.plot(axis, *line_of, text, looks + place + number * len(motions))
            axis.set_xlabel(label_of(cycle.name, cycle.unit))
    axis.set_ylabel("force or torque of motions")


def _load_unit(result: Results, name: str) -> str:
    units = dict(zip(result.names("motions"), result.names("motion_units"), strict=True))
    return "N m" if units[name] == "rad" else "N"
