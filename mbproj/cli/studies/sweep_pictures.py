"""Pictures of sweeps, for `mbproj plot` and `mbproj sweep --plot`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.errors import InputError, Problem
from mbproj.figures.sweeps import PICTURES
from mbproj.scene.text.suggestions import choose_from

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.figures.sweeps.chosen import Chosen

OTHER_DIRECTORY = "choose another directory with -o"


def is_sweep(path: Path) -> bool:
    """Whether the path is a folder, which results of runs never are, or the summary of a sweep."""
    from mbproj.outputs import hdf5
    from mbproj.results.sweep.layout import FORMAT

    return path.is_dir() or (path.is_file() and hdf5(FORMAT).wrote(path))


def draw_sweep(
    paths: Sequence[Path],
    kinds: Sequence[str],
    directory: Path,
    file_format: str,
    of: Sequence[str],
    over: Sequence[str],
    *,
    unfit: Sequence[str],
    force: bool,
) -> None:
    """Draw pictures of one sweep, all that suit its design or those of these `kinds`, and print their paths. `unfit`
    are given options that apply only to results of runs."""
    from mbproj.figures.save import save
    from mbproj.figures.sweeps import draw
    from mbproj.figures.sweeps.chosen import choose
    from mbproj.outputs import check_replaceable, make_folder, picture
    from mbproj.results.sweep.table import read_table

    if len(paths) > 1:
        raise InputError(Problem("sweeps are drawn one at a time", hint=f"give '{paths[0]}' alone"))
    if unfit:
        raise InputError(Problem(f"{unfit[0]} is for results of runs, and '{paths[0]}' is a sweep"))
    for kind in kinds:
        if kind not in PICTURES:
            raise InputError(Problem(f"--kind: unknown kind '{kind}' of a sweep", hint=choose_from(kind, PICTURES)))
    table = read_table(paths[0])
    chosen = choose(table, of, over)
    drawn = _applicable(chosen, kinds)
    make_folder(directory, OTHER_DIRECTORY)
    targets = {kind: directory / f"{table.name}-{kind}.{file_format}" for kind in drawn}
    for target in targets.values():  # check all files before the first is written
        check_replaceable(target, picture(file_format), force=force, hint=OTHER_DIRECTORY)
    for kind, target in targets.items():
        click.echo(save(draw(kind, chosen), target, force=force))


def usual(summary: Path) -> Figure | str:
    """The first picture that suits the design of a sweep, or a note that there is nothing to draw."""
    from mbproj.figures.sweeps import draw
    from mbproj.figures.sweeps.chosen import choose
    from mbproj.results.sweep.table import read_table

    try:
        chosen = choose(read_table(summary), (), ())
        kind, *_ = _applicable(chosen, ())
    except InputError as nothing:
        return f"no picture: {nothing}"
    return draw(kind, chosen)


def _applicable(chosen: Chosen, kinds: Sequence[str]) -> list[str]:
    """The kinds to draw: those asked for, or those that suit the design. A kind that does not apply is an error where
    it was asked for."""
    from mbproj.figures.sweeps import why_not

    reasons: Mapping[str, str | None] = {kind: why_not(kind, chosen) for kind in PICTURES}
    able = [kind for kind, reason in reasons.items() if reason is None]
    for kind in kinds:
        if reasons[kind]:
            raise InputError(Problem(f"--kind {kind}: {reasons[kind]}", hint=f"kinds that apply: {', '.join(able)}"))
    usual = [kind for kind in able if chosen.table.combine in PICTURES[kind].designs]
    found = list(dict.fromkeys(kinds)) or usual or able
    if not found:
        raise InputError(Problem(f"the sweep has nothing to draw: {next(iter(reasons.values()))}"))
    return found
