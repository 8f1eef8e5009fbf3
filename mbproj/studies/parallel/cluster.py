"""Work on a running Dask cluster, whose workers have mbproj installed.

Few tasks are out at a time, whatever their number. A worker that is lost is blamed on all that it had: here only an
item that was out alone is held responsible. What a scheduler's end loses, the caller's store has.
"""

from __future__ import annotations

import asyncio
import pickle
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from functools import lru_cache
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeVar

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.integrate.loop.interruption import interruption
from mbproj.studies.parallel.client import UNREACHABLE, Cluster, ClusterLost, connected
from mbproj.studies.parallel.workers import OVERDUE
from mbproj.version import __version__

if TYPE_CHECKING:
    from distributed import Client, Future

Item = TypeVar("Item")
Result = TypeVar("Result")

#: For a scheduler that was there to come back, s; between two looks at the workers.
GONE, REFRESH = 5.0, 1.0
#: How often Ctrl-C is looked for, s.
LOOK = 0.1
#: Tasks that are out for each thread: the one at work, and the next.
AHEAD = 2
#: For workers to come, s, where Dask's setting `distributed.scheduler.no-workers-timeout` says nothing.
NO_WORKERS = 60.0
#: How often Dask may give up an item that has done nothing wrong: its result was on a worker that was lost, say.
GIVEN_UP = 5
#: What shared data a worker keeps unpacked.
TASKS_KNOWN = 8


def on_cluster(
    function: Callable[[Any, Item], Result],
    shared: Any,
    items: Iterable[Item],
    cluster: Cluster,
    lost: Callable[[Item, str, float], Result] | None = None,
    timeout: Callable[[Item], float | None] | float | None = None,
    blamed: Callable[[Item], bool] = lambda item: True,
) -> Generator[tuple[int, Result], None, None]:
    """As `in_parallel`, on a cluster. Raises InputError where it cannot be reached, ClusterLost where it ends."""
    with connected(cluster) as client, interruption() as asked:
        out = _Out(client, cluster, pickle.dumps((__version__, function, shared)))
        given, suspects, index = iter(items), deque[_Task](), -1
        try:
            while True:
                while out.room > 0 and (item := next(given, _NONE)) is not _NONE:
                    index += 1
                    out.send(index, item, timeout(item) if callable(timeout) else timeout)
                if not out.tasks and suspects:
                    suspect = suspects.popleft()
                    out.send(suspect.index, suspect.item, suspect.limit, alone=True)
                if not out.tasks:
                    return
                asked.check()
                for task, result, fault in out.ended():
                    if fault is None:
                        yield task.index, result
                    elif lost is None:
                        raise RuntimeError(fault)
                    elif task.alone or not blamed(task.item):
                        yield task.index, lost(task.item, fault, monotonic() - task.sent)
                    else:
                        suspects.append(task)
        finally:
            out.withdraw()


#: No item.
_NONE: Any = object()


@dataclass(eq=False)
class _Task:
    """An item that is out: its number, when it was sent, how long it may take (s; None: as long as it takes); whether
    no other is out beside it; how often Dask gave it up; since when a worker has had it, as far as that was looked
    at."""

    index: int
    item: Any
    future: Future
    sent: float
    limit: float | None
    alone: bool
    given_up: int = 0
    begun: float | None = None

    def is_overdue(self, now: float) -> bool:
        """Whether it should have come back, even if it had to wait for the one before it."""
        return self.limit is not None and self.begun is not None and now > self.begun + AHEAD * self.limit


