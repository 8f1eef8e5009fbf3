"""Many runs in parallel, whose results are stored as they come, so that none is run twice."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mbproj.studies.parallel.hand_out import Where, in_parallel
from mbproj.studies.parallel.progress import Tell, with_words
from mbproj.studies.store import ValueCache


def resumable(
    function: Callable[[Any, Any], Any],
    shared: Any,
    items: Mapping[str, Any],
    kept: ValueCache,
    processes: Where,
    phase: str,
    tell: Tell,
    best: Callable[[Any], tuple[Any, str]] | None = None,
) -> dict[str, Any]:
    """The results function(shared, item) of all items by their keys, each of which JSON can hold. Results in the store
    `kept` are not computed again.

    `tell` is called with the phase and the number of items done. `best` returns the rank of a result and words on it;
    the words of the least rank are added to the phase."""
    missing = [key for key in items if key not in kept]
    ranked = [] if best is None else [best(kept[key]) for key in items if key in kept]

    def say(through: int) -> None:
        tell(with_words(phase, min(ranked)[1]) if ranked else phase, through, len(items))

    say(len(items) - len(missing))
    for through, (number, record) in enumerate(
        in_parallel(function, shared, [items[key] for key in missing], processes), len(items) - len(missing) + 1
    ):
        kept.add(missing[number], record)
        ranked += [] if best is None else [best(record)]
        say(through)
    return {key: kept[key] for key in items}
