"""Workers: processes with one BLAS thread each, to which a function and its arguments are sent.

They run a program of their own (`mbproj.studies.parallel.worker`). So a script or a notebook that starts a study needs
no guard of its main module. Nor do numbers depend on what the caller's process has loaded. Workers use the caller's
mbproj, package and kernel, whatever the current folder holds. Tasks and results are pickled through pipes between the
two processes, which nobody else can write to. No file is ever unpickled.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Event, Timer
from typing import Any

from mbproj.studies.parallel.worker import READY

#: One BLAS thread: matrices are small, and each process has a processor of its own.
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
#: The program of a worker. Its arguments are the folder of the caller's package and the caller's `sys.path`. `python
#: -m` would look for mbproj in the current folder first. Other modules are found as the caller finds them.
PROGRAM = (
    "import sys; sys.path[:] = sys.argv[1:]; import mbproj; del sys.path[0]; "
    "from mbproj.studies.parallel.worker import main; main()"
)
#: Options of the interpreter that decide what it reads when it starts, by their names in `sys.flags`.
FLAGS = {"isolated": "-I", "ignore_environment": "-E", "no_user_site": "-s", "no_site": "-S"}


#: The beginning of the message of a WorkerLost whose time was up.
OVERDUE = "stopped: it took longer than"


class WorkerLost(RuntimeError):
    """The error for a process that died, or was stopped because its time was up; the message tells which."""


class Worker:
    """A process that answers one item after another."""

    def __init__(self, function: Callable[[Any, Any], Any], shared: Any, notes: deque[str]) -> None:
        """Start the process. mbproj's warnings in it are added to `notes`."""
        self._task, self._notes = (function, shared), notes
        self._stopped = False
        self.start()

    def start(self) -> None:
        """Start a new process, in place of one that was lost."""
        if self._stopped:
            return
        flags = [option for name, option in FLAGS.items() if getattr(sys.flags, name)]
        package = Path(__file__).absolute().parents[3]
        self.process = subprocess.Popen(
            [sys.executable, *flags, "-c", PROGRAM, str(package), *map(str, sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **THREADS},
            start_new_session=True,  # Ctrl-C goes to the study only, which then stops its workers
        )
        self._send(self._task)
        self._ready = False

    def _send(self, message: Any) -> None:
        assert self.process.stdin is not None
        pickle.dump(message, self.process.stdin)
        self.process.stdin.flush()

    def ask(self, item: Any, timeout: float | None = None) -> Any:
        """The result for an item. Raises what the function raised, or WorkerLost."""
        assert self.process.stdout is not None
        overdue = Event()

        def end() -> None:
            overdue.set()
            self.process.kill()

        clock = Timer(timeout or 0.0, end)
        try:
            if not self._ready:
                self._ready = pickle.load(self.process.stdout) == READY
            if timeout is not None:
                clock.start()
            self._send(item)
            result, error, notes = pickle.load(self.process.stdout)
        except (EOFError, OSError, pickle.UnpicklingError) as broken:
            code = self.process.wait()
            if overdue.is_set():
                raise WorkerLost(f"{OVERDUE} {timeout:g} s") from broken
            raise WorkerLost(f"its process ended with code {code}: killed, or out of memory?") from broken
        finally:
            clock.cancel()
        self._notes.extend(notes)
        if error is not None:
            raise error
        return result

    def stop(self) -> None:
        """Kill the process, also while it works."""
        self._stopped = True
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                with suppress(OSError):  # the process no longer reads what was being sent
                    pipe.close()
