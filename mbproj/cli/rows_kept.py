"""The report on the rows of energy and momenta in the projections of a run."""

from __future__ import annotations

from mbproj.integrate.reporting.report import Report
from mbproj.scene.records import ProjectionSettings
from mbproj.thresholds import THRESHOLDS


def lines_on_rows(report: Report) -> list[str]:
    """How often the rows were closed, the energy that they gave, and the steps without them. Empty where a run has no
    such rows."""
    projection, rows = report.settings.projection, report.rows
    if not (projection.energy or projection.momentum):
        return []
    asked = " and ".join(["energy"] * projection.energy + [momenta(rows.momenta)] * projection.momentum)
    left = [f"left at {rows.rest} near rest"] * bool(rows.rest) + [f"refused at {rows.refused}"] * bool(rows.refused)
    if not (rows.steps or left):
        return [f"  rows of {asked}: nothing is free to move that they could correct"]
    gave = f"; gave {rows.given:.2e} J, {rows.moved:.2e} J in sum" if projection.energy else ""
    largest = f"; changed the velocities by {rows.largest:.1e} of them at most"
    return [f"  rows of {asked}: closed at {rows.steps} steps{''.join(f', {each}' for each in left)}{gave}{largest}"]


def projection_words(projection: ProjectionSettings) -> str:
    """The projection method, with the rows of energy and momenta that it keeps."""
    rows = ["energy row"] * projection.energy + ["momentum rows"] * projection.momentum
    return projection.method + (f" with {' and '.join(rows)}" if rows else "")


def momenta(number: int) -> str:
    """The number of momenta that are kept, in words."""
    return f"{number or 'no'} moment{'um' if number == 1 else 'a'}"


def _given(report: Report) -> str:
    rows = report.rows
    if report.degrees_of_freedom == 1:
        return f"the energy row gave or took {rows.moved / rows.steps:.2g} J a step"
    return f"the energy row gave or took up to {rows.furthest:.2g} J in sum"


def warnings_on_rows(report: Report) -> list[str]:
    """Warnings where these rows may hide a wrong motion, or correct nothing."""
    projection, rows = report.settings.projection, report.rows
    found = []
    if rows.refused:
        found.append(
            f"the rows of energy and momenta were refused at {rows.refused} of {rows.steps + rows.rest + rows.refused} "
            f"steps: there they asked for more than {100 * THRESHOLDS.row_refused:g} % of what the step changed; the "
            "motion may be wrong; take a smaller --step or --tolerance"
        )
    if report.hidden > 1.0:
        found.append(
            f"{_given(report)}, where the run exchanged {report.exchanged:.2g} J: the motion may be wrong although the "
            "balance is kept; take a smaller --step or --tolerance"
        )
    if projection.momentum and not rows.momenta and not projection.energy:
        found.append("joints to the ground, gravity or forces act on every momentum: --momentum-row keeps none")
    return found
