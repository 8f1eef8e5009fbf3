"""in_bundles(): many short items, several of them sent together, so that handing them out costs little beside them.

A bundle whose process dies is taken apart: only an item that was alone in its process is held responsible.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from itertools import islice
from time import perf_counter
from typing import Any, Generic, TypeAlias, TypeVar

from mbproj.dataclass import dataclass
from mbproj.studies.parallel.client import Cluster
from mbproj.studies.parallel.hand_out import Where, in_parallel

Item = TypeVar("Item")
Result = TypeVar("Result")

#: A bundle is to take this long, s, on this machine and on a cluster: a hundred times what handing it out costs.
SECONDS, SECONDS_THERE = 0.1, 0.5
#: No bundle is so many times as large as the one before, nor holds more than so many items.
GROWTH, LARGEST = 4, 1000


@dataclass(frozen=True)
class Done(Generic[Result]):
    """The results of a bundle, and how long it took, s."""

    results: tuple[Result, ...]
    seconds: float


@dataclass(frozen=True)
class Lost:
    """A bundle did not come back: why, and after how long, s."""

    why: str
    seconds: float


Outcome: TypeAlias = "Done[Any] | Lost"


def in_bundles(
    function: Callable[[Any, Item], Result],
    shared: Any,
    items: Iterable[Item],
    where: Where,
    lost: Callable[[Item, str, float], Result],
    timeout: float | None = None,
) -> Generator[list[tuple[Item, Result]], None, None]:
    """(item, function(shared, item)) for all items, some of them at a time, in the order in which they come to an end.
    `lost` gives the result of one that does not come back, or takes longer than `timeout` in s."""
    bundles = _Bundles(iter(items), SECONDS_THERE if isinstance(where, Cluster) else SECONDS)

    def limit(bundle: tuple[Item, ...]) -> float | None:
        return None if timeout is None else timeout * len(bundle)

    for _, (bundle, outcome) in in_parallel(_run, (function, shared), bundles, where, _lost, limit, _is_single):
        bundles.returned(bundle, outcome)
        if isinstance(outcome, Done):
            yield list(zip(bundle, outcome.results, strict=True))
        elif len(bundle) == 1:
            yield [(bundle[0], lost(bundle[0], outcome.why, outcome.seconds))]


class _Bundles(Iterator[tuple[Item, ...]]):
    """Bundles of items, sized by how long those before took."""

    def __init__(self, items: Iterator[Item], seconds: float) -> None:
        self._items, self._seconds = items, seconds
        self._again, self._size = deque[Item](), 1

    def __next__(self) -> tuple[Item, ...]:
        if self._again:
            return (self._again.popleft(),)
        found = tuple(islice(self._items, self._size))
        if not found:
            raise StopIteration
        return found

    def returned(self, bundle: tuple[Item, ...], outcome: Outcome) -> None:
        """Takes in how a bundle ended. Of one that was lost each item is tried alone."""
        if isinstance(outcome, Lost):
            self._again.extend(bundle if len(bundle) > 1 else ())
            return
        fitting = int(self._seconds * len(bundle) / max(outcome.seconds, 1e-9))
        self._size = max(1, min(fitting, GROWTH * len(bundle), LARGEST))


def _run(shared: tuple[Callable[[Any, Any], Any], Any], bundle: tuple[Any, ...]) -> tuple[tuple[Any, ...], Outcome]:
    function, common = shared
    begun = perf_counter()
    results = tuple(function(common, item) for item in bundle)
    return bundle, Done(results, perf_counter() - begun)


def _lost(bundle: tuple[Any, ...], why: str, seconds: float) -> tuple[tuple[Any, ...], Outcome]:
    return bundle, Lost(why, seconds)


def _is_single(bundle: tuple[Any, ...]) -> bool:
    return len(bundle) == 1
