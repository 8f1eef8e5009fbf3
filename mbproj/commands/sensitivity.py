"""`mbproj sensitivity`: how much numbers of a scene change its expectations."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.commands import study_options
from mbproj.commands.figure_options import check_picture, plot_option
from mbproj.commands.options import Part, QuantityNames, explained, option, scene_file
from mbproj.commands.report.text import json_text

if TYPE_CHECKING:
    from mbproj.results.views import Table

EXAMPLES = (
    (
        "See which parameters matter for what the scene expects.",
        "mbproj sensitivity planar_four_bar.yaml --to crank,coupler",
    ),
    ("The same as bars.", "mbproj sensitivity planar_four_bar.yaml --to crank,coupler --plot bars.png"),
)


@explained("sensitivity", EXAMPLES)
@click.argument("scene", type=scene_file())
@option(
    Part.WHAT,
    "--of",
    type=QuantityNames(),
    metavar="A,B,..",
    help="Expectations by name [default: all but diagnostics].",
)
@option(
    Part.WHAT,
    "--to",
    type=QuantityNames(),
    metavar="A,B,..",
    help="Parameters, or numbers by their paths [default: parameters].",
)
@study_options.changes
@study_options.workplace
@study_options.write_table_option
@plot_option
@study_options.force
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the table.")
def command(
    scene: str,
    of: tuple[str, ...] | None,
    to: tuple[str, ...] | None,
    changes: tuple[str, ...],
    jobs: int | None,
    scheduler: str | None,
    scheduler_file: Path | None,
    table_file: Path | None,
    picture_path: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Measures how much numbers of SCENE change what it expects.

    Prints a table with the value of each measure, its derivative by each number with the error of that, and the
    elasticity: by how many percent the measure changes where the number changes by one. Dual numbers that follow one
    run give the slopes; where they cannot, differences of runs do, and the output says why.
    """
    from mbproj.commands.options import parameters
    from mbproj.commands.report.text import columns
    from mbproj.results.table_files import check_table, write_table
    from mbproj.scene.scene import read_scene
    from mbproj.studies.design.sensitivity import LEFT_OUT, sensitivities
    from mbproj.studies.parallel.cluster import workplace

    check_table(table_file, ("measure", "number"), force=force)
    check_picture(picture_path, force=force)
    what, where = read_scene(scene, parameters(changes)), workplace(jobs, scheduler, scheduler_file)
    table = sensitivities(what, of or (), to or (), where).table
    if table_file is not None:
        write_table(table_file, table.headings, table.rows, force=force)
    if picture_path is not None:
        from mbproj.show.figures.designs import draw_sensitivities
        from mbproj.show.figures.style import save

        save(draw_sensitivities(table), picture_path, force=force)
    if as_json:
        click.echo(json_text([dict(zip(table.headings, row, strict=True)) for row in table.rows]))
        return
    headings = ["measure", "number", "value", "slope", "±", "elasticity", "unit of the slope"]
    click.echo(columns(headings, [_cells(row) for row in table.rows if row[7] != LEFT_OUT]))
    for line in _how(table):
        click.echo(line)
    for path in (table_file, picture_path):
        if path is not None:
            click.echo(path)


def _how(table: Table) -> Iterator[str]:
    """Yield lines on the method of the slopes, the reasons against dual numbers, and the numbers left out with their
    reasons."""
    from mbproj.studies.design.sensitivity import LEFT_OUT

    reasons: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for measure, number, *_, by, because in table.rows:
        reasons.setdefault((by, because), []).append((measure, number))
    numbers = {number: None for _, number, *_ in table.rows}
    for (by, because), pairs in reasons.items():
        varied = dict.fromkeys(number for _, number in pairs)
        of = dict.fromkeys(measure for measure, _ in pairs) if len(varied) == len(numbers) else {}
        what = f" of {', '.join(of)}" if of else f" by {', '.join(varied)}"
        reason = f", because {because}" if because else " along one run"
        if by == LEFT_OUT:
            yield f"{by}: {', '.join(varied)}{reason}"
        else:
            yield f"slopes{what if len(reasons) > 1 else ''}: {by}{reason}"


def _cells(row: tuple[Any, ...]) -> list[str]:
    measure, number, value, slope, uncertainty, elasticity, unit = row[:7]
    shown = "-" if elasticity != elasticity else f"{elasticity:+.4f}"
    return [measure, number, f"{value:.6g}", f"{slope:+.6g}", f"{uncertainty:.1e}", shown, unit]
