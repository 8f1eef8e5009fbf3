"""`mbproj export`: results as CSV tables, and scenes as models of other formats, for programs that read those."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.base.errors import ExitCode, InputError, Problem
from mbproj.commands.options import Corners, FolderPath, Part, explained, option, results_file
from mbproj.commands.study_options import force as force_option

if TYPE_CHECKING:
    from mbproj.results.record import Results

EXAMPLES = (
    ("Write every table.", "mbproj export results.h5 -o tables"),
    ("Write the largest loads for a report in LaTeX.", "mbproj export results.h5 --table loads --format latex"),
    ("Write a scene as a model of MuJoCo.", "mbproj export five_bar.yaml --mjcf five_bar.xml"),
)
ANOTHER_FILE = "choose another file"


@explained("export", EXAMPLES)
@click.argument("results", metavar="FILE", type=results_file(path_type=Path))
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    "folder",
    default=".",
    type=FolderPath(path_type=Path),
    help="Output directory [default: .].",
)
@option(
    Part.WHAT, "--table", "chosen", multiple=True, metavar="NAME", help="Only this table, e.g. body-crank; repeatable."
)
@option(
    Part.OUTPUT,
    "--format",
    "file_format",
    default="csv",
    type=click.Choice(["csv", "latex"]),
    help="A CSV table, or a tabular for LaTeX [default: csv].",
)
@option(
    Part.WHAT, "--over", metavar="JOINT.COORDINATE", help="Begin each table with this coordinate, and add its ratios."
)
@option(Part.WHAT, "--per-turn", is_flag=True, help="With --over: an angle modulo a turn.")
@option(
    Part.WHAT,
    "--transmission",
    type=Corners(),
    multiple=True,
    metavar="A,B,C",
    help="Add the transmission angle at marker B, between the lines to A and C; repeatable.",
)
@option(Part.OUTPUT, "--list", "only_list", is_flag=True, help="List the tables, write nothing.")
@option(Part.WHAT, "--mjcf", type=click.Path(path_type=Path), metavar="MODEL", help="For a scene: write it as MJCF.")
@option(
    Part.WHAT,
    "--urdf",
    type=click.Path(path_type=Path),
    metavar="MODEL",
    help="For a scene: write it as URDF, with its loops in a YAML file beside it.",
)
@option(
    Part.WHAT, "--set", "settings", multiple=True, metavar="NAME=VALUE", help="For a scene: change a value; repeatable."
)
@option(Part.OUTPUT, "--strict", is_flag=True, help="For a scene: end with 4 where the model's motion is another one.")
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="For a scene: print the table as one JSON object.")
@force_option
def command(
    results: Path,
    folder: Path,
    chosen: tuple[str, ...],
    file_format: str,
    over: str | None,
    per_turn: bool,
    transmission: tuple[tuple[str, str, str], ...],
    only_list: bool,
    mjcf: Path | None,
    urdf: Path | None,
    settings: tuple[str, ...],
    strict: bool,
    as_json: bool,
    force: bool,
) -> int:
    """Writes results as CSV or LaTeX tables, or a scene as MJCF or URDF.

    There is a table for each body, marker, joint, force and motion, one of the largest loads, and one of diagnostics.
    Files are DIR/<file>-<table>.csv or .tex. The first line names the columns and their units; numbers keep all their
    digits in CSV, and six in LaTeX.

    A model of a scene starts at the assembled start. A table tells what the format lacks, and whether the motion of the
    model is still that of the scene.
    """
    models = {kind: path for kind, path in (("mjcf", mjcf), ("urdf", urdf)) if path is not None}
    if models:
        return export_models(results, settings, models, strict=strict, as_json=as_json, force=force)
    if settings or strict or as_json:
        problem = Problem("--set, --strict and --json are of a scene", hint="add --mjcf FILE or --urdf FILE")
        raise InputError(problem)
    if per_turn and over is None:
        raise click.UsageError("--per-turn is for --over; add --over, or leave it out")
    from mbproj.results.reader import open_results

    with open_results(results) as opened:
        shown = opened if over is None else opened.over(over, modulo=per_turn)
        _tables(shown, folder, chosen, file_format, transmission, only_list, force)
    return ExitCode.DONE


def _tables(
    shown: Results,
    folder: Path,
    chosen: tuple[str, ...],
    file_format: str,
    corners: tuple[tuple[str, str, str], ...],
    only_list: bool,
    force: bool,
) -> None:
    from mbproj.commands.python.files import checked_name, write_tables
    from mbproj.results.analysis.tables import tables

    if only_list:
        by_name = {table.name: table for table in tables(shown, corners)}
        click.echo("\n".join([checked_name(by_name, name) for name in chosen] or by_name))
        return
    for path in write_tables(shown, folder, chosen, file_format, corners, force=force).values():
        click.echo(path)


def export_models(
    scene: Path, settings: tuple[str, ...], models: dict[str, Path], *, strict: bool, as_json: bool, force: bool
) -> ExitCode:
    """Write the scene as these models, by format, all or none, and print their tables.

    Raises InputError where a file may not be replaced, or the scene cannot be assembled."""
    from mbproj.base.version import __version__
    from mbproj.commands.import_model import table_json, table_lines
    from mbproj.commands.options import parameters
    from mbproj.formats.export.exported import Written
    from mbproj.formats.export.mjcf import as_mjcf
    from mbproj.formats.export.urdf import as_urdf
    from mbproj.formats.mechanism import Same
    from mbproj.results.output_files import LOOPS, MODEL, check_replaceable, write_text
    from mbproj.scene.scene import read_scene

    for path in models.values():
        check_replaceable(path, MODEL, force=force, hint=ANOTHER_FILE)
    what = read_scene(str(scene), parameters(settings))
    makers = {"mjcf": as_mjcf, "urdf": as_urdf}
    written: dict[str, Written] = {kind: makers[kind](what, __version__) for kind in models}
    files: list[tuple[str, Path, str]] = []
    for kind, path in models.items():
        files.append((kind, path, written[kind].text))
        if written[kind].loops:
            beside = path.with_suffix(".yaml")
            if beside.resolve() == scene.resolve():
                problem = f"the loops of '{path}' belong in '{beside}', which is the scene"
                raise InputError(Problem(problem, hint="give the model another name"))
            files.append(("loops", beside, written[kind].loops))
    for kind, path, _ in files:
        if kind == "loops":
            check_replaceable(path, LOOPS, force=force, hint=ANOTHER_FILE)
    for kind, path, text in files:
        write_text(path, text, LOOPS if kind == "loops" else MODEL, force=force)
    said = [row for each in written.values() for row in each.said]
    if as_json:
        click.echo(table_json(said, files=[str(path) for _, path, _ in files]))
    else:
        for kind, each in written.items():
            everything = f"everything in the scene has its counterpart in the {kind.upper()}"
            for line in table_lines(each.said, everything):
                click.echo(line)
        for _, path, _ in files:
            click.echo(str(path))
    if strict and any(row.same is Same.NO for row in said):
        return ExitCode.CHECK_FAILED
    return ExitCode.DONE
