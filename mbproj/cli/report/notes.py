"""Notes on a scene: what is legal, but may be a mistake."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mbproj.scene import Scene


def show_notes(scene: Scene) -> None:
    """A line for each note, on stderr."""
    from mbproj.scene.blocks.oversights import notes_on

    for note in notes_on(scene):
        click.echo(note.line("note"), err=True)
