"""`mbproj verify`: the paper's mathematics, checked to round-off on the user's own mechanism."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import ExitCode, Place, placed_at
from mbproj.commands import study_options
from mbproj.commands.figure_options import plot_option
from mbproj.commands.options import Part, explained, option, overrides, parameters, results_file, scene_options_of
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import VERIFY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results.verification import Check, Verification


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
    from mbproj.commands.study import Study
    from mbproj.results.verification import check_store
    from mbproj.results.verification import store as keep
    from mbproj.scene.scene import read_scene
    from mbproj.studies.verify.checks import verify

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
    from mbproj.show.figures.studies import draw_expectations

    shares = {check.name: check.share for check in verification.checks if check.share == check.share}
    return draw_expectations(shares) if shares else "no check to draw"


# --- A verification as a table of text, and for JSON ------------------------------------------------------------------


HEADINGS = ("check", "what must hold", "measured", "allowed", "")


def lines(verification: Verification) -> Iterator[str]:
    """Yield the table with a line for each check, and the number of those that hold."""
    rows = [HEADINGS, *map(_row, verification.checks)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADINGS) - 1)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        cells[2:4] = [cell.rjust(width) for cell, width in zip(row[2:4], widths[2:4], strict=True)]
        yield "  " + "  ".join([*cells, row[-1]]).rstrip()
    counts = {verdict: len(verification.of(verdict)) for verdict in ("passed", "does not apply", "failed")}
    yield (
        f"  {counts['passed']} hold, {counts['does not apply']} do not apply, {counts['failed']} fail; "
        f"runs take the {verification.formulation} formulation"
    )


def _row(check: Check) -> tuple[str, ...]:
    if check.measured != check.measured:
        mark = "FAILS: " if check.verdict == "failed" else ""
        return check.name, check.claim, "-", "-", mark + check.remark
    form, sign = (".2f", "≥ ") if check.at_least else (".0e", "≤ ")
    mark = {"passed": "", "failed": "FAILS; "}[check.verdict]
    measured, allowed = format(check.measured, form), sign + format(check.allowed, form)
    return check.name, check.claim, measured, allowed, mark + check.remark
