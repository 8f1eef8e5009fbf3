"""The loop of `mbproj watch`: build at each save, then show the result in the browser and the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from mbproj.cli.watch.build import Built, Superseded, build
from mbproj.cli.watch.saves import Saves
from mbproj.cli.watch.server import Board, ShownPage
from mbproj.pages.page.three_js import three_js
from mbproj.pages.page.write import html, waiting


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
