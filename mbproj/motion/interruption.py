"""Interruption of a run by Ctrl-C, SIGTERM, or a time limit. It is checked between steps, so that computed samples are
kept: they are handed on in blocks."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import monotonic, perf_counter
from types import FrameType
from typing import Any

from mbproj.base.errors import MbprojError
from mbproj.equations.samples import Samples, join

#: A block is handed on when it is full, or this old, in s.
BLOCK_SECONDS = 0.5


class TimeIsUp(MbprojError):
    """A run has exceeded its time limit."""


#: The time at which runs of this thread have to stop, by the monotonic clock in s.
_deadline: ContextVar[float | None] = ContextVar("deadline", default=None)


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Limit the total time of the runs in the block, in s, after which they raise TimeIsUp; None sets no limit."""
    token = _deadline.set(None if seconds is None else monotonic() + seconds)
    try:
        yield
    finally:
        _deadline.reset(token)


class Interruption:
    """A request to stop the run, by a signal or by its time limit."""

    def __init__(self) -> None:
        self.requested = False
        self._deadline = _deadline.get()

    def check(self) -> None:
        """Raise KeyboardInterrupt after a signal, or TimeIsUp after the time limit."""
        if self.requested:
            raise KeyboardInterrupt
        if self._deadline is not None and monotonic() > self._deadline:
            raise TimeIsUp

    def request(self, signum: int, frame: FrameType | None) -> None:
        """Handle a signal: the first one asks the run to stop, a second one stops it at once."""
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True


#: The interruption of the run in this thread.
_current: ContextVar[Interruption | None] = ContextVar("current", default=None)


def look() -> None:
    """Raise, between two steps, the exceptions of `Interruption.check`."""
    current = _current.get()
    if current is not None:
        current.check()


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Turn SIGINT and SIGTERM into a request while the block runs, in the main thread. In other threads only
    `time_limit` has an effect. A block inside another one takes its request over."""
    asked, around = Interruption(), _current.get()
    asked.requested = around is not None and around.requested
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


def in_blocks(
    run: Iterator[Samples | None], asked: Interruption, pause: Callable[[], None], most: int
) -> Iterator[Samples]:
    """Yield the samples in blocks of about `most`; where the run fails or is interrupted, first the samples made so
    far. `pause` is called where time has passed without a sample."""
    pending: list[Samples] = []
    opened = perf_counter()
    try:
        for samples in run:
            if samples is None:
                pause()
            else:
                pending.append(samples)
            asked.check()
            count = sum(len(part.t) for part in pending)
            if count >= most or (pending and perf_counter() - opened > BLOCK_SECONDS):
                block, pending = join(pending), []
                yield block
                opened = perf_counter()
    except BaseException:
        if pending:
            yield join(pending)
        raise
    if pending:
        yield join(pending)
