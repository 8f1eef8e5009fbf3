"""Many runs in parallel whose results are kept as they come, so that none is run twice."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mbproj.studies.parallel.hand_out import Where, in_parallel
from mbproj.studies.parallel.progress import Tell
from mbproj.studies.store import Kept


def resumable(
    function: Callable[[Any, Any], Any],
    shared: Any,
    items: Mapping[str, Any],
    kept: Kept,
    processes: Where,
    phase: str,
    tell: Tell,
) -> dict[str, Any]:
    """function(shared, item), which JSON can hold, of every item by its key. Those that are kept are not run again;
    `tell` is called with the phase and the number of items that are through."""
    missing = [key for key in items if key not in kept]
    through = len(items) - len(missing)
    tell(phase, through, len(items))
    for number, record in in_parallel(function, shared, [items[key] for key in missing], processes):
        kept.add(missing[number], record)
        through += 1
        tell(phase, through, len(items))
    return {key: kept[key] for key in items}
