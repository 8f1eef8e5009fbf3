"""One command line in a process of its own, and what is wrong with how it ends."""

from __future__ import annotations

import io
import os
import re
import resource
import signal
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep

#: How long a command may take before it is interrupted, and then to end; s.
LIMIT, TO_END = 20.0, 15.0
MEMORY = 4 * 2**30
#: The exit codes of what a user can cause; 1 is a fault of mbproj.
EXPECTED = {0, 2, 3, 4, 130}
#: What no terminal may get, and what no user should see.
COMMANDS = re.compile(rb"[\x00-\x08\x0b-\x1f\x7f]")
UNSEEMLY = re.compile(rb"Traceback|Warning\b|HDF5-DIAG|Exception ignored|fault of mbproj")


@dataclass(frozen=True)
class Ending:
    """How a command ended: its exit code (negative: the signal that killed it), whether it had to be interrupted, what
    it printed, and what is wrong with that, if anything."""

    code: int
    interrupted: bool
    printed: bytes
    wrong: str = ""


def trial(
    arguments: Sequence[str], folder: Path, encoding: str, stdout: str | None, variables: Mapping[str, str]
) -> Ending:
    """Runs `mbproj ARGUMENTS` in `folder`, in a copy of this process, which has imported what takes time. `stdout`: a
    file for its output in place of one that is read, "closed", or None."""
    log = folder.with_suffix(".log")
    child = os.fork()
    if child == 0:
        _become(arguments, folder, encoding, stdout, log, variables)
    code, interrupted = _awaited(child)
    printed = log.read_bytes()
    return Ending(code, interrupted, printed, _wrong(code, printed))


def _become(
    arguments: Sequence[str], folder: Path, encoding: str, stdout: str | None, log: Path, variables: Mapping[str, str]
) -> None:
    """The child: never returns."""
    code = 99
    try:
        os.setsid()
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND)
        os.dup2(output, 2)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.chdir(folder)
        os.environ.update(variables)
        sys.argv = ["mbproj", *arguments]
        if stdout == "closed":
            os.close(1)
            sys.stdout = None  # as Python finds it
        else:
            os.dup2(output if stdout is None else os.open(stdout, os.O_WRONLY), 1)
            sys.stdout = io.TextIOWrapper(io.FileIO(1, "w"), encoding=encoding)
        sys.stderr = io.TextIOWrapper(io.FileIO(2, "w"), encoding=encoding, errors="backslashreplace")
        from mbproj.commands.main import main

        main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 98
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    finally:
        os._exit(code)


def _awaited(child: int) -> tuple[int, bool]:
    """The exit code of a child, and whether it was interrupted because it took too long."""
    started, interrupted = monotonic(), False
    while True:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            break
        if not interrupted and monotonic() - started > LIMIT:
            os.kill(child, signal.SIGINT)
            interrupted = True
        elif monotonic() - started > LIMIT + TO_END:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return -signal.SIGKILL, True
        sleep(0.01)
    return os.waitstatus_to_exitcode(status), interrupted


def _wrong(code: int, printed: bytes) -> str:
    if code == -signal.SIGKILL:
        return "hangs"
    if code not in EXPECTED:
        return f"exit code {code}"
    unseemly = UNSEEMLY.search(printed)
    if unseemly is not None:
        return f"prints '{unseemly[0].decode()}'"
    command = COMMANDS.search(printed)
    return f"prints the control character {command[0]!r}" if command else ""
