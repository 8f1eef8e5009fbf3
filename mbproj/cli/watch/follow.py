"""The loop of `mbproj watch`: build at each save, then show the result in the browser and the terminal.

A save is detected by a file's time, size and place on the disk, checked ten times a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from time import sleep

import click

from mbproj.cli.watch.build import Built, Superseded, build
from mbproj.cli.watch.server import Board, ShownPage
from mbproj.pages.page.three_js import three_js
from mbproj.pages.page.write import html, waiting

#: The time between two checks, s. A save is over when two checks agree: some editors write in pieces.
LOOK = 0.05


class Saves:
    """The state of some files. `moved` tells whether it has changed since it was last taken."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.files = tuple(files)
        self._taken = self._now()

    def take(self) -> None:
        """Take the current state of the files as known."""
        self._taken = self._now()

    def follow(self, files: Iterable[Path]) -> None:
        """Watch these files from now on. The known state of files already watched stays."""
        known = dict(zip(self.files, self._taken, strict=True))
        self.files = tuple(files)
        self._taken = tuple(known.get(path) or _state(path) for path in self.files)

    @property
    def moved(self) -> bool:
        """Whether a file has been saved since."""
        return self._now() != self._taken

    def wait(self) -> None:
        """Wait until a file is saved, and take its new state."""
        before = self._taken
        while True:
            sleep(LOOK)
            now = self._now()
            if now != self._taken and now == before:
                self._taken = now
                return
            before = now

    def _now(self) -> tuple[tuple[int, ...], ...]:
        return tuple(map(_state, self.files))


def _state(path: Path) -> tuple[int, ...]:
    """The state of a file; empty where it is missing, as an editor may be about to replace it."""
    try:
        found = path.stat()
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino


def follow(path: Path, parameters: Mapping[str, str], options: Mapping[str, str], board: Board, *, quiet: bool) -> None:
    """Show the scene at each save, without end. Raises InputError where pages cannot be made here."""
    three_js()
    board.show(ShownPage(0, "", waiting(path.name).encode()))
    saves, numbers = Saves([path]), count(1)
    with TemporaryDirectory(prefix="mbproj-watch-") as folder:
        while True:
            try:
                found = build(path, parameters, options, Path(folder), lambda: saves.moved)
            except Superseded:
                saves.take()
                continue
            _tell(found, quiet=quiet)
            board.show(_next(board.shown, found, numbers))
            saves.follow(found.files or saves.files)
            saves.wait()


def _next(shown: ShownPage, found: Built, numbers: count[int]) -> ShownPage:
    """The new page, or the last page with the current problem."""
    if found.page is None:
        return shown._replace(problem=found.problem)
    number = next(numbers)
    page = html(found.page.title, found.page.data, found.page.packer, number)
    return ShownPage(number, found.problem, page.encode())


def _tell(found: Built, *, quiet: bool) -> None:
    if not quiet:
        click.echo(found.line)
        for note in found.notes:
            click.echo(note, err=True)
    if found.problem:
        click.echo(found.problem, err=True)
