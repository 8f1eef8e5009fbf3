"""`mbproj examples`: the mechanisms and notebooks that come with mbproj."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.base.errors import InputError, Problem
from mbproj.commands.options import FolderPath, Part, explained, option

if TYPE_CHECKING:
    from mbproj.results.output_files import FileKind

ELSEWHERE = "choose a folder you can write to"
EXAMPLES = (
    ("List the mechanisms, each with its title.", "mbproj examples"),
    ("Copy all of them to a folder.", "mbproj examples --copy mechanisms"),
    ("Copy the notebooks of a teacher, a researcher and a designer.", "mbproj examples --notebooks ."),
)


@explained("examples", EXAMPLES)
@option(
    Part.OUTPUT,
    "--copy",
    "folder",
    type=FolderPath(),
    metavar="DIR",
    help="Copy them to DIR, and those of the validation to DIR/validation; nothing is overwritten.",
)
@option(
    Part.OUTPUT,
    "--notebooks",
    "notebooks",
    type=FolderPath(),
    metavar="DIR",
    help="Copy the notebooks for Jupyter to DIR; nothing is overwritten.",
)
def command(folder: str | None, notebooks: str | None) -> None:
    """Lists the example mechanisms, or copies them, or notebooks, to a folder."""
    from mbproj.base.mechanisms_folder import folder as home
    from mbproj.base.mechanisms_folder import mechanisms, validation_scenes
    from mbproj.guide.pages import ROOT
    from mbproj.results.output_files import NOTEBOOK, SCENE
    from mbproj.scene.scene import read_scene

    if notebooks is not None:
        books = sorted((ROOT / "notebooks").glob("*.ipynb"))
        _copy({path: Path(notebooks) / path.name for path in books}, Path(notebooks), NOTEBOOK)
    if folder is None and notebooks is not None:
        return
    paths = mechanisms()
    if folder is None:
        width = max(len(path.name) for path in paths)
        for path in paths:
            click.echo(f"{path.name:{width}}  {read_scene(path).title}")
        return
    target = Path(folder)
    copies = {path: target / path.relative_to(home()) for path in (*paths, *validation_scenes())}
    _copy(copies, target, SCENE)


def _copy(copies: Mapping[Path, Path], target: Path, kind: FileKind) -> None:
    """Copy files into the folder `target`: all of them, or none where one exists already."""
    from mbproj.results.output_files import make_folder, write_text

    taken = [str(copy.relative_to(target)) for copy in copies.values() if copy.exists()]
    if taken:
        raise InputError(Problem(f"{target} has already {', '.join(taken)}", hint="choose another folder"))
    for path, copy in copies.items():
        make_folder(copy.parent, ELSEWHERE)
        click.echo(write_text(copy, path.read_text(encoding="utf-8"), kind, hint=ELSEWHERE))
