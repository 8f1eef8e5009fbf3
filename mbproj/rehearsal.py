"""An HDF5 file is read in a child process first, where time and memory are limited.

HDF5 trusts what it reads: some damaged files make it spin for ever, take all memory, or crash, and nothing within the
process can stop it. So what a reader is about to do is done once in a child; where that does not come to an end the
reader does not begin.
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

#: A rehearsal takes some 10 ms. Processor time in s, and what a file adds to it by its size in bytes a second.
SECONDS, BYTES_A_SECOND = 2, 2**28
#: Waiting included: for a disk or a network that answers slowly.
PATIENCE = 60.0
#: What the child may allocate, in bytes, and by how many times the size of the file more.
MEMORY, MEMORY_BY_SIZE = 2**30, 4

ENDLESS = "reading it does not come to an end"
#: What the signal that ended the child says of the file. It kills itself where there is not enough memory.
ENDS: dict[int, str] = {signal.SIGXCPU: ENDLESS, signal.SIGKILL: "reading it takes too much memory"} if resource else {}


def rehearse(act: Callable[[], object], path: Path) -> bool:
    """Do `act`, which reads the file at `path`, in a child process; whether that was done.

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
    """The child: limits, the act, what it says; and no exit handlers of the parent."""
    said = b"[]"
    try:
        gc.disable()  # what the parent has dropped is the parent's to close
        faulthandler.disable()
        warnings.simplefilter("ignore")  # the parent says it
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
    """Limits for this process: processor time, memory, no core file."""
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
    """What the child says until it ends, and whether it did so within `patience` in s."""
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
    """Raises what the child found, or what its end says of the file."""
    if os.WIFSIGNALED(status):
        raise _damaged(path, ENDS.get(os.WTERMSIG(status), "HDF5 crashes on it"))
    problems = [Problem(message, hint=hint) for message, hint in json.loads(said)]
    if problems:
        raise InputError(problems)
