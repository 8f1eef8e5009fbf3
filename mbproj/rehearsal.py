"""An HDF5 file is read in a child process first, where time and memory are limited.

HDF5 trusts what it reads: some damaged files make it spin for ever, take all memory, or crash, and nothing within the
process can stop it. So a child process does once what the reader is about to do. Where the child does not come to its
end, the reader does not begin.
"""

from __future__ import annotations

import faulthandler
import gc
import json
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from selectors import EVENT_READ, DefaultSelector

from mbproj.errors import InputError, Problem

try:
    import resource
except ImportError:  # Windows, which has no fork either
    resource = None  # type: ignore[assignment]

#: The most processor time of the child: SECONDS, and 1 s more for each BYTES_A_SECOND of the file. It takes some 10 ms.
SECONDS, BYTES_A_SECOND = 2, 2**28
#: The longest time in s by the clock, which includes waiting for a slow disk or network.
PATIENCE = 60.0
#: The most memory that the child may allocate: MEMORY in bytes, and MEMORY_BY_SIZE times the size of the file.
MEMORY, MEMORY_BY_SIZE = 2**30, 4

ENDLESS = "reading it does not come to an end"
#: What is wrong with the file, by the signal that ended the child. It kills itself where memory runs out.
ENDS: dict[int, str] = {signal.SIGXCPU: ENDLESS, signal.SIGKILL: "reading it takes too much memory"} if resource else {}


def rehearse(act: Callable[[], object], path: Path) -> bool:
    """Call `act`, which reads the file at `path`, in a child process; return whether that was done.

    Raises the InputError that `act` raises. Raises one that says the file is damaged where the child does not come to
    its end within the limits. Where a process cannot be forked (Windows) nothing is done.
    """
    if resource is None or not hasattr(os, "fork"):
        return False
    size = path.stat().st_size
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        _perform(act, size, reading, writing)
    os.close(writing)
    try:
        said, in_time = _listen(reading, PATIENCE + size / BYTES_A_SECOND)
    except BaseException:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        raise
    finally:
        os.close(reading)
    if not in_time:
        os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    if not in_time:
        raise _damaged(path, ENDLESS)
    _judge(said, status, path)
    return True


def _perform(act: Callable[[], object], size: int, reading: int, writing: int) -> None:
    """Run in the child: set the limits, call `act`, write its problems to the pipe, and leave without the parent's exit
    handlers."""
    said = b"[]"
    try:
        gc.disable()  # objects that the parent has dropped are closed by the parent
        faulthandler.disable()
        warnings.simplefilter("ignore")  # the parent shows the same warnings
        os.close(reading)
        _limit(size)
        act()
    except InputError as error:
        said = json.dumps([[problem.message, problem.hint] for problem in error.problems]).encode()
    except MemoryError:
        os.kill(os.getpid(), signal.SIGKILL)
    except BaseException:  # a fault of ours, or Ctrl-C: the parent meets it again and says so
        pass
    finally:
        with os.fdopen(writing, "wb") as pipe:
            pipe.write(said)
        os._exit(0)


def _limit(size: int) -> None:
    """Limit the processor time and the memory of this process, and let it write no core file."""
    seconds = SECONDS + size // BYTES_A_SECOND
    _lower(resource.RLIMIT_CPU, seconds)
    _lower(resource.RLIMIT_CORE, 0)
    if sys.platform == "linux":
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        _lower(resource.RLIMIT_AS, pages * resource.getpagesize() + MEMORY + MEMORY_BY_SIZE * size)


def _lower(kind: int, limit: int) -> None:
    soft, hard = resource.getrlimit(kind)
    ceilings = [value for value in (soft, hard, limit) if value != resource.RLIM_INFINITY]
    resource.setrlimit(kind, (min(ceilings), hard))


def _listen(descriptor: int, patience: float) -> tuple[bytes, bool]:
    """Return what the child writes to the pipe until it ends, and whether it ended within `patience` in s."""
    said, end = b"", time.monotonic() + patience
    with DefaultSelector() as selector:
        selector.register(descriptor, EVENT_READ)
        while selector.select(max(0.0, end - time.monotonic())):
            part = os.read(descriptor, 2**16)
            if not part:
                return said, True
            said += part
    return said, False


def _damaged(path: Path, what: str) -> InputError:
    return InputError(Problem(f"'{path}' is damaged: {what}", hint="repeat the run"))


def _judge(said: bytes, status: int, path: Path) -> None:
    """Raise the problems that the child found, or the one that its end by a signal shows."""
    if os.WIFSIGNALED(status):
        raise _damaged(path, ENDS.get(os.WTERMSIG(status), "HDF5 crashes on it"))
    problems = [Problem(message, hint=hint) for message, hint in json.loads(said)]
    if problems:
        raise InputError(problems)
