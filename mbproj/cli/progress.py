"""A progress bar with the time left, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import click

from mbproj.integrate.simulate import Progress

#: Positions of the bar: enough for a duration of any unit.
STEPS = 1000


@contextmanager
def progress_bar(duration: float | None, hidden: bool) -> Iterator[Progress | None]:
    """A function to call with the simulated time (s) reached, of `duration` s; None where nothing is to be shown."""
    if hidden or not duration or not sys.stderr.isatty():
        yield None
        return
    with click.progressbar(length=STEPS, file=sys.stderr, label="simulating", show_percent=True) as bar:

        def show(time: float) -> None:
            bar.update(max(0, int(STEPS * time / duration) - bar.pos))

        yield show
