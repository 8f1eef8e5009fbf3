"""`mbproj export`: results as CSV tables, for whatever reads no HDF5."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.errors import InputError, Problem
from mbproj.scene.suggestions import choose_from

if TYPE_CHECKING:
    from mbproj.analysis.tables import Table


@click.command("export")
@click.argument("results", type=click.Path(path_type=Path))
@click.option("-o", "--output", "folder", default=".", type=click.Path(path_type=Path), help="Directory (.).")
@click.option("--table", "chosen", multiple=True, metavar="NAME", help="Only this table, e.g. body-crank; repeatable.")
@click.option("--list", "only_list", is_flag=True, help="List the tables, write nothing.")
def command(results: Path, folder: Path, chosen: tuple[str, ...], only_list: bool) -> None:
    """Writes RESULTS as CSV: a table for each body, marker, joint, force and motion, and one of diagnostics.

    Files are DIR/<file>-<table>.csv. The first line names the columns and their units; numbers keep all their digits.
    """
    from mbproj.analysis.tables import tables
    from mbproj.results import open_results

    with open_results(results) as opened:
        found = {table.name: table for table in tables(opened)}
    for name in chosen:
        if name not in found:
            raise InputError(Problem(f"there is no table '{name}'", hint=choose_from(name, found)))
    for name in chosen or found:
        if only_list:
            click.echo(name)
        else:
            click.echo(_write(found[name], folder / f"{results.name.split('.')[0]}-{name}.csv"))


def _write(table: Table, path: Path) -> Path:
    lines = [",".join(table.headings)]
    lines += [",".join(f"{value:.17g}" for value in row) for row in table.values.tolist()]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        problem = Problem(f"cannot write '{path}': {error.strerror or error}", hint="choose another directory with -o")
        raise InputError(problem) from error
    return path
