"""Pictures of files of modes and linear models, for `mbproj plot`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.errors import InputError, Problem
from mbproj.scene.text.suggestions import choose_from

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The names of the file formats, as their layouts define them.
MODES, MODEL = "mbproj modes", "mbproj linear model"
OTHER_DIRECTORY = "choose another directory with -o"


def is_linear(path: Path) -> bool:
    """Whether the file is one of modes or a linear model."""
    return path.is_file() and (_is(path, MODES) or _is(path, MODEL))


def _is(path: Path, file_format: str) -> bool:
    from mbproj.outputs import hdf5

    return hdf5(file_format).wrote(path)


def draw_linear(
    paths: Sequence[Path], kinds: Sequence[str], directory: Path, file_format: str, *, unfit: Sequence[str], force: bool
) -> None:
    """Draw pictures of one file, all that apply or those of these `kinds`, and print their paths. `unfit` are given
    options that apply only to results of runs."""
    from mbproj.figures.save import save
    from mbproj.outputs import check_replaceable, make_folder, picture

    if len(paths) > 1:
        raise InputError(
            Problem("modes and linear models are drawn one file at a time", hint=f"give '{paths[0]}' alone")
        )
    if unfit:
        raise InputError(Problem(f"{unfit[0]} is for results of runs, and '{paths[0]}' is none"))
    drawn = _pictures(paths[0], kinds)
    make_folder(directory, OTHER_DIRECTORY)
    targets = {kind: directory / f"{paths[0].stem}-{kind}.{file_format}" for kind in drawn}
    for target in targets.values():  # check all files before the first is written
        check_replaceable(target, picture(file_format), force=force, hint=OTHER_DIRECTORY)
    for kind, target in targets.items():
        click.echo(save(drawn[kind](), target, force=force))


def _pictures(path: Path, kinds: Sequence[str]) -> Mapping[str, Callable[[], Figure]]:
    able, why = _of_model(path) if _is(path, MODEL) else _of_modes(path)
    for kind in kinds:
        if kind not in able:
            raise InputError(Problem(f"--kind: unknown kind '{kind}'", hint=choose_from(kind, able)))
        if why[kind]:
            raise InputError(Problem(f"--kind {kind}: {why[kind]}"))
    if not kinds and all(why.values()):
        raise InputError(Problem(f"'{path}' has nothing to draw: {next(iter(why.values()))}"))
    return {kind: able[kind] for kind in kinds or able if not why[kind]}


#: The pictures by kind, and functions that tell why they do not apply.
Drawn = tuple[dict[str, "Callable[[], Figure]"], dict[str, "str | None"]]


def _of_modes(path: Path) -> Drawn:
    from mbproj.figures.pages.modes import PICTURES, why_not
    from mbproj.results.linear.modes_file import read_modes

    modes = read_modes(path)
    return {kind: partial(draw, modes) for kind, draw in PICTURES.items()}, {
        kind: why_not(kind, modes) for kind in PICTURES
    }


def _of_model(path: Path) -> Drawn:
    from mbproj.figures.pages.bode import PICTURES
    from mbproj.results.linear.model_file import read_model

    model = read_model(path)
    return {kind: partial(draw, model) for kind, draw in PICTURES.items()}, dict.fromkeys(PICTURES)
