"""Reaction forces and torques of the joints over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.analysis.reactions import in_words, reactions_not_unique
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import fitting_names, panels, rows
from mbproj.figures.differences import SIGN
from mbproj.figures.rows import MAX_ROWS, PanelGroup, PanelQuantity
from mbproj.figures.style import OPEN, styled
from mbproj.figures.units import AxisUnit, sizes
from mbproj.results import Results


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
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw one result with a row of forces and one of torques: components of a single joint, magnitudes of several.
    Draw several results with a row for each joint, force beside torque, and their differences.

    Components that are not unique are grey. Magnitudes leave them out, or are grey where all components are not unique.
    The small print names torques that are round-off.
    """
    single = len(results) == 1
    names, remark = fitting_names.largest_joints(
        results, "joints/reaction_force", fitting_names.MAX_LINES if single else MAX_ROWS // 2
    )
    reactions = [[JointReaction.of(results, name, member) for name in names] for member, _, _ in KINDS]
    force, torque = (max((each.largest(results) for each in of), default=0.0) for of in reactions)
    said = [remark]
    if torque <= NOISE * force * sizes(results)["m"]:
        said.append("reaction torques are zero" + (f" (at most {torque:.0e} N m)" if torque else ""))
        del reactions[1]
    said += _left_out(results, names)
    if not single:
        return rows.draw(results, labels, list(_overlaid(reactions)), "; ".join(filter(None, said)))
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
