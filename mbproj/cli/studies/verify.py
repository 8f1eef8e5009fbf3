"""`mbproj verify`: what the paper's mathematics says, held against round-off on the user's own mechanism."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from mbproj.cli.completion import results_file
from mbproj.cli.explained import Part, explained, option
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
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(scene: str, settings: tuple[str, ...], store: Path | None, as_json: bool, **options: Any) -> int:
    """Checks the paper's mathematics on SCENE, against its round-off.

    The checks are Eqs. 75, 78 and 80-81, projectors, balances, invariance, and the integrator's order. Each
    difference is compared with a bound on the round-off of the same computation on this mechanism. Exit code 4: a
    check fails.
    """
    from mbproj.cli.report.progress import telling
    from mbproj.cli.report.verification import as_json as numbers
    from mbproj.cli.report.verification import lines
    from mbproj.results.verification import check_store
    from mbproj.results.verification import store as keep
    from mbproj.scene import read_scene
    from mbproj.studies.verify import verify

    what = read_scene(scene, parameters(settings), overrides(options))
    with placed_at(Place("--store")):
        if store is not None:
            check_store(store, what)
    with telling(hidden=False) as tell:
        found = verify(what, tell)
    if as_json:
        click.echo(json.dumps({"scene": scene, **numbers(found)}))
    else:
        click.echo("\n".join([what.title or Path(scene).stem, *lines(found)]))
    if store is not None:
        with placed_at(Place("--store")):
            keep(store, what, found)
        click.echo(f"stored in {store}", err=True)
    return int(ExitCode.DONE if found.holds else ExitCode.CHECK_FAILED)
