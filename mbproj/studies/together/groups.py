"""by_arrays(): cases that differ in numbers alone, in groups of those that go one way. What is left goes one by one."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any, TypeVar

from mbproj.errors import warn_once
from mbproj.lanes import Parted
from mbproj.scene.text.changes import SIMULATION

Case = TypeVar("Case")
Result = TypeVar("Result")
#: Cases at least that are worth a group: of 4, six-bars take 0.8 and five-bars 0.65 of the time that they take alone.
FEWEST = 5


def by_arrays(
    cases: Sequence[Case],
    together: Callable[[list[Case]], Sequence[Result | None]],
    holds: Callable[[Case, Result], bool] = lambda case, result: True,
    apart: Callable[[Case], Hashable] = lambda case: None,
) -> dict[int, Result]:
    """The results of those cases that arrays bring to their end, by their numbers.

    `together` gives the results of a group, and None for a case that has to go alone. A group has cases with the same
    `apart`. Where the result of the first case of a group does not `hold` beside that of its own run, none counts.
    """
    by_place: dict[int, Result] = {}
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
        if first is None or holds(cases[first], ended[first]):
            by_place |= ended
        else:
            warn_once("arrays have other bits than single cases have, which is a fault of mbproj: not used")
    return by_place


def shared(paths: Sequence[str], values: Sequence[float | str]) -> tuple[float | str, ...]:
    """What all cases of a group share of the values at these paths: their texts, and their settings."""
    pairs = zip(paths, values, strict=True)
    return tuple(each for path, each in pairs if isinstance(each, str) or path.startswith(f"{SIMULATION}."))
