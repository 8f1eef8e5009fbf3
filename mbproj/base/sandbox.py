"""The sandbox: a child process, with little time and memory, which reads an HDF5 file before this process does.

HDF5 trusts what it reads: some damaged files make it spin for ever, take all memory, or crash, and nothing within the
process can stop it. So a child process first does what the reader will do. Where the child does not come to its end,
the reader does not begin. A part that a child has read without fault is not tried again while the file is unchanged.
Files that this process has written itself are not tried at all.

Every limit is in processor time of the child, which does not grow while other processes have the processor.
"""

from __future__ import annotations

import faulthandler
import gc
import json
import math
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from selectors import EVENT_READ, DefaultSelector

from mbproj.base.errors import InputError, Problem

try:
    import resource
except ImportError:  # Windows, which has no fork either
    resource = None  # type: ignore[assignment]

#: The most processor time of the child: SECONDS, and 1 s more for each BYTES_A_SECOND of the file. Where the sum of
#: NUMBERS numbers takes longer than USUAL s on this processor, the time grows in proportion.
SECONDS, BYTES_A_SECOND = 2, 2**28
NUMBERS, USUAL = range(10**4), 1e-3
#: The longest time in s in which the child waits, as for a slow disk or network, and uses no processor time.
PATIENCE = 60.0
#: A file that changed within this time, in s, may change again without a new time of change.
SETTLED = 2.0
#: The most memory that the child may allocate: MEMORY in bytes, and MEMORY_BY_SIZE times the size of the file.
MEMORY, MEMORY_BY_SIZE = 2**30, 4

ENDLESS = "reading it does not come to an end"
#: The fault of the file, by the signal that ended the child. The child kills itself where memory runs out.
ENDS: dict[int, str] = {signal.SIGXCPU: ENDLESS, signal.SIGKILL: "reading it takes too much memory"} if resource else {}

#: What was tried without fault: the name of the act, and the state of the file.
_passed: set[tuple[object, ...]] = set()
#: The files of this process by device and inode: their state when they were finished; None for one that it writes.
_written: dict[tuple[int, int], tuple[int, ...] | None] = {}


def trust(descriptor: int, *, growing: bool = False) -> None:
    """Read the open file, which this process has written, without a child until somebody changes it. While it is
    `growing` no child may read it: to close it there, HDF5 would write what it has of the file in memory."""
    about = os.fstat(descriptor)
    _written[about.st_dev, about.st_ino] = None if growing else _state(about)


def distrust(descriptor: int) -> None:
    """Let a child read the open file first, like any other."""
    about = os.fstat(descriptor)
    _written.pop((about.st_dev, about.st_ino), None)


def is_growing(path: Path) -> bool:
    """Whether this process is writing the file at `path`. May raise OSError."""
    about = path.stat()
    return _written.get((about.st_dev, about.st_ino), ()) is None


def _state(about: os.stat_result) -> tuple[int, ...]:
    return about.st_size, about.st_mtime_ns, about.st_ctime_ns


def try_in_sandbox(act: Callable[[], object], path: Path, name: str = "") -> bool:
    """Call `act`, which reads the file at `path`, in a child process. Return whether that is done, or not needed. An
    act with a `name` is tried once for each state of the file; acts that read the same parts have the same name.

    Raises the InputError that `act` raises. Raises one that says the file is damaged where the child does not come to
    its end within the limits. Where a process cannot be forked (Windows) only files of this process are known as good.
    """
    about = path.stat()
    which, state = (about.st_dev, about.st_ino), _state(about)
    tried = (name, which, state)
    if tried in _passed or (which in _written and _written[which] in (None, state)):
        return True
    if resource is None or not hasattr(os, "fork"):
        return False
    is_settled = time.time_ns() - max(state[1:]) > SETTLED * 1e9
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        _perform(act, about.st_size, reading, writing)
    os.close(writing)
    try:
        said, in_time = _listen(reading, child)
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
    if name and is_settled:
        _passed.add(tried)
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
    except BaseException:  # a fault of mbproj, or Ctrl-C: it occurs again in the parent, which reports it
        pass
    finally:
        with os.fdopen(writing, "wb") as pipe:
            pipe.write(said)
        os._exit(0)


def _limit(size: int) -> None:
    """Limit the processor time and the memory of this process, and let it write no core file."""
    start = time.process_time()
    sum(NUMBERS)
    end = time.process_time()
    seconds = (SECONDS + size / BYTES_A_SECOND) * max(1.0, (end - start) / USUAL)
    _lower(resource.RLIMIT_CPU, math.ceil(end + seconds))
    _lower(resource.RLIMIT_CORE, 0)
    if sys.platform == "linux":
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        _lower(resource.RLIMIT_AS, pages * resource.getpagesize() + MEMORY + MEMORY_BY_SIZE * size)


def _lower(kind: int, limit: int) -> None:
    soft, hard = resource.getrlimit(kind)
    ceilings = [value for value in (soft, hard, limit) if value != resource.RLIM_INFINITY]
    resource.setrlimit(kind, (min(ceilings), hard))


def _listen(descriptor: int, child: int) -> tuple[bytes, bool]:
    """Return the bytes that the child writes to the pipe, and whether it ended in time. A pause of this process
    (Ctrl-Z) counts as a single part of the child's waiting time."""
    said, used, parts, waited = b"", 0.0, 20, 0
    with DefaultSelector() as selector:
        selector.register(descriptor, EVENT_READ)
        while waited < parts:
            if selector.select(PATIENCE / parts):
                part = os.read(descriptor, 2**16)
                if not part:
                    return said, True
                said += part
                continue
            before, used = used, _processor_time(child)
            waited = waited + 1 if used <= before else 0
    return said, False


def _processor_time(child: int) -> float:
    """The processor time of a process in s; always 0 where the system does not tell it."""
    if sys.platform != "linux":
        return 0.0
    return time.clock_gettime(~child << 3 | 2)  # the number of a process's clock, as clock_getcpuclockid(3) gives it


def _damaged(path: Path, what: str) -> InputError:
    return InputError(Problem(f"'{path}' is damaged: {what}", hint="repeat the run"))


def _judge(said: bytes, status: int, path: Path) -> None:
    """Raise the problems that the child found, or the one that its end by a signal shows."""
    if os.WIFSIGNALED(status):
        raise _damaged(path, ENDS.get(os.WTERMSIG(status), "HDF5 crashes on it"))
    problems = [Problem(message, hint=hint) for message, hint in json.loads(said)]
    if problems:
        raise InputError(problems)
