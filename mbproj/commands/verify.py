"""`mbproj verify`: the paper's mathematics, checked to round-off on the user's own mechanism."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli import study_options
from mbproj.cli.completion import results_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.figure_options import plot_option
from mbproj.cli.scene_options import overrides, parameters, scene_options_of
from mbproj.errors import ExitCode, Place, placed_at
from mbproj.report_schema import report_of
from mbproj.report_schema.designs import VERIFY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results.verification import Verification

EXAMPLES = (
    ("Check every claim that applies to the mechanism.", "mbproj verify five_bar.yaml"),
    ("Keep what was found in the results file of the scene.", "mbproj verify five_bar.yaml --store results.h5"),
)


@explained("verify", EXAMPLES)
@scene_options_of("verify")
@option(
    Part.OUTPUT,
    "--store",
    type=results_file(path_type=Path),
    metavar="RESULTS",
    help="Store the findings in a results file of this scene.",
)
@plot_option
@study_options.answer
def command(
    scene: str,
    settings: tuple[str, ...],
    store: Path | None,
    **options: Any,
) -> int:
    """Checks the paper's mathematics on SCENE, against its round-off.

    The checks are Eqs. 75, 78 and 80-81, projectors, balances, invariance, and the integrator's order. Each
    difference is compared with a bound on the round-off of the same computation on this mechanism. Exit code 4: a
    check fails.
    """
    from mbproj.cli.report.verification import lines
    from mbproj.cli.study import Study
    from mbproj.results.verification import check_store
    from mbproj.results.verification import store as keep
    from mbproj.scene import read_scene
    from mbproj.studies.verify import verify

    what = read_scene(scene, parameters(settings), overrides(options))
    with placed_at(Place("--store")):
        if store is not None:
            check_store(store, what)
    study = Study(options, ("name", "claim"))
    with study.telling() as tell:
        verification = verify(what, tell)
    text = "\n".join([what.title or Path(scene).stem, *lines(verification)])
    numbers = report_of(VERIFY, verification, scene=scene)
    study.hand_over(verification.table, text, numbers, lambda: _page(verification))
    if store is not None:
        with placed_at(Place("--store")):
            keep(store, what, verification)
        click.echo(f"stored in {store}", err=True)
    return int(ExitCode.DONE if verification.holds else ExitCode.CHECK_FAILED)


def _page(verification: Verification) -> Figure | str:
    """The page with the part of its bound that each check uses."""
    from mbproj.figures.pages.expectations import draw_expectations

    shares = {check.name: check.share for check in verification.checks if check.share == check.share}
    return draw_expectations(shares) if shares else "no check to draw"
