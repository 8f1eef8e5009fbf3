"""Pictures of files that are not results of runs, for `mbproj plot`: sweeps, designs, modes and linear models."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem, choose_from

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The names of the file formats, as their layouts define them.
MODES, MODEL = "mbproj modes", "mbproj linear model"
#: The kinds of pictures in `figures.pages.designs`.
OF_DESIGNS = ("fit", "convergence", "correlation", "front")
OTHER_DIRECTORY = "choose another directory with -o"


@dataclass(frozen=True)
class FilePictures:
    """The pictures of a file: `title` begins their names. `why_not` has the reason why a kind does not apply, or None.
    `usual` are the kinds that are drawn where none is asked for."""

    title: str
    draw: Mapping[str, Callable[[], Figure]]
    why_not: Mapping[str, str | None]
    usual: tuple[str, ...]

    def kinds_to_draw(self, path: Path, kinds: Sequence[str], what: str) -> tuple[str, ...]:
        """The kinds to draw. Raises InputError where one that is asked for does not apply, or none does."""
        able = [kind for kind, reason in self.why_not.items() if reason is None]
        for kind in kinds:
            if kind not in self.draw:
                raise InputError(Problem(f"--kind: unknown kind '{kind}'{what}", hint=choose_from(kind, self.draw)))
            if self.why_not[kind]:
                hint = f"kinds that apply: {', '.join(able)}" if able else ""
                raise InputError(Problem(f"--kind {kind}: {self.why_not[kind]}", hint=hint))
        picked = tuple(dict.fromkeys(kinds)) or self.usual or tuple(able)
        if not picked:
            raise InputError(Problem(f"'{path}' has nothing to draw: {next(iter(self.why_not.values()))}"))
        return picked


@dataclass(frozen=True)
class DrawnFile:
    """A kind of file that has pictures: `many` and `one` are its names in messages. `pictures` reads a file; it is also
    given the values of --of and --over. `takes` are the options that it takes besides the common ones."""

    many: str
    one: str
    is_one: Callable[[Path], bool]
    pictures: Callable[[Path, Sequence[str], Sequence[str]], FilePictures]
    takes: tuple[str, ...] = ()


def draw_pictures(
    kind_of_file: DrawnFile,
    paths: Sequence[Path],
    kinds: Sequence[str],
    directory: Path,
    file_format: str,
    of: Sequence[str],
    over: Sequence[str],
    given: Sequence[str],
    *,
    force: bool,
) -> None:
    """Draw pictures of one file, the usual ones or those of these `kinds`, and print their paths. `given` are the names
    of the other options that are given, --of and --over included."""
    from mbproj.figures.save import save
    from mbproj.output_files import check_replaceable, make_folder, picture

    path, what = paths[0], kind_of_file
    if len(paths) > 1:
        raise InputError(Problem(f"{what.many} are drawn one at a time", hint=f"give '{path}' alone"))
    for name in given:
        if name not in what.takes:
            raise InputError(Problem(f"{name} is for results of runs, and '{path}' is {what.one or 'none'}"))
    pictures = what.pictures(path, of, over)
    drawn = pictures.kinds_to_draw(path, kinds, f" of {what.one}" if what.one else "")
    make_folder(directory, OTHER_DIRECTORY)
    targets = {kind: directory / f"{pictures.title}-{kind}.{file_format}" for kind in drawn}
    for target in targets.values():  # check all files before the first is written
        check_replaceable(target, picture(file_format), force=force, hint=OTHER_DIRECTORY)
    for kind, target in targets.items():
        click.echo(save(pictures.draw[kind](), target, force=force))


def usual_of_sweep(summary: Path) -> Figure | str:
    """The first picture that suits the design of a sweep, or a note that there is nothing to draw."""
    try:
        pictures = _of_sweep(summary, (), ())
        return pictures.draw[pictures.kinds_to_draw(summary, (), "")[0]]()
    except InputError as nothing:
        return f"no picture: {nothing}"


def _of_sweep(path: Path, of: Sequence[str], over: Sequence[str]) -> FilePictures:
    from mbproj.figures import sweeps
    from mbproj.figures.sweeps.chosen import choose
    from mbproj.results.sweep.table import read_table

    table = read_table(path)
    chosen = choose(table, of, over)
    reasons = {kind: sweeps.why_not(kind, chosen) for kind in sweeps.PICTURES}
    usual = (kind for kind in sweeps.PICTURES if not reasons[kind] and table.combine in sweeps.PICTURES[kind].designs)
    return FilePictures(
        table.name, {kind: partial(sweeps.draw, kind, chosen) for kind in sweeps.PICTURES}, reasons, tuple(usual)
    )


def _of_design(path: Path, of: Sequence[str], over: Sequence[str]) -> FilePictures:
    from mbproj.figures.pages import designs
    from mbproj.results.design_file import read_drawn

    drawn = read_drawn(path)
    draw = {kind: partial(draw, drawn) for kind, draw in designs.PICTURES.items()}
    return FilePictures(
        path.resolve().name, draw, {kind: designs.why_not(kind, drawn) for kind in designs.PICTURES}, ()
    )


def _of_linear(path: Path, of: Sequence[str], over: Sequence[str]) -> FilePictures:
    if _is_of_format(path, MODEL):
        from mbproj.figures.pages import bode
        from mbproj.results.linear.model_file import read_model

        model = read_model(path)
        drawn: dict[str, Callable[[], Figure]] = {kind: partial(draw, model) for kind, draw in bode.PICTURES.items()}
        return FilePictures(path.stem, drawn, dict.fromkeys(bode.PICTURES), ())
    from mbproj.figures.pages import modes
    from mbproj.results.linear.modes_file import read_modes

    read = read_modes(path)
    drawn = {kind: partial(draw, read) for kind, draw in modes.PICTURES.items()}
    return FilePictures(path.stem, drawn, {kind: modes.why_not(kind, read) for kind in modes.PICTURES}, ())


def _is_of_format(path: Path, *file_formats: str) -> bool:
    from mbproj.output_files import hdf5

    return path.is_file() and hdf5(*file_formats).wrote(path)


def _is_design(path: Path) -> bool:
    return path.is_dir() and ((path / "design.json").exists() or (path / "best.yaml").exists())


def _is_sweep(path: Path) -> bool:
    """Whether the path is a folder, which results of runs never are, or the summary of a sweep."""
    from mbproj.results.sweep.layout import FORMAT

    return path.is_dir() or _is_of_format(path, FORMAT)


def is_linear(path: Path) -> bool:
    """Whether the file is one of modes or a linear model."""
    return _is_of_format(path, MODES, MODEL)


DESIGN = DrawnFile("designs", "a design", _is_design, _of_design)
SWEEP = DrawnFile("sweeps", "a sweep", _is_sweep, _of_sweep, ("--of", "--over"))
LINEAR = DrawnFile("modes and linear models", "", is_linear, _of_linear)
