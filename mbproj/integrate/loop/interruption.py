"""Ctrl-C and SIGTERM during a run: noticed between steps, so that what was computed is kept."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any


class Interruption:
    """Whether somebody asked the run to stop."""

    def __init__(self) -> None:
        self.requested = False

    def check(self) -> None:
        """Raises KeyboardInterrupt if so."""
        if self.requested:
            raise KeyboardInterrupt

    def request(self, signum: int, frame: FrameType | None) -> None:
        """A signal handler: the first signal asks the run to stop, a second one stops at once."""
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Turns SIGINT and SIGTERM into a request while the block runs (in the main thread; elsewhere nothing changes)."""
    asked = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield asked
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before: dict[int, Any] = {number: signal.signal(number, asked.request) for number in numbers}
    try:
        yield asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
