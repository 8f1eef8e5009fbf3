"""`mbproj plot`: pictures of results."""

from __future__ import annotations

import gc
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.commands.figure_options import look
from mbproj.commands.kinds import AnyNumber, Corners, NotNegative, OneOf, Positive, Several
from mbproj.commands.options import FolderPath, Part, explained, force_option, one_of, option, results_file
from mbproj.commands.results_shown import open_with_note, require_markers, selected
from mbproj.show.figures.kinds import KINDS, SWEEP_PICTURES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results.record import Results


# --- Pictures of files that are not results of runs, for `mbproj plot` ------------------------------------------------
# Sweeps, designs, modes and linear models.


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
    options: Sequence[str],
    *,
    force: bool,
) -> None:
    """Draw pictures of one file, the usual ones or those of these `kinds`, and print their paths. `options` are the
    names of the other options that are given, --of and --over included."""
    from mbproj.results.output_files import check_replaceable, make_folder, picture
    from mbproj.show.figures.style import save

    path, what = paths[0], kind_of_file
    if len(paths) > 1:
        raise InputError(Problem(f"{what.many} are drawn one at a time", hint=f"give '{path}' alone"))
    for name in options:
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
    from mbproj.results.sweep_table import read_table
    from mbproj.show.figures import kinds as sweeps
    from mbproj.show.figures.sweep_axes import choose

    table = read_table(path)
    chosen = choose(table, of, over)
    reasons = {kind: sweeps.why_no_sweep(kind, chosen) for kind in sweeps.SWEEP_PICTURES}
    usual = (
        kind
        for kind in sweeps.SWEEP_PICTURES
        if not reasons[kind] and table.combine in sweeps.SWEEP_PICTURES[kind].designs
    )
    return FilePictures(
        table.name,
        {kind: partial(sweeps.draw_sweep, kind, chosen) for kind in sweeps.SWEEP_PICTURES},
        reasons,
        tuple(usual),
    )


def _of_design(path: Path, of: Sequence[str], over: Sequence[str]) -> FilePictures:
    from mbproj.results.design_file import read_drawn
    from mbproj.show.figures import designs

    drawn = read_drawn(path)
    draw = {kind: partial(draw, drawn) for kind, draw in designs.PICTURES.items()}
    return FilePictures(
        path.resolve().name, draw, {kind: designs.why_not(kind, drawn) for kind in designs.PICTURES}, ()
    )


def _of_linear(path: Path, of: Sequence[str], over: Sequence[str]) -> FilePictures:
    if _is_of_format(path, MODEL):
        from mbproj.results.linear_files import read_model
        from mbproj.show.figures import linear as bode

        model = read_model(path)
        drawn: dict[str, Callable[[], Figure]] = {
            kind: partial(draw, model) for kind, draw in bode.MODEL_PICTURES.items()
        }
        return FilePictures(path.stem, drawn, dict.fromkeys(bode.MODEL_PICTURES), ())
    from mbproj.results.linear_files import read_modes
    from mbproj.show.figures import linear as modes

    read = read_modes(path)
    drawn = {kind: partial(draw, read) for kind, draw in modes.MODES_PICTURES.items()}
    return FilePictures(path.stem, drawn, {kind: modes.why_not(kind, read) for kind in modes.MODES_PICTURES}, ())


def _is_of_format(path: Path, *file_formats: str) -> bool:
    from mbproj.results.output_files import hdf5

    return path.is_file() and hdf5(*file_formats).wrote(path)


def _is_design(path: Path) -> bool:
    return path.is_dir() and ((path / "design.json").exists() or (path / "best.yaml").exists())


def _is_sweep(path: Path) -> bool:
    """Whether the path is a folder, which results of runs never are, or the summary of a sweep."""
    from mbproj.results.sweep_table import FORMAT

    return path.is_dir() or _is_of_format(path, FORMAT)


def is_linear(path: Path) -> bool:
    """Whether the file is one of modes or a linear model."""
    return _is_of_format(path, MODES, MODEL)


DESIGN = DrawnFile("designs", "a design", _is_design, _of_design)
SWEEP = DrawnFile("sweeps", "a sweep", _is_sweep, _of_sweep, ("--of", "--over"))
LINEAR = DrawnFile("modes and linear models", "", is_linear, _of_linear)


# --- `mbproj plot` ----------------------------------------------------------------------------------------------------


