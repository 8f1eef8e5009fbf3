"""Pictures of designs, for `mbproj plot`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from mbproj.errors import InputError, Problem
from mbproj.scene.text.suggestions import choose_from

#: The kinds of pictures in `figures.pages.designs`.
KINDS = ("fit", "convergence", "correlation", "front")
OTHER = "choose another directory with -o"


def is_design(path: Path) -> bool:
    """Whether the path is the folder of a design."""
    return path.is_dir() and ((path / "design.json").exists() or (path / "best.yaml").exists())


def draw_design(
    paths: Sequence[Path], kinds: Sequence[str], directory: Path, file_format: str, *, unfit: Sequence[str], force: bool
) -> None:
    """Draw pictures of one design, all that apply or those of these `kinds`, and print their paths. `unfit` are given
    options that apply only to results of runs."""
    from mbproj.figures.pages.designs import PICTURES, why_not
    from mbproj.figures.save import save
    from mbproj.outputs import check_replaceable, make_folder, picture
    from mbproj.results.design.drawn import read_drawn

    if len(paths) > 1:
        raise InputError(Problem("designs are drawn one at a time", hint=f"give '{paths[0]}' alone"))
    if unfit:
        raise InputError(Problem(f"{unfit[0]} is for results of runs, and '{paths[0]}' is a design"))
    for kind in kinds:
        if kind not in PICTURES:
            raise InputError(Problem(f"--kind: unknown kind '{kind}' of a design", hint=choose_from(kind, PICTURES)))
    drawn = read_drawn(paths[0])
    reasons = {kind: why_not(kind, drawn) for kind in PICTURES}
    able = [kind for kind, reason in reasons.items() if reason is None]
    for kind in kinds:
        if reasons[kind]:
            raise InputError(Problem(f"--kind {kind}: {reasons[kind]}", hint=f"kinds that apply: {', '.join(able)}"))
    make_folder(directory, OTHER)
    name = paths[0].resolve().name
    targets = {kind: directory / f"{name}-{kind}.{file_format}" for kind in dict.fromkeys(kinds or able)}
    for target in targets.values():  # check all files before the first is written
        check_replaceable(target, picture(file_format), force=force, hint=OTHER)
    for kind, target in targets.items():
        click.echo(save(PICTURES[kind](drawn), target, force=force))
