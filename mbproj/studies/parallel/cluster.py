"""Work on a running Dask cluster, whose workers have mbproj installed.

Only a few tasks are out at a time. Dask blames a lost worker on all tasks that it had. Here only an item that was out
alone is blamed. The results that are lost with a scheduler are in the caller's store.
"""

from __future__ import annotations

import asyncio
import json
import logging
import pickle
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeVar

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, InputError, MbprojError, Place, Problem
from mbproj.base.version import __version__
from mbproj.motion.interruption import interruption
from mbproj.studies.parallel.workers import OVERDUE

if TYPE_CHECKING:
    from distributed import Client, Future


# --- A client of a running Dask cluster, and the errors where there is none -------------------------------------------


#: Time for a scheduler to answer, s.
CONNECT = 6.0
#: The exceptions of Dask where nobody answers, or the scheduler ends during a call: they vary.
UNREACHABLE = (Exception, asyncio.CancelledError)


@dataclass(frozen=True)
class Cluster:
    """A running cluster: the address of its scheduler, or the file in which the scheduler wrote it."""

    address: str = ""
    file: Path | None = None

    def __str__(self) -> str:
        return self.address if self.file is None else str(self.file)

    @property
    def option(self) -> str:
        """The option of the command line that names the cluster."""
        return "--scheduler" if self.file is None else "--scheduler-file"


class ClusterLost(MbprojError):
    """The error where the scheduler has gone, or has no workers."""

    exit_code = ExitCode.FAILED


@contextmanager
def connected(cluster: Cluster) -> Iterator[Client]:
    """A client of the cluster. Raises InputError, at the option, where there is none."""
    place = Place(cluster.option)
    try:
        from distributed import Client
    except ImportError:
        problem = Problem("this needs the packages of Dask", place, "install them: pip install 'mbproj[cluster]'")
        raise InputError(problem) from None
    address = cluster.address if cluster.file is None else _address_in(cluster.file, place)
    _silence()
    try:
        client = Client(address, timeout=CONNECT, set_as_default=False)
    except UNREACHABLE as error:
        hint = "start one with 'dask scheduler', or say where it is: tcp://host:8786"
        raise InputError(Problem(f"there is no scheduler at '{address}'", place, hint)) from error
    try:
        yield client
    finally:
        with suppress(*UNREACHABLE):
            client.close(timeout=1.0)