KINDS_HELP = "; ".join(f"{name}: {kind.summary}" for name, kind in KINDS.items())
EXAMPLES = (
    ("Draw every picture that applies.", "mbproj plot results.h5 -o pictures"),
    (
        "Hold the violations of two runs side by side.",
        "mbproj plot gopm.h5 results.h5 --kind violation --label GOPM --label GPOPM",
    ),
    ("Draw the tip of a sweep over its lengths.", "mbproj plot lengths-sweep --kind lines --of tip --over length"),
)


@explained("plot", EXAMPLES)
@click.argument("results", nargs=-1, required=True, type=results_file(path_type=Path))
@option(
    Part.WHAT,
    "--kind",
    "kinds",
    multiple=True,
    metavar="KIND",
    shell_complete=one_of(lambda: [*KINDS, *SWEEP_PICTURES, *OF_DESIGNS]),
    help=f"Only this kind, repeatable. {KINDS_HELP}. Of sweeps: {', '.join(SWEEP_PICTURES)}. "
    f"Of designs: {', '.join(OF_DESIGNS)}.",
)
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    "directory",
    default=".",
    type=FolderPath(path_type=Path),
    help="Output directory [default: .].",
)
@option(
    Part.OUTPUT,
    "--format",
    "file_format",
    default="png",
    type=OneOf(["png", "svg", "pdf"]),
    help="Format [default: png].",
)
@option(
    Part.OUTPUT, "--label", "labels", multiple=True, metavar="TEXT", help="Name in the legend, once for each RESULTS."
)
@option(Part.WHAT, "--from", "start", type=AnyNumber("s"), metavar="T", help="Begin at this time in s.")
@option(Part.WHAT, "--to", "stop", type=AnyNumber("s"), metavar="T", help="End at this time in s.")
@option(
    Part.WHAT,
    "--at",
    "times",
    type=Several(NotNegative("s")),
    metavar="T[,T..]",
    help="Times in s of the poses that the kind mechanism shows.",
)
@option(Part.WHAT, "--marker", "markers", multiple=True, metavar="NAME", help="Only this marker, repeatable.")
@option(Part.WHAT, "--joint", "joints", multiple=True, metavar="NAME", help="Only this joint, repeatable.")
@option(
    Part.WHAT,
    "--of",
    "of",
    multiple=True,
    metavar="NAME",
    help="Only this force, motion, stop or friction, or measure of a sweep, repeatable.",
)
@option(
    Part.WHAT,
    "--over",
    "over",
    multiple=True,
    metavar="NAME",
    help="For sweeps: over this quantity, repeatable, in order. For runs: over this coordinate JOINT.COORDINATE.",
)
@option(Part.WHAT, "--per-turn", is_flag=True, help="With --over of runs: an angle modulo a turn.")
@option(
    Part.WHAT,
    "--transmission",
    "corners",
    type=Corners(),
    multiple=True,
    metavar="A,B,C",
    help="Transmission angle at marker B, between the lines to A and C, repeatable.",
)
@option(
    Part.ACCURACY,
    "--error",
    "limit",
    type=Positive("m"),
    metavar="E",
    help="Mark where a certified run may be off by E.",
)
@force_option
@look
def command(
    results: tuple[Path, ...],
    kinds: tuple[str, ...],
    directory: Path,
    file_format: str,
    labels: tuple[str, ...],
    start: float | None,
    stop: float | None,
    times: tuple[float, ...] | None,
    markers: tuple[str, ...],
    joints: tuple[str, ...],
    of: tuple[str, ...],
    over: tuple[str, ...],
    per_turn: bool,
    corners: tuple[tuple[str, str, str], ...],
    limit: float | None,
    force: bool,
) -> None:
    """Draws pictures of RESULTS; several files go into the same pictures.

    Writes DIR/<first file>-<kind>.<format> and prints the paths. All kinds that apply are drawn unless --kind names
    some. Files of modes have kinds of their own: eigenvalues, shapes, traces; linear models have bode. RESULTS may be
    the folder of a sweep or of a design, which have their own kinds too. For a run with error control, `--kind steps`
    tells which body or force limits its smaller steps.
    """
    from mbproj.results.analysis.tables import MANY
    from mbproj.results.output_files import check_replaceable, make_folder, picture
    from mbproj.show.figures.kinds import draw, nothing_to_see, why_not
    from mbproj.show.figures.rows import derive_labels, stem
    from mbproj.show.figures.style import save

    of_runs: dict[str, object] = {
        "--label": labels,
        "--from": start,
        "--to": stop,
        "--at": times,
        "--marker": markers,
        "--joint": joints,
        "--error": limit,
        "--per-turn": per_turn or None,
        "--transmission": corners,
    }
    options = [name for name, value in {**of_runs, "--of": of, "--over": over}.items() if value not in (None, ())]
    for kind_of_file in (DESIGN, SWEEP, LINEAR):
        if any(map(kind_of_file.is_one, results)) or (kind_of_file is SWEEP and len(over) > 1):
            draw_pictures(kind_of_file, results, kinds, directory, file_format, of, over, options, force=force)
            return
    kinds = (*kinds, "transmission") if corners and "transmission" not in kinds else kinds
    _check(results, kinds, labels, times or ())
    if per_turn and not over:
        raise click.UsageError("--per-turn is for --over; add --over, or leave it out")
    if "transmission" in kinds and not corners:
        raise InputError(Problem("--kind transmission: it needs three markers", hint="add --transmission A,B,C"))
    files = [open_with_note(path) for path in results]
    names = list(labels) or derive_labels(files)
    first = stem(files[0])
    shown = selected(files, start, stop, markers, joints, of)
    if over:
        whole = selected(files, start, stop)
        shown = [each.over(over[0], modulo=per_turn, of=one) for each, one in zip(shown, whole, strict=True)]
    for three in corners:
        require_markers(three, files)
    able = [kind for kind, entry in KINDS.items() if entry.by_default or kind in kinds]
    drawn = _applicable(kinds, {kind: why_not(kind, shown) for kind in able})
    drawn = drawn if kinds else _with_something_to_see(drawn, {kind: nothing_to_see(kind, shown) for kind in drawn})
    make_folder(directory, OTHER_DIRECTORY)
    paths = {kind: directory / f"{first}-{kind}.{file_format}" for kind in drawn}
    for path in paths.values():  # check all files before the first is written
        check_replaceable(path, picture(file_format), force=force, hint=OTHER_DIRECTORY)
    for kind, path in paths.items():
        figure = draw(kind, shown, names, limit, times or (), corners)
        if kind == "steps" and kind in kinds:
            _report_step_limits(shown, figure)
        click.echo(save(figure, path, force=force))
        del figure
        if any(len(result.time) >= MANY for result in shown):
            # figures are in reference cycles: without this, lines of a million samples would stay in memory
            gc.collect()


