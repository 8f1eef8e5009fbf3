"""Notes on a scene: what is legal, but may be a mistake."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mbproj.errors import Problem
    from mbproj.scene import Scene


def notes_on(scene: Scene) -> list[Problem]:
    """What was noted when the scene was read, and what its bodies and joints show."""
    from mbproj.scene.blocks.oversights import oversights

    return [*scene.notes, *oversights(scene)]


def show_notes(scene: Scene) -> None:
    """A line for each note, on stderr."""
    for note in notes_on(scene):
        click.echo(note.line("note"), err=True)
