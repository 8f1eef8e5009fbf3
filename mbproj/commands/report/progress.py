"""The progress of a command on stderr: on a terminal one line that is rewritten, elsewhere a new line from time to
time."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from threading import Event, Lock, Thread
from time import monotonic
from typing import TYPE_CHECKING, TextIO

import click

from mbproj.base.text import escaped
from mbproj.commands.streams import commanding
from mbproj.motion.simulate import Progress

if TYPE_CHECKING:
    from click._termui_impl import ProgressBar

    from mbproj.studies.parallel.progress import Tell

#: The number of positions of the bar, enough for a duration in any unit.
STEPS = 1000
#: The time between two updates of a terminal's line, and between two lines elsewhere, s.
RENEWED, REPEATED = 1.0, 30.0


class Line:
    """A line with the work of a command, the time that it has taken, and the time left if known. `clock` gives s.
    Without a terminal the first line appears after `REPEATED` s, so that short commands print none."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = monotonic) -> None:
        self.on_terminal = stream.isatty()
        self._stream, self._clock, self._lock = stream, clock, Lock()
        self._begun = self._written = clock()
        self._words, self._end = "", 0.0

    def say(self, words: str, left: float = 0.0) -> None:
        """Begin a phase, with the time that is left in s, or 0 if unknown."""
        with self._lock:
            self._words, self._end = words, self._clock() + left
            if self.on_terminal or self._is_due():
                self._write()

    def tick(self) -> None:
        """Rewrite the line if it is due."""
        with self._lock:
            if self._words and self._is_due():
                self._write()

    def clear(self) -> None:
        """Remove the line from the terminal."""
        with self._lock:
            if self.on_terminal and self._words:
                self._put("\r\x1b[K")
            self._words = ""

    def _is_due(self) -> bool:
        return self._clock() - self._written >= (RENEWED if self.on_terminal else REPEATED)

    def _write(self) -> None:
        now = self._written = self._clock()
        left = f"{_duration(self._end - now)} left, " if self._end > now else ""
        text = f"{self._words}, {left}{_duration(now - self._begun)} so far"
        self._put(f"\r{escaped(text)}\x1b[K" if self.on_terminal else f"{text}\n")

    def _put(self, text: str) -> None:
        with suppress(OSError):  # nobody reads stderr any more
            self._stream.write(text)
            self._stream.flush()


@contextmanager
def line() -> Iterator[Line]:
    """Yield a line on stderr, shown while the block runs."""
    shown, over = Line(commanding(sys.stderr)), Event()

    def go_on() -> None:
        while not over.wait(RENEWED):
            shown.tick()

    Thread(target=go_on, daemon=True).start()
    try:
        yield shown
    finally:
        over.set()
        shown.clear()


class Telling:
    """The function `Tell` of a study, which shows the progress on a line."""

    def __init__(self, line: Line, clock: Callable[[], float] = monotonic) -> None:
        self._line, self._clock = line, clock
        self._first: dict[str, tuple[float, int]] = {}

    def __call__(self, phase: str, done: int, whole: int) -> None:
        """Show how much of a phase is done. The pace counts only what is done after the phase's first call."""
        from mbproj.studies.parallel.progress import ALIKE, BESIDE

        now, (phase, _, words) = self._clock(), phase.partition(BESIDE)
        begun, before = self._first.get(phase, (now, done))
        if done <= before:
            begun, before = self._first[phase] = now, done
        pace = (now - begun) / (done - before) if phase in ALIKE and done > before else 0.0
        said = phase if whole == 1 else f"{phase}: {done} of {whole}"
        self._line.say(f"{said}, {words}" if words else said, pace * (whole - done))


@contextmanager
def telling(hidden: bool) -> Iterator[Tell]:
    """Yield a function that shows the progress of a study."""
    if hidden:
        yield lambda phase, done, whole: None
        return
    with line() as shown:
        yield Telling(shown)


class Pace:
    """The pace of a run up to `end` (s of simulated time). The time left assumes the mean pace since the first call.
    Earlier work, for example that of a continued run, does not count."""

    def __init__(self, end: float, clock: Callable[[], float] = monotonic) -> None:
        self._end, self._clock = end, clock
        self._first: tuple[float, float] | None = None

    def reach(self, time: float) -> float:
        """Take note of the simulated time that the run has reached; return the seconds left, 0 where unknown."""
        now = self._clock()
        begun, start = self._first = self._first or (now, time)
        return (now - begun) / (time - start) * (self._end - time) if time > start else 0.0


class Bar:
    """A bar on a terminal over all of a run's simulated time, with the time left beside it."""

    def __init__(self, stream: TextIO, duration: float, clock: Callable[[], float] = monotonic) -> None:
        self._duration, self._pace, self._left = duration, Pace(duration, clock), 0.0
        self.is_shown = False
        self.bar: ProgressBar[int] = click.progressbar(
            length=STEPS,
            file=stream,
            label="simulating",
            show_eta=False,
            show_percent=True,
            item_show_func=lambda _: f"{_duration(self._left)} left" if self._left else None,
        )

    def reach(self, time: float) -> None:
        """Show the simulated time that the run has reached."""
        self._left, self.is_shown = self._pace.reach(time), True
        self.bar.update(max(0, int(STEPS * time / self._duration) - self.bar.pos))
        self.bar.render_progress()


@contextmanager
def progress_bar(duration: float | None, hidden: bool) -> Iterator[Progress | None]:
    """Yield a function to be called with the simulated time (s) reached, of `duration` s; None where nothing is shown.
    On a terminal it moves a bar."""
    if hidden or not duration:
        yield None
    elif sys.stderr.isatty():
        bar = Bar(commanding(sys.stderr), duration)
        with ExitStack() as until_the_end:  # the bar begins with the run, after the notes on its scene

            def move(time: float) -> None:
                if not bar.is_shown:
                    until_the_end.enter_context(bar.bar)
                bar.reach(time)

            yield move
    else:
        with line() as shown:
            done = f"of {duration:.4g} s simulated"
            pace = Pace(duration)

            def reach(time: float) -> None:
                left = pace.reach(time)
                shown.say(f"{time:.4g} {done}", left) if time < duration else shown.clear()

            yield reach


def _duration(seconds: float) -> str:
    """A duration as text, with two or three digits."""
    if seconds < 100:
        return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.2g} s"
    minutes, hours = seconds / 60, seconds / 3600
    if minutes < 100:
        return f"{minutes:.1f} min" if minutes < 10 else f"{minutes:.0f} min"
    return f"{hours:.1f} h" if hours < 100 else f"{hours:.0f} h"
