"""Processes that run scenes in parallel; one that hangs or dies is replaced, and its scene is said to have failed."""

from __future__ import annotations

import multiprocessing
import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import inf
from multiprocessing.connection import wait
from time import monotonic

from mbproj.errors import ExitCode
from mbproj.integrate.interruption import interruption
from mbproj.results.files import part_path
from mbproj.studies.batch.result import SceneResult, Task
from mbproj.studies.batch.worker import work

#: How often Ctrl-C and scenes whose time is up are looked for, s.
LOOK = 0.1
#: What sets the number of threads of a BLAS: several processes with several threads each would disturb each other.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def run_batch(tasks: Sequence[Task], jobs: int, timeout: float, done: Callable[[int, SceneResult], None]) -> None:
    """Runs all tasks, `jobs` at a time, and calls `done` with the number of each and its result as it ends.

    A scene that takes longer than `timeout` in s is stopped. Raises KeyboardInterrupt after SIGINT or SIGTERM. No
    process is left behind.
    """
    waiting = deque(enumerate(tasks))
    workers: list[_Worker] = []
    left = len(tasks)
    try:
        with interruption() as asked:
            while left:
                while len(workers) < min(jobs, left):
                    workers.append(_Worker())
                asked.check()
                ready = wait([worker.connection for worker in workers], LOOK)
                for worker in workers:
                    number, result = worker.number, worker.heard(worker.connection in ready)
                    if result is not None:
                        done(number, result)
                        left -= 1
                    if worker.idle and waiting:
                        worker.give(*waiting.popleft(), timeout)
                for worker in [worker for worker in workers if worker.gone]:
                    worker.stop()
                    workers.remove(worker)
    finally:
        for worker in workers:
            worker.stop()


class _Worker:
    """A process, the task that it is at, and when that has to be done."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=work, args=(theirs,), daemon=True)
        with _one_thread():
            self.process.start()
        theirs.close()
        self.number, self.task = -1, None
        self.idle = self.gone = False
        self.begun, self.timeout = monotonic(), inf

    number: int
    task: Task | None

    def give(self, number: int, task: Task, timeout: float) -> None:
        """Hand over a task and its number; it may take `timeout` seconds."""
        self.number, self.task, self.idle = number, task, False
        self.begun, self.timeout = monotonic(), timeout
        self.connection.send(task)

    def heard(self, speaks: bool) -> SceneResult | None:
        """The result of the task, if it is there: as the process says, or because that died or its time is up."""
        if not speaks:
            overdue = self.task is not None and monotonic() - self.begun > self.timeout
            return self._lost(f"stopped: it took longer than {self.timeout:g} s") if overdue else None
        try:
            result: SceneResult | None = self.connection.recv()
        except (EOFError, OSError):
            self.process.join()
            if self.task is None:
                raise RuntimeError(f"a process for scenes ended with code {self.process.exitcode}") from None
            return self._lost(f"its process ended with code {self.process.exitcode}: killed, or out of memory?")
        self.idle, self.task = True, None
        return result

    def stop(self) -> None:
        """End the process, whatever it does."""
        self.process.kill()
        self.process.join()
        self.connection.close()

    def _lost(self, message: str) -> SceneResult:
        """The result of the task that it will not get done; what was recorded so far can be read."""
        assert self.task is not None
        self.gone = True
        self.process.kill()
        self.process.join()
        part = part_path(self.task.output)
        kept = part if self.task.keep and part.exists() else None
        if kept is not None:
            message += f"; what it has recorded is in '{kept}'"
        return SceneResult(self.task.scene, ExitCode.FAILED, message, (), monotonic() - self.begun, kept)


@contextmanager
def _one_thread() -> Iterator[None]:
    """What is started in it has a BLAS of one thread."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
