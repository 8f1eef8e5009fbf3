"""Work in parallel: the one place that distributes it, in this process, on this machine, or on a Dask cluster.

All take a function of a module, data that all items share, and items, and give results as they come: `in_parallel` any
items, `in_bundles` many short ones. Items and results are sent to other processes, and have to be such that pickle can
send them.
"""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence, Sized
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from itertools import islice
from queue import Empty, SimpleQueue
from threading import Lock
from time import monotonic, process_time
from typing import Any, TypeAlias, TypeVar

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import warn_once
from mbproj.motion.interruption import interruption
from mbproj.studies.parallel.cluster import Cluster, on_cluster
from mbproj.studies.parallel.workers import Worker, WorkerLost

Item = TypeVar("Item")
Result = TypeVar("Result")
#: Where to work: the number of processes on this machine (None: one for each processor), or a cluster.
Where: TypeAlias = "int | Cluster | None"

# --- in_parallel(): any items -----------------------------------------------------------------------------------------

#: Time between two checks for Ctrl-C, s.
LOOK = 0.1
#: The most processes for each processor: more only take memory.
MOST = 4
#: Items that are out for each process: the one in work, and the next.
AHEAD = 2


def processors() -> int:
    """The number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_parallel(
    function: Callable[[Any, Item], Result],
    shared: Any,
    items: Iterable[Item],
    where: Where = None,
    lost: Callable[[Item, str, float], Result] | None = None,
    timeout: Callable[[Item], float | None] | float | None = None,
    blamed: Callable[[Item], bool] = lambda item: True,
) -> Generator[tuple[int, Result], None, None]:
    """Yield (index, function(shared, item)) for every item, in the order in which they end.

    `function` is a function of a module; `shared` is sent to each process once. Where one process is enough, this
    process does the work. With `lost`, all items run in other processes. Then `lost(item, why, seconds)` is the result
    of an item whose process dies, or takes longer than its `timeout` in s; without `lost` that raises RuntimeError. On
    a cluster an item that is `blamed` counts as lost only when it was out alone.

    Few items are out at a time, so there may be any number of them. An iterator that has ended is asked again while
    items are out, because a result may make new items: the parts of a lost bundle. Leaving the generator early ends the
    processes. SIGINT and SIGTERM raise KeyboardInterrupt.
    """
    if isinstance(where, Cluster):
        yield from on_cluster(function, shared, items, where, lost, timeout, blamed)
        return
    count = min(where or processors(), len(items) if isinstance(items, Sized) else 1 << 30)
    if lost is None and count <= 1:
        for index, item in enumerate(items):
            yield index, function(shared, item)
        return
    if count > (most := MOST * processors()) and not isinstance(items, Sized):
        warn_once(f"{count} processes are more than {processors()} processors can use: at most {most} are started")
    count = min(count, most)
    notes: deque[str] = deque()
    workers = _Workers(lambda: Worker(function, shared, notes))

    def run(item: Item) -> Result:
        """The result of an item, from a process that is idle. A thread waits for each item that is out."""
        worker, begun = workers.take(), monotonic()
        try:
            result: Result = worker.ask(item, timeout(item) if callable(timeout) else timeout)
            return result
        except WorkerLost as reason:
            if lost is None:
                raise
            worker.start()
            return lost(item, str(reason), monotonic() - begun)
        finally:
            workers.idle.put(worker)

    pool = ThreadPoolExecutor(max(count, 1))
    rest, numbers = iter(items), itertools.count()
    try:
        with interruption() as asked:
            waiting: dict[Future[Result], int] = {}
            while True:
                for item, index in zip(islice(rest, AHEAD * count - len(waiting)), numbers, strict=False):
                    waiting[pool.submit(run, item)] = index
                if not waiting:
                    return
                asked.check()
                finished = wait(waiting, LOOK, FIRST_COMPLETED).done
                while notes:
                    warn_once(notes.popleft())
                for future in finished:
                    yield waiting.pop(future), future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        workers.stop()


class _Workers:
    """The processes of a study. A new one is started when an item finds none idle, so that few items start few."""

    def __init__(self, start: Callable[[], Worker]) -> None:
        self._start, self._lock = start, Lock()
        self._started: list[Worker] = []
        self._stopped = False
        self.idle: SimpleQueue[Worker] = SimpleQueue()

    def take(self) -> Worker:
        """An idle worker, or a new one. Raises WorkerLost after `stop`."""
        with suppress(Empty):
            return self.idle.get_nowait()
        with self._lock:
            if self._stopped:
                raise WorkerLost("the study has ended")
            self._started.append(self._start())
            return self._started[-1]

    def stop(self) -> None:
        """Stop all workers, also busy ones."""
        with self._lock:
            self._stopped = True
        for worker in self._started:
            worker.stop()


# --- in_bundles(): many short items, sent together in bundles, so that sending them costs little ----------------------
# A bundle whose process dies is sent again item by item: only an item that was alone in its process is blamed.


#: The processor time of a bundle that is aimed at, s, on this machine and on a cluster: a hundred times the cost of
#: sending it.
SECONDS, SECONDS_THERE = 0.1, 0.5
#: The largest ratio of a bundle's size to that of the one before, and the most items in a bundle.
GROWTH, LARGEST = 4, 1000


@dataclass(frozen=True)
class Ended:
    """How a bundle ended: its results, or None where it did not come back, and `why`. `seconds` is the processor time
    that it took, or the time after which it was lost."""

    bundle: tuple[Any, ...]
    results: tuple[Any, ...] | None
    seconds: float
    why: str = ""


def in_bundles(
    function: Callable[[Any, Item], Result],
    shared: Any,
    items: Iterable[Item],
    where: Where,
    lost: Callable[[Item, str, float], Result],
    timeout: float | None = None,
    at_once: Callable[[Any, Sequence[Item]], Sequence[Result]] | None = None,
) -> Generator[list[tuple[Item, Result]], None, None]:
    """Yield lists of (item, function(shared, item)), in the order in which bundles end. `at_once(shared, items)`, where
    there is one, gives the results of several items faster. `lost` returns the result of an item that does not come
    back, or takes longer than `timeout` in s."""
    is_long = isinstance(where, Cluster) or at_once is not None  # the first bundles are small, and slow for their size
    bundles = _Bundles(iter(items), SECONDS_THERE if is_long else SECONDS)

    def limit(bundle: tuple[Item, ...]) -> float | None:
        return None if timeout is None else timeout * len(bundle)

    def gone(bundle: tuple[Item, ...], why: str, seconds: float) -> Ended:
        return Ended(bundle, None, seconds, why)

    shares = function, at_once, shared
    for _, ended in in_parallel(_run, shares, bundles, where, gone, limit, lambda bundle: len(bundle) == 1):
        bundles.returned(ended)
        if ended.results is not None:
            yield list(zip(ended.bundle, ended.results, strict=True))
        elif len(ended.bundle) == 1:
            (item,) = ended.bundle
            yield [(item, lost(item, ended.why, ended.seconds))]


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

    def returned(self, ended: Ended) -> None:
        """Take note of how a bundle ended. The items of a lost bundle are tried again one by one."""
        count = len(ended.bundle)
        if ended.results is None:
            self._again.extend(ended.bundle if count > 1 else ())
            return
        fitting = int(self._seconds * count / max(ended.seconds, 1e-9))
        self._size = max(1, min(fitting, GROWTH * count, LARGEST))


def _run(shared: tuple[Any, Any, Any], bundle: tuple[Any, ...]) -> Ended:
    """The results of a bundle: the work of one process."""
    function, at_once, common = shared
    begun = process_time()  # other programs do not make bundles smaller
    if at_once is not None and len(bundle) > 1:
        results = tuple(at_once(common, bundle))
    else:
        results = tuple(function(common, item) for item in bundle)
    return Ended(bundle, results, process_time() - begun)
