"""Errors as values: each has a place or a time, a cause and a next step, and an exit code for the command line.

The next step is often the name that was meant: `did_you_mean`, `choose_from`.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from enum import IntEnum
from functools import cache
from itertools import islice
from pathlib import Path
from warnings import warn

from mbproj.base.dataclass import dataclass


class ExitCode(IntEnum):
    """The codes that the command `mbproj` returns to the shell."""

    DONE = 0
    INTERNAL = 1
    BAD_INPUT = 2
    FAILED = 3
    CHECK_FAILED = 4
    INTERRUPTED = 130


#: The most characters of a line that a message shows before the column, and after it.
CONTEXT = 120


@dataclass(frozen=True)
class Place:
    """The place of a value: file (or option), line and column (both from 1), and the text of that line."""

    file: str
    line: int | None = None
    column: int | None = None
    text: str | None = None

    def __str__(self) -> str:
        return ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)


@dataclass(frozen=True)
class Problem:
    """A fault of the input, or a note on it: a message, its place, and a hint what to try. `key` is the path of the
    value, such as ("simulation", "step"), where only the reader of the scene knows the place."""

    message: str
    place: Place | None = None
    hint: str | None = None
    key: tuple[str, ...] = ()

    def line(self, kind: str = "error") -> str:
        """The text `file:line:column: error: message; hint`. A "note" is on legal input that may be a mistake."""
        prefix = f"{self.place}: " if self.place else ""
        return f"{prefix}{kind}: {self.message}" + (f"; {self.hint}" if self.hint else "")

    def __str__(self) -> str:
        """Return the line of an error, then the line of the user's text with a caret below the column."""
        head = self.line()
        if self.place is None or self.place.text is None or self.place.column is None:
            return head
        at = self.place.column - 1
        before, after = self.place.text[max(0, at - CONTEXT) : at], self.place.text[at : at + CONTEXT]
        indent = "".join("\t" if character == "\t" else " " for character in before)
        return f"{head}\n    {before}{after}\n    {indent}^"


class MbprojError(Exception):
    """The base class of all errors that the user can mend; `exit_code` is for the shell."""

    exit_code = ExitCode.INTERNAL


class InputError(MbprojError):
    """The error of a wrong input, with every problem that was found, in the order of the text."""

    exit_code = ExitCode.BAD_INPUT

    def __init__(self, problems: Sequence[Problem] | Problem | str) -> None:
        if isinstance(problems, str):
            problems = Problem(problems)
        self.problems: tuple[Problem, ...] = (problems,) if isinstance(problems, Problem) else tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


class SimulationError(MbprojError):
    """The simulation cannot go on: the time in s, the cause, where ("joint 'A'") if it has a place, what to try.
    `formulation` is the one that ran, where `simulate` has begun; `output` is the results file with the samples until
    then, where there is one."""

    exit_code = ExitCode.FAILED

    def __init__(self, time: float, cause: str, *, where: str | None = None, hint: str | None = None) -> None:
        self.time, self.cause, self.where, self.hint = time, cause, where, hint
        self.formulation: str | None = None
        self.output: Path | None = None
        place = f" at {where}" if where else ""
        super().__init__(f"stopped at t = {time:.6g} s{place}: {cause}" + (f"; {hint}" if hint else ""))


class MbprojWarning(UserWarning):
    """A warning that a user should read, but that stops nothing; the command line shows it as a note."""


@cache
def warn_once(text: str) -> None:
    """Warn with an `MbprojWarning`, once a process for each text."""
    warn(text, MbprojWarning, stacklevel=2)


def warn_caller(text: str) -> None:
    """Warn with an `MbprojWarning` at the line outside mbproj that called one of its functions."""
    depth, frame = 2, sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "mbproj":
        depth, frame = depth + 1, frame.f_back
    warn(text, MbprojWarning, stacklevel=depth)


@contextmanager
def placed_at(place: Place | None) -> Iterator[None]:
    """Give `place` to those problems raised in this block that have none: checks of settings know no file."""
    try:
        yield
    except InputError as error:
        placed = [problem if problem.place else replace(problem, place=place) for problem in error.problems]
        raise InputError(placed) from error


#: The most names among which one is suggested: a generated scene may have thousands of wrong names.
MAX_NAMES = 300


def did_you_mean(word: str, names: Iterable[str]) -> str | None:
    """A hint with the name that is closest to `word`, whatever its case; None where none is close."""
    import difflib

    few = list(islice(names, MAX_NAMES + 1))
    if len(few) > MAX_NAMES or len(word) > 200:
        return None
    by_folded = {name.casefold(): name for name in few}
    close = difflib.get_close_matches(word.casefold(), by_folded, n=1, cutoff=0.7)
    return f"did you mean '{by_folded[close[0]]}'?" if close else None


def choose_from(word: str, names: Iterable[str], what: str = "choose from") -> str:
    """A hint with the closest of `names`, or else a list of the first twenty."""
    few = list(islice(names, MAX_NAMES + 1))  # a scene may have thousands of wrong words, and of names for each
    shown = ", ".join(few[:20]) + (", ..." if len(few) > 20 else "")
    return did_you_mean(word, few) or (f"{what}: {shown}" if few else "there is none")


def shortened(words: Sequence[str], most: int) -> str:
    """The first `most` words, and the number of the others."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return ", ".join(words[:most]) + more


#: Errors of the operating system on a path that the user gave, which the user can mend.
WRONG_PATH = frozenset({
    errno.ENOENT, errno.EACCES, errno.EPERM, errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR, errno.EISDIR, errno.EROFS,
    errno.EEXIST, errno.ENXIO, errno.ENODEV, errno.ENOTEMPTY, errno.EXDEV,
})  # fmt: skip
#: Errors of the operating system where it is out of space, memory or open files, or where a device fails.
NO_MORE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.ENOMEM, errno.EMFILE, errno.ENFILE,
                     errno.EAGAIN})  # fmt: skip
OUR_FAULT = "error: this is a fault of mbproj, not of your input; please report it with the lines above"


def message_and_code(error: Exception) -> tuple[str, ExitCode]:
    """Return the message and the exit code for an exception that nobody caught. An exception that neither the input nor
    the state of the machine explains is a fault of mbproj. Its message has the traceback, for a report."""
    if isinstance(error, InputError):
        return str(error), error.exit_code
    if isinstance(error, MbprojError):
        return f"error: {error}", error.exit_code
    if isinstance(error, MemoryError):
        return "error: out of memory; record less (a longer --output-step), or use a larger machine", ExitCode.FAILED
    if isinstance(error, OSError) and error.errno in NO_MORE:
        return f"error: {_refused(error)}; make room, or use another place", ExitCode.FAILED
    if isinstance(error, OSError) and error.errno in WRONG_PATH and error.filename is not None:
        return f"error: {_refused(error)}; give another path", ExitCode.BAD_INPUT
    import traceback  # for the faults of ours alone

    return f"{''.join(traceback.format_exception(error))}{OUR_FAULT}", ExitCode.INTERNAL


def _refused(error: OSError) -> str:
    where = "" if error.filename is None else f"'{error.filename}': "
    return f"{where}{error.strerror}"
