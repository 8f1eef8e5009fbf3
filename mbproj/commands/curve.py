"""`mbproj curve` and `mbproj.curve`: the profile of a curve of a scene, as a table and a picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import degrees, inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click

from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.figure_options import check_picture, plot_option
from mbproj.commands.kinds import Count
from mbproj.commands.options import (
    NOTHING,
    Argument,
    File,
    Option,
    Part,
    force_option,
    json_option,
    output_option,
    quiet_option,
)
from mbproj.commands.report.text import json_text, table
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.scenes import CURVE

if TYPE_CHECKING:
    from mbproj.commands.arguments import SceneLike
    from mbproj.scene.blocks.curve_sheet import Sheet

EXAMPLES = (
    ("The cam's pressure angle, curvature and largest roller.", "mbproj curve cam.yaml lift"),
    ("The profile for the workshop, and a picture of it.", "mbproj curve cam.yaml lift -o lift.csv --plot lift.png"),
)
Name = Annotated["str | None", Argument()]
Rows = Annotated[
    int,
    Option(Part.WHAT, "Rows of the table, from the beginning of the curve to its end.", Count(2, 1_000_000), "N"),
]


@declared
def curve(
    scene: SceneLike,
    name: Name = None,
    *,
    rows: Rows = 361,
    parameters: Mapping[str, object] = NOTHING,
) -> Sheet:
    """Shows a curve of a scene: profile, pressure angle, curvature, largest roller.

    NAME is that of the curve; a scene with a single one needs none. The pressure angle is that of a follower that moves
    on a line through the origin of the curve. Lengths of the table are in m, angles in rad.

    In Python `columns()` of the result is the table. Raises InputError for an unknown name.
    """
    from mbproj.scene.blocks.curve_sheet import sheet_of

    asked = read(curve, locals())
    return sheet_of(asked.scene, asked.name, asked.rows)


OUTPUT = output_option(None, File(".csv", path_type=Path), "CSV table of the profile.")


@command_of(curve, EXAMPLES, OUTPUT, plot_option, json_option, quiet_option, force_option)
def command(
    asked: Asked[Sheet], output: Path | None, picture_path: Path | None, as_json: bool, quiet: bool, force: bool
) -> None:
    from mbproj.results.output_files import check_replaceable, csv
    from mbproj.results.table_files import write_csv

    kind = csv(["arc length (m)"])
    if output is not None:
        check_replaceable(output, kind, force=force)
    check_picture(picture_path, force=force)
    sheet = asked.result()
    columns = sheet.columns()
    if as_json:
        click.echo(json_text(facts(sheet)))
    elif not quiet:
        click.echo("\n".join(lines(sheet)))
    if output is not None:
        values = [list(row) for row in zip(*(column.tolist() for column in columns.values()), strict=True)]
        write_csv(output, list(columns), values, form=".17g", kind=kind, force=force)
    if picture_path is not None:
        from mbproj.show.figures.designs import draw_profile
        from mbproj.show.figures.style import save

        save(draw_profile(sheet), picture_path, force=force)
    for path in (output, picture_path):
        if path is not None and not (as_json or quiet):
            click.echo(path)


def facts(sheet: Sheet) -> dict[str, object]:
    """The curve as a dictionary for JSON."""
    return report_of(
        CURVE,
        sheet,
        length=sheet.arc[-1],
        largest_pressure_angle=sheet.pressure.max() if sheet.closed else None,
        largest_roller=sheet.rollers,
        table=sheet.columns(),
    )


def lines(sheet: Sheet) -> Iterator[str]:
    """Yield the numbers that decide whether a cam can be made and moved."""
    kind = "closed" if sheet.closed else "open"
    yield f"curve '{sheet.name}': {kind}, {1e3 * sheet.arc[-1]:.6g} mm long"
    said = {"radius": f"{1e3 * sheet.radius.min():.6g} to {1e3 * sheet.radius.max():.6g} mm about the origin"}
    if sheet.closed:
        worst = int(sheet.pressure.argmax())
        where = f" at {degrees(sheet.angle[worst]) % 360.0:.4g} deg" if sheet.pressure[worst] > 0.0 else ""
        said["pressure angle"] = f"up to {degrees(sheet.pressure[worst]):.4g} deg{where}"
    least, largest = sheet.bends
    said["curvature"] = f"{1e-3 * least:.4g} to {1e-3 * largest:.4g} per mm"
    for side, radius in sheet.rollers.items():
        said[f"largest roller {side}"] = "any" if radius == inf else f"{1e3 * radius:.4g} mm"
    yield from table(said, "  ")
