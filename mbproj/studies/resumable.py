"""Many runs in parallel whose results are kept in a journal as they come, so that none is run twice."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mbproj.studies.journal import Journal
from mbproj.studies.progress import Tell
from mbproj.studies.workers import in_parallel


def resumable(
    function: Callable[[Any, Any], Any],
    shared: Any,
    items: Mapping[str, Any],
    journal: Journal,
    processes: int | None,
    phase: str,
    tell: Tell,
) -> dict[str, Any]:
    """function(shared, item), which JSON can hold, of every item by its key. Those in the journal are not run again;
    `tell` is called with the phase and the number of items that are through."""
    missing = [key for key in items if key not in journal]
    through = len(items) - len(missing)
    tell(phase, through, len(items))
    for number, record in in_parallel(function, shared, [items[key] for key in missing], processes):
        journal.add(missing[number], record)
        through += 1
        tell(phase, through, len(items))
    return {key: journal[key] for key in items}
