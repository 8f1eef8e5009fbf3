"""`mbproj examples`: the mechanisms that come with mbproj."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.cli.completion import Folder
from mbproj.cli.explained import Part, explained, option
from mbproj.errors import InputError, Problem

ELSEWHERE = "choose a folder you can write to"
EXAMPLES = (
    ("List the mechanisms, each with its title.", "mbproj examples"),
    ("Copy all of them to a folder.", "mbproj examples --copy mechanisms"),
)


@explained("examples", EXAMPLES)
@option(
    Part.OUTPUT,
    "--copy",
    "folder",
    type=Folder(),
    metavar="DIR",
    help="Copy them to DIR, and those of the validation to DIR/validation; nothing is overwritten.",
)
def command(folder: str | None) -> None:
    """Lists the example mechanisms, or copies them to a folder."""
    from mbproj.mechanisms_folder import folder as home
    from mbproj.mechanisms_folder import mechanisms, validation_scenes
    from mbproj.outputs import SCENE, make_folder, write_text
    from mbproj.scene import read_scene

    paths = mechanisms()
    if folder is None:
        width = max(len(path.name) for path in paths)
        for path in paths:
            click.echo(f"{path.name:{width}}  {read_scene(path).title}")
        return
    target = Path(folder)
    copies = {path: target / path.relative_to(home()) for path in (*paths, *validation_scenes())}
    taken = [str(copy.relative_to(target)) for copy in copies.values() if copy.exists()]
    if taken:
        raise InputError(Problem(f"{target} has already {', '.join(taken)}", hint="choose another folder"))
    for path, copy in copies.items():
        make_folder(copy.parent, ELSEWHERE)
        click.echo(write_text(copy, path.read_text(encoding="utf-8"), SCENE, hint=ELSEWHERE))
