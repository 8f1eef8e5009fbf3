"""What `check` says of the stops and the dry frictions of a start."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mbproj.integrate.stops.resting import RubsAtStart
    from mbproj.integrate.stops.start import AtStart

#: Frictions that are named at most, and the part of what one holds below which it bears nothing but round-off.
NAMED, NOTHING = 8, 1e-12


def stops(found: Mapping[str, AtStart]) -> list[str]:
    """How many stops there are, and which of them touch."""
    touching = ", ".join(f"'{name}'" for name, entry in found.items() if entry["touches"])
    said = f"touching at the start: {touching}" if touching else "none touches at the start"
    return [f"  {len(found)} stops, {said}"] if found else []


def frictions(found: Mapping[str, RubsAtStart], where: str = "") -> list[str]:
    """How many dry frictions there are, and which of them stick `where`: "at the start", say."""
    if not found:
        return []
    sticking = [f"'{name}' bears {_borne(entry)}" for name, entry in found.items() if entry["sticks"]]
    more = [f"and {len(sticking) - NAMED} more"] if len(sticking) > NAMED else []
    said = f"sticking{where}: {', '.join([*sticking[:NAMED], *more])}" if sticking else f"none sticks{where}"
    count = "1 dry friction" if len(found) == 1 else f"{len(found)} dry frictions"
    return [f"  {count}, {said}"]


def _borne(entry: RubsAtStart) -> str:
    """What a friction bears of what it can."""
    size, most = abs(entry["force"]), entry["static"]
    return f"{size if size > NOTHING * most else 0.0:.4g} of {most:.4g} {'N m' if entry['unit'] == 'rad' else 'N'}"
