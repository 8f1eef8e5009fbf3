"""Position and velocity of each marker over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import fitting_names, panels, rows, untrusted
from mbproj.figures.differences import SIGN
from mbproj.figures.rows import PanelGroup, PanelQuantity
from mbproj.figures.style import styled
from mbproj.figures.units import METRES
from mbproj.results import Results

#: A component counts as hidden where it moves by less than this part of the range of its panel.
HIDDEN = 0.03
PANELS = (("position", METRES.value), ("velocity", METRES.speed))


@dataclass(frozen=True)
class Components:
    """A reader of components (T, k) of a marker; None where a result has no such marker."""

    marker: str
    member: str
    which: tuple[int, ...]

    def __call__(self, result: Results) -> Array | None:
        if self.marker not in result.names("markers"):
            return None
        values: Array = getattr(result.marker(self.marker), self.member)
        return values[:, list(self.which)]


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw one result with a row for each marker and lines x, y, z; a component that others would hide gets its own
    row. Draw several with a row for each component, and the distance of the markers."""
    names = fitting_names.all_names(results, "markers")
    single = len(results) == 1
    moving = _moving(results, names)
    listed = [_rows_apart(name, results[0], moving) if single else _overlaid(name, moving) for name in names]
    groups = rows.fitting(listed, results)
    cut = fitting_names.note("markers", len(groups), len(names), "choose others with --marker")
    still = ", ".join("xyz"[index] for index in range(3) if index not in moving)
    zero = f"{still} {'are' if len(still) > 1 else 'is'} zero throughout" if still else ""
    return rows.draw(results, labels, groups, "; ".join(filter(None, (cut, zero))))


def _moving(results: Sequence[Results], names: Sequence[str]) -> tuple[int, ...]:
    """The components that are not always zero, up to round-off, at all markers. In a plane motion normal to an axis
    these are two. All components, where none is left."""
    largest = np.zeros((len(PANELS), 3))
    for place, (member, _) in enumerate(PANELS):
        for result in results:
            for name in set(names) & set(result.names("markers")):
                values = np.abs(getattr(result.marker(name), member))
                largest[place] = np.maximum(largest[place], np.nanmax(values, axis=0, initial=0.0))
    some = (largest > panels.ROUND_OFF * largest.max(axis=1, keepdims=True)).any(axis=0)
    return tuple(np.flatnonzero(some).tolist()) or (0, 1, 2)


def mark_untrusted(figure: Figure, results: Sequence[Results], limit: float) -> str:
    """Shade each marker's panels from the time on at which its error may exceed the limit. Return a text on it."""
    own: dict[str, list[Axes]] = {}
    for axis in figure.axes:
        own.setdefault(str(axis.get_label()), []).append(axis)
    return untrusted.shade(own, results, limit)


def _rows_apart(name: str, result: Results, moving: tuple[int, ...]) -> PanelGroup:
    """Rows of components that do not hide each other."""
    listed = []
    for together in legible(result.marker(name).position, result.marker(name).velocity):
        which = tuple(index for index in together if index in moving)
        if not which:
            continue
        parts = tuple(("xyz"[index], index) for index in which)
        some = "" if len(which) == len(moving) else ", ".join(part for part, _ in parts)
        words = (f"{name}: {some}", f"velocity {some}") if some else (f"position of {name}", "velocity")
        own = [(unit, Components(name, word, which)) for word, unit in PANELS]
        listed.append(tuple(PanelQuantity(text, *of, parts) for text, of in zip(words, own, strict=True)))
    return PanelGroup(tuple(listed), name=name)


def _overlaid(name: str, moving: tuple[int, ...]) -> PanelGroup:
    listed = []
    for index in moving:
        component = "xyz"[index]
        row = [(unit, Components(name, word, (index,))) for word, unit in PANELS]
        words = f"{name}: {component}", f"velocity {component}"
        listed.append(tuple(PanelQuantity(text, *own) for text, own in zip(words, row, strict=True)))
    apart = tuple(PanelQuantity(SIGN, unit, Components(name, word, (0, 1, 2))) for word, unit in PANELS)
    return PanelGroup(tuple(listed), apart, name)


def legible(*histories: Array) -> list[tuple[int, ...]]:
    """Group the components of vectors (T, 3) so that none hides another of its group. Small movements beside large
    ones, or far from them, would be hidden. A component that does not move cannot be hidden."""
    chosen: list[tuple[int, ...]] = []
    moved = np.max([_ranges(history) for history in histories], axis=0)
    for index in sorted(range(3), key=lambda index: -moved[index]):
        for place, group in enumerate(chosen):
            together = tuple(sorted((*group, index)))
            if not any(_hides(history[:, list(together)]) for history in histories):
                chosen[place] = together
                break
        else:
            chosen.append((index,))
    return sorted(chosen)


def _ranges(values: Array) -> Array:
    """The range of each component (3)."""
    finite = np.where(np.isfinite(values), values, 0.0)
    distance: Array = np.ptp(finite, axis=0)
    return distance


def _hides(values: Array) -> bool:
    """Whether in one panel with these components (T, k) some moving component would be hidden."""
    finite = values[np.all(np.isfinite(values), axis=1)]
    if not len(finite):
        return False
    moved, whole = _ranges(finite), float(np.ptp(finite))
    moves = moved > max(panels.STILL * float(moved.max()), panels.ROUND_OFF * float(np.abs(finite).max()))
    return bool(np.any(moves & (moved < HIDDEN * whole)))
