"""`mbproj export`: results as CSV tables, for programs that do not read HDF5."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.cli.completion import Folder, results_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.study_options import force as force_option
from mbproj.errors import InputError, Problem
from mbproj.scene.text.suggestions import choose_from

OTHER_DIRECTORY = "choose another directory with -o"
EXAMPLES = (
    ("Write every table.", "mbproj export results.h5 -o tables"),
    ("Write the largest loads for a report in LaTeX.", "mbproj export results.h5 --table loads --format latex"),
    (
        "Write the motion of one marker, and the diagnostics.",
        "mbproj export results.h5 --table marker-tip --table diagnostics",
    ),
)


@explained("export", EXAMPLES)
@click.argument("results", type=results_file(path_type=Path))
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    "folder",
    default=".",
    type=Folder(path_type=Path),
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
@option(Part.OUTPUT, "--list", "only_list", is_flag=True, help="List the tables, write nothing.")
@force_option
def command(
    results: Path, folder: Path, chosen: tuple[str, ...], file_format: str, only_list: bool, force: bool
) -> None:
    """Writes RESULTS as CSV tables, or as tables for LaTeX.

    There is a table for each body, marker, joint, force and motion, one of the largest loads, and one of
    diagnostics. Files are DIR/<file>-<table>.csv or .tex. The first line names the columns and their units; numbers
    keep all their digits in CSV, and six in LaTeX.
    """
    from mbproj.analysis.tables import tables
    from mbproj.figures.labels import stem
    from mbproj.outputs import check_replaceable, csv, latex, make_folder, write_csv, write_latex
    from mbproj.results import open_results

    with open_results(results) as opened:
        found, first = {table.name: table for table in tables(opened)}, stem(opened)
        for name in chosen:
            if name not in found:
                raise InputError(Problem(f"there is no table '{name}'", hint=choose_from(name, found)))
        names = list(chosen or found)
        if only_list:
            click.echo("\n".join(names))
            return
        make_folder(folder, OTHER_DIRECTORY)
        is_csv = file_format == "csv"
        ending = "csv" if is_csv else "tex"
        files = {folder / _file_name(f"{first}-{name}.{ending}"): found[name] for name in names}
        for path, table in files.items():  # all or none
            kind = csv(table.headings) if is_csv else latex()
            check_replaceable(path, kind, force=force, hint=OTHER_DIRECTORY)
        write, form = (write_csv, ".17g") if is_csv else (write_latex, ".6g")
        for path, table in files.items():
            click.echo(write(path, table.headings, table.rows(), form=form, force=force, hint=OTHER_DIRECTORY))


def _file_name(name: str) -> str:
    """The name, which comes from a file that anybody may have written, where it is that of a file and no path."""
    if set(name) & {"/", "\\", "\0"}:
        problem = Problem(f"'{name}' cannot name a file", hint="the results were changed after mbproj wrote them")
        raise InputError(problem)
    return name
