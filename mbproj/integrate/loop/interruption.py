"""Ctrl-C, SIGTERM, and the end of the time that a run may take: noticed between steps, so that what was computed is
kept."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import monotonic
from types import FrameType
from typing import Any

from mbproj.errors import MbprojError


class TimeIsUp(MbprojError):
    """A run has taken longer than it may."""


#: When runs of this thread have to stop, by the monotonic clock in s.
_deadline: ContextVar[float | None] = ContextVar("deadline", default=None)


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Runs in the block raise TimeIsUp after so many s, together; None: they take what they take."""
    token = _deadline.set(None if seconds is None else monotonic() + seconds)
    try:
        yield
    finally:
        _deadline.reset(token)


class Interruption:
    """Whether somebody asked the run to stop, or its time is up."""

    def __init__(self) -> None:
        self.requested = False
        self._deadline = _deadline.get()

    def check(self) -> None:
        """Raises KeyboardInterrupt, or TimeIsUp, if so."""
        if self.requested:
            raise KeyboardInterrupt
        if self._deadline is not None and monotonic() > self._deadline:
            raise TimeIsUp

    def request(self, signum: int, frame: FrameType | None) -> None:
        """A signal handler: the first signal asks the run to stop, a second one stops at once."""
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True


#: That of the run that goes on in this thread.
_current: ContextVar[Interruption | None] = ContextVar("current", default=None)


def look() -> None:
    """Between two steps: raises what `Interruption.check` raises."""
    current = _current.get()
    if current is not None:
        current.check()


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Turns SIGINT and SIGTERM into a request while the block runs (in the main thread; elsewhere only `time_limit`
    counts)."""
    asked = Interruption()
    token = _current.set(asked)
    try:
        with _signals(asked):
            yield asked
    finally:
        _current.reset(token)


@contextmanager
def _signals(asked: Interruption) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before: dict[int, Any] = {number: signal.signal(number, asked.request) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
