"""in_parallel(): the one function that distributes work, in this process, on this machine, or on a Dask cluster."""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sized
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from itertools import islice
from queue import Empty, SimpleQueue
from threading import Lock
from time import monotonic
from typing import Any, TypeAlias, TypeVar

from mbproj.errors import warn_once
from mbproj.integrate.interruption import interruption
from mbproj.studies.parallel.client import Cluster
from mbproj.studies.parallel.cluster import on_cluster
from mbproj.studies.parallel.workers import Worker, WorkerLost

Item = TypeVar("Item")
Result = TypeVar("Result")
#: The number of processes on this machine (None: one for each processor), or a cluster.
Where: TypeAlias = "int | Cluster | None"

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
    items are out. Leaving the generator early ends the processes. SIGINT and SIGTERM raise KeyboardInterrupt.
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
    given, numbers = iter(items), itertools.count()
    try:
        with interruption() as asked:
            waiting: dict[Future[Result], int] = {}
            while True:
                for item, index in zip(islice(given, AHEAD * count - len(waiting)), numbers, strict=False):
                    waiting[pool.submit(run, item)] = index
                if not waiting:
                    return
                asked.check()
                ended = wait(waiting, LOOK, FIRST_COMPLETED).done
                while notes:
                    warn_once(notes.popleft())
                for done in ended:
                    yield waiting.pop(done), done.result()
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
