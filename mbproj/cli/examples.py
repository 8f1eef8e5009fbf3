"""`mbproj examples`: the mechanisms that come with mbproj."""

from __future__ import annotations

import shutil
from pathlib import Path

import click

from mbproj.errors import InputError, Problem


@click.command("examples")
@click.option(
    "--copy",
    "folder",
    type=click.Path(),
    metavar="DIR",
    help="Copy them to DIR, those of the validation to DIR/validation (nothing is overwritten).",
)
def command(folder: str | None) -> None:
    """Lists the example mechanisms, or copies them to a folder."""
    from mbproj.mechanisms_folder import folder as home
    from mbproj.mechanisms_folder import mechanisms, validation_scenes
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
    try:
        for path, copy in copies.items():
            copy.parent.mkdir(parents=True, exist_ok=True)
            click.echo(shutil.copyfile(path, copy))
    except OSError as error:
        raise InputError(
            Problem(f"cannot copy to {target}: {error.strerror or error}", hint="choose a folder you can write to")
        ) from error