class _Out:
    """The tasks that are out on a cluster."""

    def __init__(self, client: Client, cluster: Cluster, work: bytes) -> None:
        import dask

        self._client, self._cluster, self._work = client, cluster, work
        self.tasks: dict[str, _Task] = {}
        self._back: SimpleQueue[str] = SimpleQueue()
        self._threads = 0
        self._there = self._looked = monotonic()
        patience = dask.config.get("distributed.scheduler.no-workers-timeout", None)
        self._patience = NO_WORKERS if patience is None else dask.utils.parse_timedelta(patience, default="s")
        self._refresh()

    @property
    def room(self) -> int:
        """How many more tasks may go out."""
        if any(task.alone for task in self.tasks.values()):
            return 0
        return AHEAD * max(self._threads, 1) - len(self.tasks)

    def send(self, index: int, item: Any, limit: float | None, alone: bool = False, given_up: int = 0) -> None:
        """An item goes out."""
        with self._reaching():
            future = self._client.submit(_call, self._work, pickle.dumps(item), pure=False)
        self.tasks[future.key] = _Task(index, item, future, monotonic(), limit, alone, given_up)
        future.add_done_callback(lambda done: self._back.put(done.key))

    def ended(self) -> Iterator[tuple[_Task, Any, str | None]]:
        """The tasks that have ended, each with its result, or why it was lost. Waits for a moment."""
        with suppress(Empty):
            task = self.tasks.pop(self._back.get(timeout=LOOK), None)
            if task is not None:  # or it was overdue
                yield from self._answered(task)
        if monotonic() - self._looked > REFRESH:
            yield from self._overdue()
            self._refresh()

    def _answered(self, task: _Task) -> Iterator[tuple[_Task, Any, str | None]]:
        """The result of a task, or why it was lost. One that Dask gave up goes out again."""
        done, result, fault = self._taken(task.future)
        if done:
            yield task, result, None if fault is None else self._why(fault)
        elif self._client.status == "running" and task.given_up < GIVEN_UP:
            self.send(task.index, task.item, task.limit, task.alone, task.given_up + 1)
        else:
            raise self._gone()

    def _taken(self, future: Future) -> tuple[bool, Any, BaseException | None]:
        """Whether the task has come to an end, its result, and its fault."""
        with self._reaching(), suppress(CancelledError, asyncio.CancelledError):
            if future.status == "finished":
                return True, pickle.loads(future.result()), None
            if future.status == "error":
                return True, None, future.exception()
        return False, None, None

    def _why(self, fault: BaseException) -> str:
        """Why a task was lost. Raises what is not the end of its worker."""
        from distributed import KilledWorker

        if isinstance(fault, KilledWorker):
            return "its worker was lost: killed, or out of memory?"
        if isinstance(fault, ImportError) and (fault.name or "").startswith("mbproj"):
            problem = Problem("the workers have no mbproj", Place(self._cluster.option), "install it where they run")
            raise InputError(problem) from fault
        raise fault

    @contextmanager
    def _reaching(self) -> Iterator[None]:
        """What Dask raises in the block where it has lost its scheduler, in one way or another, is ClusterLost."""
        try:
            yield
        except UNREACHABLE as error:
            # A connection that breaks is an OSError, and the client may learn of it later.
            lost = isinstance(error, (OSError, CancelledError, asyncio.CancelledError))
            if self._client.status == "running" and not lost:
                raise
            raise self._gone() from error

    def _overdue(self) -> Iterator[tuple[_Task, Any, str | None]]:
        """Ends the workers of tasks that should have stopped by themselves."""
        if all(task.limit is None for task in self.tasks.values()) or self._client.status != "running":
            return
        now, had_by = monotonic(), {}
        with suppress(*UNREACHABLE):
            had_by = self._client.processing()
        for address, keys in had_by.items():
            had = [self.tasks[key] for key in keys if key in self.tasks]
            for task in had:
                task.begun = task.begun or now
            late = next((task for task in had if task.is_overdue(now)), None)
            if late is not None:  # the others there go elsewhere
                del self.tasks[late.future.key]
                late.future.cancel()
                with suppress(*UNREACHABLE):  # it is gone already, or has no nanny
                    self._client.restart_workers([address], raise_for_error=False)
                yield late, None, f"{OVERDUE} {late.limit:g} s"

    def _refresh(self) -> None:
        """Looks how many threads there are, and whether anybody is there at all."""
        now = monotonic()
        threads = self._counted()
        if threads is None:
            if now - self._looked > GONE:
                raise self._gone()
            return
        self._threads, self._looked = threads, now
        if self._threads:
            self._there = now
        elif now - self._there > self._patience:
            message = f"the scheduler at '{self._cluster}' has had no workers for {self._patience:g} s"
            raise ClusterLost(f"{message}; start some with 'dask worker', and go on with the same command")

    def _counted(self) -> int | None:
        """How many threads the workers have; None where the scheduler does not answer."""
        if self._client.status != "running":
            return None
        try:
            return sum(self._client.nthreads().values())
        except UNREACHABLE:
            return None

    def _gone(self) -> ClusterLost:
        kept = "what was computed is kept: start it again, and go on with the same command"
        return ClusterLost(f"the scheduler at '{self._cluster}' is gone; {kept}")

    def withdraw(self) -> None:
        """Nobody waits any more for what is out."""
        if self.tasks and self._client.status == "running":
            with suppress(*UNREACHABLE):
                self._client.cancel([task.future for task in self.tasks.values()])


def _call(work: bytes, item: bytes) -> bytes:
    """On a worker: the pickled result of the function for an item. Both come from the client that the user started."""
    version, function, shared = _unpacked(work)
    if version != __version__:
        message = f"a worker of the cluster has mbproj {__version__}, and this is {version}"
        raise InputError(Problem(message, hint="install the same version there"))
    return pickle.dumps(function(shared, pickle.loads(item)))


@lru_cache(TASKS_KNOWN)
def _unpacked(work: bytes) -> Any:
    return pickle.loads(work)