def _silence() -> None:
    """Silence Dask's own messages in this process: mbproj reports what concerns the user."""
    for name in list(logging.root.manager.loggerDict):
        if name.split(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _address_in(file: Path, place: Place) -> str:
    """The address that a scheduler has written into a file."""
    try:
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        if isinstance(address, str):
            return address
    except OSError as error:
        hint = f"the scheduler writes it: dask scheduler --scheduler-file {file}"
        raise InputError(Problem(f"cannot read '{file}': {error.strerror}", place, hint)) from error
    except (ValueError, KeyError, TypeError):
        pass
    raise InputError(Problem(f"'{file}' is not a file of a Dask scheduler", place))


def workplace(jobs: int | Cluster | None, scheduler: str | None, scheduler_file: Path | None) -> int | Cluster | None:
    """The place where the work is done: a number of processes, or a cluster. Raises InputError where two are given, or
    the cluster cannot be reached."""
    options = [name for name, value in (("--jobs", jobs), ("--scheduler", scheduler)) if value is not None]
    options += [] if scheduler_file is None else ["--scheduler-file"]
    if len(options) > 1:
        what = f"'{options[0]}' and '{options[1]}' exclude each other"
        raise InputError(Problem(what, Place(options[1]), "a cluster has its own workers"))
    if scheduler is None and scheduler_file is None:
        return jobs
    cluster = Cluster(scheduler or "", scheduler_file)
    with connected(cluster):  # raises before the work begins
        return cluster


# --- Work on a running Dask cluster, whose workers have mbproj installed ----------------------------------------------


Item = TypeVar("Item")
Result = TypeVar("Result")

#: Time for a lost scheduler to come back, s, and time between two checks of the workers, s.
GONE, REFRESH = 5.0, 1.0
#: Time between two checks for Ctrl-C, s.
LOOK = 0.1
#: Tasks that are out for each thread: the one in work, and the next.
AHEAD = 2
#: Time for workers to appear, s, where Dask's setting `distributed.scheduler.no-workers-timeout` has no value.
NO_WORKERS = 60.0
#: How often Dask may give up an item that is not to blame, for example because a lost worker had its result.
GIVEN_UP = 5
#: The number of shared data sets that a worker keeps unpacked.
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
    """Does on a cluster what `in_parallel` does. Raises InputError where the cluster cannot be reached, ClusterLost
    where it ends."""
    with connected(cluster) as client, interruption() as asked:
        out = _Out(client, cluster, pickle.dumps((__version__, function, shared)))
        remaining, suspects, index = iter(items), deque[_Task](), -1
        try:
            while True:
                while out.room > 0 and (item := next(remaining, _NONE)) is not _NONE:
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


#: The end of the items.
_NONE: Any = object()


@dataclass(eq=False)
class _Task:
    """An item that is out. `sent` is when; `limit` is how long it may take (s), or None; `alone` tells that no other
    item is out; `given_up` counts how often Dask gave it up. `begun` is when it was first seen at a worker."""

    index: int
    item: Any
    future: Future
    sent: float
    limit: float | None
    alone: bool
    given_up: int = 0
    begun: float | None = None

    def is_overdue(self, now: float) -> bool:
        """Whether the item should have come back, even if it had to wait for the one before it."""
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
        """The number of tasks that may still be sent."""
        if any(task.alone for task in self.tasks.values()):
            return 0
        return AHEAD * max(self._threads, 1) - len(self.tasks)

    def send(self, index: int, item: Any, limit: float | None, alone: bool = False, given_up: int = 0) -> None:
        """Send an item to the cluster."""
        with self._reaching():
            future = self._client.submit(_call, self._work, pickle.dumps(item), pure=False)
        self.tasks[future.key] = _Task(index, item, future, monotonic(), limit, alone, given_up)
        future.add_done_callback(lambda done: self._back.put(done.key))

    def ended(self) -> Iterator[tuple[_Task, Any, str | None]]:
        """Wait a moment; yield the tasks that have ended, each with its result, or the reason why it was lost."""
        with suppress(Empty):
            task = self.tasks.pop(self._back.get(timeout=LOOK), None)
            if task is not None:  # None where the task was overdue and removed
                yield from self._answered(task)
        if monotonic() - self._looked > REFRESH:
            yield from self._overdue()
            self._refresh()

    def _answered(self, task: _Task) -> Iterator[tuple[_Task, Any, str | None]]:
        """Yield the result of a task, or the reason why it was lost. A task that Dask gave up is sent again."""
        done, result, fault = self._outcome(task.future)
        if done:
            yield task, result, None if fault is None else self._why(fault)
        elif self._client.status == "running" and task.given_up < GIVEN_UP:
            self.send(task.index, task.item, task.limit, task.alone, task.given_up + 1)
        else:
            raise self._lost()

    def _outcome(self, future: Future) -> tuple[bool, Any, BaseException | None]:
        """Return whether the task has ended, its result, and its exception."""
        with self._reaching(), suppress(CancelledError, asyncio.CancelledError):
            if future.status == "finished":
                return True, pickle.loads(future.result()), None
            if future.status == "error":
                return True, None, future.exception()
        return False, None, None

    def _why(self, fault: BaseException) -> str:
        """The reason why a task was lost. Raises an exception other than the end of its worker."""
        from distributed import KilledWorker

        if isinstance(fault, KilledWorker):
            return "its worker was lost: killed, or out of memory?"
        if isinstance(fault, ImportError) and (fault.name or "").startswith("mbproj"):
            problem = Problem("the workers have no mbproj", Place(self._cluster.option), "install it where they run")
            raise InputError(problem) from fault
        raise fault

    @contextmanager
    def _reaching(self) -> Iterator[None]:
        """Raise ClusterLost for any exception in the block with which Dask reports a lost scheduler."""
        try:
            yield
        except UNREACHABLE as error:
            # A connection that breaks is an OSError, and the client may learn of it later.
            lost = isinstance(error, (OSError, CancelledError, asyncio.CancelledError))
            if self._client.status == "running" and not lost:
                raise
            raise self._lost() from error

    def _overdue(self) -> Iterator[tuple[_Task, Any, str | None]]:
        """Restart the workers of overdue tasks, and yield these tasks as lost."""
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
            if late is not None:  # Dask sends this worker's other tasks elsewhere
                del self.tasks[late.future.key]
                late.future.cancel()
                with suppress(*UNREACHABLE):  # the worker has gone already, or has no nanny
                    self._client.restart_workers([address], raise_for_error=False)
                yield late, None, f"{OVERDUE} {late.limit:g} s"

    def _refresh(self) -> None:
        """Count the threads of the workers, and check that the scheduler and some workers are there."""
        now = monotonic()
        threads = self._counted()
        if threads is None:
            if now - self._looked > GONE:
                raise self._lost()
            return
        self._threads, self._looked = threads, now
        if self._threads:
            self._there = now
        elif now - self._there > self._patience:
            message = f"the scheduler at '{self._cluster}' has had no workers for {self._patience:g} s"
            raise ClusterLost(f"{message}; start some with 'dask worker', and go on with the same command")

    def _counted(self) -> int | None:
        """The number of the workers' threads; None where the scheduler does not answer."""
        if self._client.status != "running":
            return None
        try:
            return sum(self._client.nthreads().values())
        except UNREACHABLE:
            return None

    def _lost(self) -> ClusterLost:
        advice = "what was computed is kept: start it again, and go on with the same command"
        return ClusterLost(f"the scheduler at '{self._cluster}' is gone; {advice}")

    def withdraw(self) -> None:
        """Cancel all tasks that are out."""
        if self.tasks and self._client.status == "running":
            with suppress(*UNREACHABLE):
                self._client.cancel([task.future for task in self.tasks.values()])


def _call(work: bytes, item: bytes) -> bytes:
    """Run on a worker: the pickled result of the function for an item. Both come from the client that the user
    started."""
    version, function, shared = _unpacked(work)
    if version != __version__:
        message = f"a worker of the cluster has mbproj {__version__}, and this is {version}"
        raise InputError(Problem(message, hint="install the same version there"))
    return pickle.dumps(function(shared, pickle.loads(item)))


@lru_cache(TASKS_KNOWN)
def _unpacked(work: bytes) -> Any:
    return pickle.loads(work)
