"""by_arrays(): cases that differ in numbers alone, in groups of those that go one way. What is left goes one by one."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any, TypeVar

from mbproj.errors import warn_once
from mbproj.lanes import Parted

Case = TypeVar("Case")
Result = TypeVar("Result")
#: Cases at least that are worth a block.
FEWEST = 8


def by_arrays(
    cases: Sequence[Case],
    together: Callable[[list[Case]], Sequence[Result | None]],
    alone: Callable[[Case], Result],
    agree: Callable[[Result, Result], bool],
    apart: Callable[[Case], Hashable] = lambda case: None,
) -> dict[int, Result]:
    """The results of those cases that arrays bring to their end, by their numbers.

    `together` gives the results of a group, and None for a case that has to go alone. A group has cases with the same
    `apart`. The first case of a group runs `alone` too: where both results do not `agree`, none of the group counts.
    """
    found: dict[int, Result] = {}
    groups: dict[Any, list[int]] = {}
    for at, case in enumerate(cases):
        groups.setdefault(apart(case), []).append(at)
    waiting = [*groups.values()]
    while waiting:
        own = waiting.pop()
        if len(own) < FEWEST:
            continue
        try:
            results = together([cases[at] for at in own])
        except Parted as parted:
            parts: dict[Any, list[int]] = {}
            for at, key in zip(own, parted.keys, strict=True):
                parts.setdefault(key, []).append(at)
            waiting += parts.values() if len(parts) > 1 else ()
            continue
        except Exception:  # whatever is wrong, a case alone says it in words
            continue
        ended = {at: result for at, result in zip(own, results, strict=True) if result is not None}
        first = next(iter(ended), None)
        if first is None or agree(alone(cases[first]), ended[first]):
            found |= ended
        else:
            warn_once("arrays have other bits than single cases have, which is a fault of mbproj: not used")
    return found
