"""Notes on a scene: what is legal, but may be a mistake."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mbproj.errors import Problem


def show_notes(notes: Iterable[Problem]) -> None:
    """Print a line for each note on stderr."""
    for note in notes:
        click.echo(note.line("note"), err=True)
