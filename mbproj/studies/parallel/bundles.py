"""in_bundles(): many short items, sent together in bundles, so that sending them costs little.

A bundle whose process dies is sent again item by item: only an item that was alone in its process is blamed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from itertools import islice
from time import process_time
from typing import Any, Generic, TypeAlias, TypeVar

from mbproj.dataclass import dataclass
from mbproj.studies.parallel.client import Cluster
from mbproj.studies.parallel.hand_out import Where, in_parallel

Item = TypeVar("Item")
Result = TypeVar("Result")

#: The processor time of a bundle that is aimed at, s, on this machine and on a cluster: a hundred times the cost of
#: sending it.
SECONDS, SECONDS_THERE = 0.1, 0.5
#: The largest ratio of a bundle's size to that of the one before, and the most items in a bundle.
GROWTH, LARGEST = 4, 1000


@dataclass(frozen=True)
class Done(Generic[Result]):
    """The results of a bundle, and the processor time that it took, s."""

    results: tuple[Result, ...]
    seconds: float


@dataclass(frozen=True)
class Lost:
    """The fate of a bundle that did not come back: the reason, and after how long, s."""

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
    at_once: Callable[[Any, Sequence[Item]], Sequence[Result]] | None = None,
) -> Generator[list[tuple[Item, Result]], None, None]:
    """Yield lists of (item, function(shared, item)), in the order in which bundles end. `lost` returns the result of an
    item that does not come back, or takes longer than `timeout` in s."""
    is_long = isinstance(where, Cluster) or at_once is not None  # the first bundles are small, and slow for their size
    bundles = _Bundles(iter(items), SECONDS_THERE if is_long else SECONDS)

    def limit(bundle: tuple[Item, ...]) -> float | None:
        return None if timeout is None else timeout * len(bundle)

    for _, (bundle, outcome) in in_parallel(
        _run, (function, at_once, shared), bundles, where, _lost, limit, _is_single
    ):
        bundles.returned(bundle, outcome)
        if isinstance(outcome, Done):
            yield list(zip(bundle, outcome.results, strict=True))
        elif len(bundle) == 1:
            yield [(bundle[0], lost(bundle[0], outcome.why, outcome.seconds))]


class _Bundles(Iterator[tuple[Item, ...]]):
    """An iterator over bundles of items. The duration of the bundles before decides their size."""

    def __init__(self, items: Iterator[Item], seconds: float) -> None:
        self._items, self._seconds = items, seconds
        self._again, self._size = deque[Item](), 1

    def __next__(self) -> tuple[Item, ...]:
        if self._again:
            return (self._again.popleft(),)
        bundle = tuple(islice(self._items, self._size))
        if not bundle:
            raise StopIteration
        return bundle

    def returned(self, bundle: tuple[Item, ...], outcome: Outcome) -> None:
        """Take note of how a bundle ended. The items of a lost bundle are tried again one by one."""
        if isinstance(outcome, Lost):
            self._again.extend(bundle if len(bundle) > 1 else ())
            return
        fitting = int(self._seconds * len(bundle) / max(outcome.seconds, 1e-9))
        self._size = max(1, min(fitting, GROWTH * len(bundle), LARGEST))


def _run(shared: tuple[Any, Any, Any], bundle: tuple[Any, ...]) -> tuple[tuple[Any, ...], Outcome]:
    function, at_once, common = shared
    begun = process_time()  # other programs do not make bundles smaller
    if at_once is not None and len(bundle) > 1:
        results = tuple(at_once(common, bundle))
    else:
        results = tuple(function(common, item) for item in bundle)
    return bundle, Done(results, process_time() - begun)


def _lost(bundle: tuple[Any, ...], why: str, seconds: float) -> tuple[tuple[Any, ...], Outcome]:
    return bundle, Lost(why, seconds)


def _is_single(bundle: tuple[Any, ...]) -> bool:
    return len(bundle) == 1
