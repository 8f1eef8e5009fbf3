"""A command of mbproj in a child of this process, with limits of time and memory.

The child is forked from a process that has imported all that commands need: a thousand commands do not import it
a thousand times.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from mbproj.commands.main import COMMANDS, main

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = "from mbproj.commands.main import main; main()"
#: Exit codes that a file from elsewhere may lead to; 1 is a fault of ours.
ALLOWED = (0, 2, 3, 4)
#: What commands import when they are used.
IMPORTED = (
    "mbproj.studies.verify",
    "mbproj.show.figures.style",
    "mbproj.show.figures.panels",
    "mbproj.results.analysis.comparison",
    "mbproj.motion",
    "matplotlib.backends.backend_agg",
)


@dataclass(frozen=True)
class Ending:
    """How a command ended: exit code (negative: a signal), processor seconds, and what it said to stderr."""

    code: int
    seconds: float
    said: str

    @property
    def fault(self) -> str | None:
        """What no file may lead to."""
        if "Traceback" in self.said:
            return "traceback"
        if "Warning" in self.said:
            return "warning"
        if self.code == -signal.SIGXCPU:
            return "does not end"
        if self.code == -signal.SIGALRM:
            return "hangs"
        return None if self.code in ALLOWED else f"exit code {self.code}"


def warm_up() -> None:
    """Imports what the children will need."""
    for name in (*(f"mbproj.commands.{command.replace('-', '_')}" for command in COMMANDS), *IMPORTED):
        import_module(name)


def watched(arguments: Sequence[str], folder: Path, seconds: int, memory: int) -> Ending:
    """Runs `mbproj ARGUMENTS` in `folder` with so many processor seconds, ten times as many of waiting, and so many
    bytes more than this process has."""
    said = folder.parent / "stderr"
    child = os.fork()
    if child == 0:
        _run(arguments, folder, said, seconds, memory)
    _, status, used = os.wait4(child, 0)
    code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
    return Ending(code, used.ru_utime + used.ru_stime, said.read_text(encoding="utf-8", errors="replace"))


def _run(arguments: Sequence[str], folder: Path, said: Path, seconds: int, memory: int) -> None:
    """The child."""
    try:
        os.chdir(folder)
        os.dup2(os.open(os.devnull, os.O_RDWR), 0)
        os.dup2(os.open(os.devnull, os.O_RDWR), 1)
        os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), 2)
        os.environ.update({"MBPROJ_CACHE": str(folder / "cache"), "NO_COLOR": "1"})
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + memory
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.alarm(10 * seconds)
        sys.argv = ["mbproj", *arguments]
        main()
    except SystemExit as end:
        sys.stderr.flush()
        os._exit(int(end.code or 0))
    finally:
        os._exit(99)
