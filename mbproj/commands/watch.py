"""The loop of `mbproj watch`: build at each save, then show the result in the browser and the terminal.

A save is detected by a file's time, size and place on the disk, checked ten times a second.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import datetime
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep
from typing import NamedTuple

import click

from mbproj.api.check.checked import assembled, checked
from mbproj.cli.watch.server import Board, ShownPage
from mbproj.errors import InputError, SimulationError, message_and_code
from mbproj.pages.data.pages import PageData, page_of
from mbproj.pages.page.three_js import three_js
from mbproj.pages.page.write import html, waiting
from mbproj.results import open_own_results, part_path
from mbproj.results.notes import Note
from mbproj.runs.record import record_run
from mbproj.scene import read_scene, settings_to_run
from mbproj.scene.read import Scene

#: The time between two checks, s. A save is over when two checks agree: some editors write in pieces.
LOOK = 0.05


class Saves:
    """The state of some files. `have_changed` tells whether it has changed since it was last taken."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.files = tuple(files)
        self._taken = self._states()

    def take(self) -> None:
        """Take the current state of the files as known."""
        self._taken = self._states()

    def follow(self, files: Iterable[Path]) -> None:
        """Watch these files from now on. The known state of files already watched stays."""
        known = dict(zip(self.files, self._taken, strict=True))
        self.files = tuple(files)
        self._taken = tuple(known.get(path) or _state(path) for path in self.files)

    @property
    def have_changed(self) -> bool:
        """Whether a file has been saved since."""
        return self._states() != self._taken

    def wait(self) -> None:
        """Wait until a file is saved, and take its new state."""
        before = self._taken
        while True:
            sleep(LOOK)
            now = self._states()
            if now != self._taken and now == before:
                self._taken = now
                return
            before = now

    def _states(self) -> tuple[tuple[int, ...], ...]:
        return tuple(map(_state, self.files))


def _state(path: Path) -> tuple[int, ...]:
    """The state of a file; empty where it is missing, as an editor may be about to replace it."""
    try:
        status = path.stat()
    except OSError:
        return ()
    return status.st_mtime_ns, status.st_size, status.st_ino


def follow(path: Path, parameters: Mapping[str, str], options: Mapping[str, str], board: Board, *, quiet: bool) -> None:
    """Show the scene at each save, without end. Raises InputError where pages cannot be made here."""
    three_js()
    board.show(ShownPage(0, "", waiting(path.name).encode()))
    saves, numbers = Saves([path]), count(1)
    with TemporaryDirectory(prefix="mbproj-watch-") as folder:
        while True:
            try:
                built = build(path, parameters, options, Path(folder), lambda: saves.have_changed)
            except Superseded:
                saves.take()
                continue
            _tell(built, quiet=quiet)
            board.show(_next(board.shown, built, numbers))
            saves.follow(built.files or saves.files)
            saves.wait()


def _next(shown: ShownPage, built: Built, numbers: count[int]) -> ShownPage:
    """The new page, or the last page with the current problem."""
    if built.page is None:
        return shown._replace(problem=built.problem)
    number = next(numbers)
    page = html(built.page.title, built.page.data, built.page.packer, number)
    return ShownPage(number, built.problem, page.encode())


def _tell(built: Built, *, quiet: bool) -> None:
    if not quiet:
        click.echo(built.line)
        for note in built.notes:
            click.echo(note, err=True)
    if built.problem:
        click.echo(built.problem, err=True)


class Superseded(Exception):
    """The exception where the scene was saved again while it ran."""


class Built(NamedTuple):
    """The result of a save: a line on it, the page if there is one, the problem, and notes on possible mistakes.
    `files` are the files that the scene was read from, as far as they could be read."""

    line: str
    page: PageData | None
    problem: str = ""
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()


def build(
    path: Path,
    parameters: Mapping[str, str],
    options: Mapping[str, str],
    folder: Path,
    interrupted: Callable[[], bool],
) -> Built:
    """Read, check and run the scene; results go into `folder`. A run that fails gets a page of its samples so far.
    Raises Superseded as soon as `interrupted` returns True."""
    began, files = perf_counter(), tuple[Path, ...]()
    try:
        what = read_scene(str(path), parameters, options)
        files = (path, *_meshes(what, path.parent))
        page, said, notes, problem = _ran(what, path, folder / f"{path.stem}.h5", interrupted)
    except Superseded:
        raise
    except Exception as error:  # any error is shown: the next save may remove its cause
        message, _ = message_and_code(error)
        return Built(f"{_time()} {path.name}: not run", None, message, files=files)
    return Built(f"{_time()} {path.name}: {said}, {perf_counter() - began:.2f} s", page, problem, notes, files)


def _meshes(what: Scene, folder: Path) -> Iterator[Path]:
    for body in what.bodies:
        if body.appearance is not None and body.appearance.mesh is not None:
            yield folder / body.appearance.mesh.file


def _time() -> str:
    return datetime.now().strftime("%H:%M:%S")


def _ran(
    what: Scene, path: Path, results: Path, interrupted: Callable[[], bool]
) -> tuple[PageData, str, tuple[str, ...], str]:
    """Run the scene; return its page, a line on the run, notes, and the reason why it ended early."""
    checked_scene = checked(what, *assembled(what))
    if not checked_scene.can_run:
        raise InputError(list(checked_scene.problems))

    def progress(time: float) -> None:
        if interrupted():
            raise Superseded

    problem, violation = "", ""
    notes = [Note.on(note) for note in checked_scene.notes]
    for left in (results, part_path(results)):  # the writer would check a file that it replaces
        left.unlink(missing_ok=True)
    try:
        run = record_run(what, results, progress=progress)
        notes += run.notes
        violation = f", joints closed to {run.attributes['position_violation_max']:.1e}"
    except SimulationError as error:
        if error.output is None:
            raise
        problem, _ = message_and_code(error)
    with open_own_results(results) as opened:
        page = page_of([opened], [path.stem])
        until = float(opened.time[-1])
    freedoms = checked_scene.degrees_of_freedom
    free = "" if freedoms is None else f"{freedoms} degree{'s' * (freedoms != 1)} of freedom, "
    said = f"{free}{until:.4g} of {settings_to_run(what).duration:.4g} s{violation}"
    return page, said, tuple(dict.fromkeys(map(str, notes))), problem
