"""`mbproj verify` and `mbproj.verify`: the paper's mathematics, checked to round-off on the user's own mechanism."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import ExitCode, Place, placed_at
from mbproj.commands.declared import Asked, Told, declared, read, study_command
from mbproj.commands.figure_options import plot_option
from mbproj.commands.options import NOTHING, Part, RunSettings, option, results_file
from mbproj.commands.study_options import answer
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import VERIFY
from mbproj.studies.parallel.progress import Tell, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from mbproj.commands.arguments import SceneLike
    from mbproj.results.verification import Check, Verification


@declared
def verify(
    scene: SceneLike,
    progress: Tell = silent,
    *,
    parameters: Mapping[str, object] = NOTHING,
    **settings: Unpack[RunSettings],
) -> Verification:
    """Checks the paper's mathematics on a scene, against its round-off.

    The checks are Eqs. 75, 78 and 80-81, projectors, balances, invariance, and the integrator's order. Each
    difference is compared with a bound on the round-off of the same computation on this mechanism. Exit code 4: a
    check fails.

    In Python `progress` is called with the phase, the number of checks done, and the number of all. Raises InputError
    where the mechanism cannot be assembled or run at all, SimulationError where a function of the scene has no value at
    the start.
    """
    from mbproj.studies.verify import checks

    return checks.verify(read(verify, locals()).scene, progress)


EXAMPLES = (
    ("Check every claim that applies to the mechanism.", "mbproj verify five_bar.yaml"),
    ("Keep what was found in the results file of the scene.", "mbproj verify five_bar.yaml --store results.h5"),
)
STORE = option(
    Part.OUTPUT,
    "--store",
    type=results_file(path_type=Path),
    metavar="RESULTS",
    help="Store the findings in a results file of this scene.",
)


def _before(asked: Asked[Any]) -> None:
    from mbproj.results.verification import check_store

    if asked.typed["store"] is not None:
        with placed_at(Place("--store")):
            check_store(asked.typed["store"], asked.scene)


def _told(asked: Asked[Any], verification: Verification) -> Told:
    return Told(
        verification.table,
        "\n".join([asked.scene.title or Path(asked.path).stem, *lines(verification)]),
        report_of(VERIFY, verification, scene=asked.path),
        lambda: _page(verification),
        code=ExitCode.DONE if verification.holds else ExitCode.CHECK_FAILED,
    )


def _after(asked: Asked[Any], verification: Verification) -> None:
    from mbproj.results.verification import store

    path = asked.typed["store"]
    if path is not None:
        with placed_at(Place("--store")):
            store(path, asked.scene, verification)
        click.echo(f"stored in {path}", err=True)


command = study_command(
    verify,
    EXAMPLES,
    _told,
    first=("name", "claim"),
    files=(STORE, plot_option, answer),
    before=_before,
    after=_after,
)


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
