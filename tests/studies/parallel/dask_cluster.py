"""A Dask cluster of separate processes on the loopback: a scheduler, and workers with their nannies."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support import ROOT

#: One lost worker is enough to say so: what was on it is tried again alone.
SETTINGS = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0", "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}


class Running:
    """The processes of a cluster."""

    def __init__(self, folder: Path, workers: int) -> None:
        self.file = folder / "scheduler.json"
        self._processes = [self._start("scheduler", "--port", "0", "--scheduler-file", str(self.file))]
        wait_until(lambda: self.file.exists() and self.file.read_text().endswith("}"))
        for _ in range(workers):
            self._processes.append(self._start("worker", self.address, "--nthreads", "1"))

    @property
    def address(self) -> str:
        return json.loads(self.file.read_text())["address"]

    def _start(self, what: str, *options: str) -> subprocess.Popen[bytes]:
        environment = {**os.environ, **SETTINGS}
        environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        program = [sys.executable, "-m", "dask", what, "--host", "127.0.0.1", "--no-dashboard", *options]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(program, env=environment, start_new_session=True, **quiet)

    def kill_scheduler(self) -> None:
        self._processes[0].send_signal(signal.SIGKILL)
        self._processes[0].wait()

    def stop(self) -> None:
        """Ends all, the workers' own processes too."""
        for process in self._processes:
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
            process.wait()


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[Running]:
    running = Running(folder, workers)
    try:
        yield running
    finally:
        running.stop()


def wait_until(holds, seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)
