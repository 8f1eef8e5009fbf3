"""Many runs at once: processes of one BLAS thread each, to which a function and its arguments are sent.

They are started as programs of their own (`python -m mbproj.studies.worker`), so that a script or a notebook that
starts a study needs no guard of its main module, and numbers do not depend on what the caller's process has loaded.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

#: One BLAS thread: matrices are small, and each process has a processor of its own.
_THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def processors() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_parallel(
    function: Callable[[Any, Item], Result], shared: Any, items: Sequence[Item], processes: int | None = None
) -> Iterator[tuple[int, Result]]:
    """(index, function(shared, item)) for every item, in the order in which they come to an end.

    `function` is a module's own; `shared` is sent to each process once. Where one process is enough everything happens
    in this one. Leaving the iterator early, by Ctrl-C for example, ends the processes.
    """
    count = min(processes or processors(), len(items))
    if count <= 1:
        for index, item in enumerate(items):
            yield index, function(shared, item)
        return
    workers = [_Worker(function, shared) for _ in range(count)]
    idle: SimpleQueue[_Worker] = SimpleQueue()
    for worker in workers:
        idle.put(worker)

    def run(item: Item) -> Result:
        worker = idle.get()
        try:
            return worker.ask(item)
        finally:
            idle.put(worker)

    pool = ThreadPoolExecutor(count)
    try:
        waiting: dict[Future[Result], int] = {pool.submit(run, item): index for index, item in enumerate(items)}
        while waiting:
            for done in wait(waiting, return_when=FIRST_COMPLETED).done:
                yield waiting.pop(done), done.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.stop()


class _Worker:
    """A process that answers one item after another."""

    def __init__(self, function: Callable[[Any, Any], Any], shared: Any) -> None:
        package = str(Path(__file__).parents[2])
        path = os.pathsep.join([package, *filter(None, [os.environ.get("PYTHONPATH")])])
        self._process = subprocess.Popen(
            [sys.executable, "-m", "mbproj.studies.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **_THREADS, "PYTHONPATH": path},
            start_new_session=True,  # Ctrl-C is for the study, which then stops its workers
        )
        self._send((function, shared))

    def _send(self, message: Any) -> None:
        assert self._process.stdin is not None
        pickle.dump(message, self._process.stdin)
        self._process.stdin.flush()

    def ask(self, item: Any) -> Any:
        """The result for an item. Raises what the function raised."""
        assert self._process.stdout is not None
        try:
            self._send(item)
            result, error = pickle.load(self._process.stdout)
        except (EOFError, OSError) as broken:
            raise RuntimeError(f"a process of the study has died (exit code {self._process.poll()})") from broken
        if error is not None:
            raise error
        return result

    def stop(self) -> None:
        """Ends the process, whatever it does."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):  # what was being sent has nobody to go to
                    pipe.close()