def _report_step_limits(results: Sequence[Results], figure: Figure) -> None:
    """Tell what limited the steps of a single run with error control: below the panels, and as a table."""
    from mbproj.commands.report import step_limits
    from mbproj.show.figures.panels import small_print

    if len(results) > 1 or results[0].settings.tolerance is None:
        return
    try:
        limits = step_limits.limits_of(results[0])
    except InputError as error:
        click.echo(f"note: what limits the steps cannot be told: {error.problems[0].message}", err=True)
        return
    small_print(figure, step_limits.remark(limits))
    click.echo("\n".join(step_limits.table(results[0], limits)), err=True)


def _check(results: Sequence[Path], kinds: Sequence[str], labels: Sequence[str], times: Sequence[float]) -> None:
    for kind in kinds:
        if kind not in KINDS:
            raise InputError(Problem(f"--kind: unknown kind '{kind}'", hint=choose_from(kind, KINDS)))
    if labels and len(labels) != len(results):
        message = f"--label: {len(labels)} for {len(results)} results"
        raise InputError(Problem(message, hint="give one for each file, in their order, or none"))
    if times and not any(KINDS[kind].takes == "times" for kind in kinds):
        raise InputError(Problem("--at is for --kind mechanism alone", hint="add --kind mechanism, or leave it out"))


def _applicable(kinds: Sequence[str], reasons: dict[str, str | None]) -> list[str]:
    """The kinds to draw. A kind that does not apply is an error where it was asked for; otherwise it is left out with a
    note."""
    for kind in kinds:
        if reasons[kind]:
            raise InputError(Problem(f"--kind {kind}: {reasons[kind]}", hint=_hint(reasons)))
    if kinds:
        return list(dict.fromkeys(kinds))
    for kind, reason in reasons.items():
        if reason and KINDS[kind].usual:
            click.echo(f"note: no picture '{kind}': {reason}", err=True)
    return [kind for kind, reason in reasons.items() if not reason]


def _with_something_to_see(applicable: Sequence[str], reasons: dict[str, str | None]) -> list[str]:
    """The kinds that show something of interest, with a note on each other kind."""
    for kind in applicable:
        if reasons[kind]:
            click.echo(f"note: no picture '{kind}': {reasons[kind]}", err=True)
    return [kind for kind in applicable if not reasons[kind]]


def _hint(reasons: dict[str, str | None]) -> str:
    return "kinds that apply: " + ", ".join(kind for kind, reason in reasons.items() if not reason)
