"""Pictures of files of modes and linear models, for `mbproj plot`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.errors import InputError, Problem
from mbproj.scene.text.suggestions import choose_from

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OTHER_DIRECTORY = "choose another directory with -o"


def is_linear(path: Path) -> bool:
    """Whether the file is one of modes."""
    from mbproj.outputs import hdf5
    from mbproj.results.linear.modes_file import LAYOUT

    return path.is_file() and hdf5(LAYOUT.format).wrote(path)


def draw_linear(
    paths: Sequence[Path], kinds: Sequence[str], directory: Path, file_format: str, *, unfit: Sequence[str], force: bool
) -> None:
    """Draws one file, all pictures that apply or those of these kinds, and prints their paths. `unfit`: options that
    were given and are for results of runs."""
    from mbproj.outputs import check_replaceable, make_folder, picture
    from mbproj.plot.save import save

    if len(paths) > 1:
        raise InputError(Problem("modes are drawn one file at a time", hint=f"give '{paths[0]}' alone"))
    if unfit:
        raise InputError(Problem(f"{unfit[0]} is for results of runs, and '{paths[0]}' is a file of modes"))
    drawn = _pictures(paths[0], kinds)
    make_folder(directory, OTHER_DIRECTORY)
    targets = {kind: directory / f"{paths[0].stem}-{kind}.{file_format}" for kind in drawn}
    for target in targets.values():  # all or none
        check_replaceable(target, picture(file_format), force=force, hint=OTHER_DIRECTORY)
    for kind, target in targets.items():
        click.echo(save(drawn[kind](), target, force=force))


def _pictures(path: Path, kinds: Sequence[str]) -> Mapping[str, Callable[[], Figure]]:
    from mbproj.plot.pages.modes import PICTURES, why_not
    from mbproj.results.linear.modes_file import read_modes

    modes = read_modes(path)
    for kind in kinds:
        if kind not in PICTURES:
            raise InputError(Problem(f"--kind: unknown kind '{kind}'", hint=choose_from(kind, PICTURES)))
        reason = why_not(kind, modes)
        if reason:
            raise InputError(Problem(f"--kind {kind}: {reason}"))
    chosen = list(dict.fromkeys(kinds)) or [kind for kind in PICTURES if why_not(kind, modes) is None]
    return {kind: lambda kind=kind: PICTURES[kind](modes) for kind in chosen}  # type: ignore[misc]
