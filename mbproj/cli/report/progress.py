"""How far a command is, on stderr: on a terminal one line that is renewed, elsewhere a new line from time to time."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Event, Lock, Thread
from time import monotonic
from typing import TYPE_CHECKING, TextIO

import click

from mbproj.cli.streams import commanding
from mbproj.integrate.simulate import Progress
from mbproj.outputs.escapes import escaped
from mbproj.studies.parallel.progress import ALIKE, BESIDE, Tell, silent

if TYPE_CHECKING:
    from click._termui_impl import ProgressBar

#: Positions of the bar: enough for a duration of any unit.
STEPS = 1000
#: A terminal's line is renewed this often, and elsewhere a line written, s.
RENEWED, REPEATED = 1.0, 30.0


class Line:
    """What a command is doing, the time it has taken, and the time left if known. `clock` gives s. Without a terminal
    the first line appears after `REPEATED` s, so that short commands write none."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = monotonic) -> None:
        self.on_terminal = stream.isatty()
        self._stream, self._clock, self._lock = stream, clock, Lock()
        self._begun = self._written = clock()
        self._words, self._end = "", 0.0

    def say(self, words: str, left: float = 0.0) -> None:
        """The phase that begins now, and how many s it takes; 0 if unknown."""
        with self._lock:
            self._words, self._end = words, self._clock() + left
            if self.on_terminal or self._is_due():
                self._write()

    def tick(self) -> None:
        """Time has passed."""
        with self._lock:
            if self._words and self._is_due():
                self._write()

    def clear(self) -> None:
        """Leaves a terminal as it was."""
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
        with suppress(OSError):  # nobody reads it any more
            self._stream.write(text)
            self._stream.flush()


@contextmanager
def line() -> Iterator[Line]:
    """A line on stderr, shown for as long as the work takes."""
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
    """A study's `Tell`, on a line."""

    def __init__(self, line: Line, clock: Callable[[], float] = monotonic) -> None:
        self._line, self._clock = line, clock
        self._first: dict[str, tuple[float, int]] = {}

    def __call__(self, phase: str, done: int, whole: int) -> None:
        """Says how much of a phase is done. What was done before the first call took none of the time since."""
        now, (phase, _, words) = self._clock(), phase.partition(BESIDE)
        begun, before = self._first.get(phase, (now, done))
        if done <= before:
            begun, before = self._first[phase] = now, done
        pace = (now - begun) / (done - before) if phase in ALIKE and done > before else 0.0
        said = phase if whole == 1 else f"{phase}: {done} of {whole}"
        self._line.say(f"{said}, {words}" if words else said, pace * (whole - done))


@contextmanager
def telling(hidden: bool) -> Iterator[Tell]:
    """Shows how far a study is."""
    if hidden:
        yield silent
        return
    with line() as shown:
        yield Telling(shown)


class Pace:
    """How long a run still takes until `end` (s of simulated time): as long a simulated second as so far, on the
    average since the first call. What went on before that, an earlier leg of a continued run say, has no part in it."""

    def __init__(self, end: float, clock: Callable[[], float] = monotonic) -> None:
        self._end, self._clock = end, clock
        self._first: tuple[float, float] | None = None

    def reach(self, time: float) -> float:
        """A run has come to a simulated time: seconds that it still takes, 0 where that is not known."""
        now = self._clock()
        begun, start = self._first = self._first or (now, time)
        return (now - begun) / (time - start) * (self._end - time) if time > start else 0.0


class Bar:
    """A run's bar on a terminal, of all of its simulated time; beside it the time left."""

    def __init__(self, stream: TextIO, duration: float, clock: Callable[[], float] = monotonic) -> None:
        self._duration, self._pace, self._left = duration, Pace(duration, clock), 0.0
        self.bar: ProgressBar[int] = click.progressbar(
            length=STEPS,
            file=stream,
            label="simulating",
            show_eta=False,
            show_percent=True,
            item_show_func=lambda _: f"{_duration(self._left)} left" if self._left else None,
        )

    def reach(self, time: float) -> None:
        """The run has come to a simulated time."""
        self._left = self._pace.reach(time)
        self.bar.update(max(0, int(STEPS * time / self._duration) - self.bar.pos))
        self.bar.render_progress()


@contextmanager
def progress_bar(duration: float | None, hidden: bool) -> Iterator[Progress | None]:
    """A function to call with the simulated time (s) reached, of `duration` s; None where nothing is to be shown. On a
    terminal that is a bar."""
    if hidden or not duration:
        yield None
    elif sys.stderr.isatty():
        shown_bar = Bar(commanding(sys.stderr), duration)
        with shown_bar.bar:
            yield shown_bar.reach
    else:
        with line() as shown:
            done = f"of {duration:.4g} s simulated"
            pace = Pace(duration)

            def reach(time: float) -> None:
                left = pace.reach(time)
                shown.say(f"{time:.4g} {done}", left) if time < duration else shown.clear()

            yield reach


def _duration(seconds: float) -> str:
    """Right to 5 %."""
    if seconds < 100:
        return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.2g} s"
    minutes, hours = seconds / 60, seconds / 3600
    if minutes < 100:
        return f"{minutes:.1f} min" if minutes < 10 else f"{minutes:.0f} min"
    return f"{hours:.1f} h" if hours < 100 else f"{hours:.0f} h"
