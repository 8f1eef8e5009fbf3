"""`mbproj verify`: the paper's mathematics, checked to round-off on the user's own mechanism."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mbproj.cli import study_options
from mbproj.cli.completion import results_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.report.text import json_text
from mbproj.cli.scene_options import overrides, parameters, scene_options
from mbproj.errors import ExitCode, Place, placed_at

EXAMPLES = (
    ("Check every claim that applies to the mechanism.", "mbproj verify five_bar.yaml"),
    ("Keep what was found in the results file of the scene.", "mbproj verify five_bar.yaml --store results.h5"),
)


@explained("verify", EXAMPLES)
@scene_options
@option(
    Part.OUTPUT,
    "--store",
    type=results_file(path_type=Path),
    metavar="RESULTS",
    help="Store the findings in a results file of this scene.",
)
@study_options.write_table
@study_options.force
@study_options.as_json
def command(
    scene: str,
    settings: tuple[str, ...],
    store: Path | None,
    table_file: Path | None,
    force: bool,
    as_json: bool,
    **options: Any,
) -> int:
    """Checks the paper's mathematics on SCENE, against its round-off.

    The checks are Eqs. 75, 78 and 80-81, projectors, balances, invariance, and the integrator's order. Each
    difference is compared with a bound on the round-off of the same computation on this mechanism. Exit code 4: a
    check fails.
    """
    from mbproj.cli.report.progress import telling
    from mbproj.cli.report.verification import as_json as numbers
    from mbproj.cli.report.verification import lines
    from mbproj.outputs.written_table import check_table, write_table
    from mbproj.results.verification import check_store
    from mbproj.results.verification import store as keep
    from mbproj.scene import read_scene
    from mbproj.studies.verify import verify

    what = read_scene(scene, parameters(settings), overrides(options))
    with placed_at(Place("--store")):
        if store is not None:
            check_store(store, what)
    check_table(table_file, ("name", "claim"), force=force)
    with telling(hidden=False) as tell:
        found = verify(what, tell)
    if as_json:
        click.echo(json_text({"scene": scene, **numbers(found)}))
    else:
        click.echo("\n".join([what.title or Path(scene).stem, *lines(found)]))
    if table_file is not None:
        click.echo(write_table(table_file, found.table.headings, found.table.rows, force=force), err=True)
    if store is not None:
        with placed_at(Place("--store")):
            keep(store, what, found)
        click.echo(f"stored in {store}", err=True)
    return int(ExitCode.DONE if found.holds else ExitCode.CHECK_FAILED)
