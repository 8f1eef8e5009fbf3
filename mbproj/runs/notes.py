"""The notes on a run that has ended: what puts its motion in doubt, and what would make it better."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.dynamics.equations.round_off import EPSILON, HARDLY_ANY
from mbproj.integrate.reporting.report import Report
from mbproj.registry import is_explicit
from mbproj.results.notes import Note
from mbproj.thresholds import THRESHOLDS

#: The violation above which a note tells that joints were open, relative to the coordinates in the rows.
FAR_OPEN = 1e-4
#: The most short movements that are named.
MOST_NAMED = 6


def notes_on(report: Report) -> Iterator[Note]:
    """Yield the notes that a user should not overlook."""
    if report.stiffness:
        # Errors grow in fixed explicit steps alone: else the note is on small steps, or on vibration that is damped.
        fixed = report.settings.step is not None and is_explicit(report.settings.integrator)
        yield Note(report.stiffness, doubts_motion=fixed)
    if report.passed:
        yield Note(
            f"fixed steps passed over edges of laws, from which the motion is pushed back ({report.passed}): no method "
            "keeps its order there; 'coulomb' of a friction on the joint sticks"
        )
    if report.shared:
        yield Note(
            f"contacts share a load arbitrarily ({report.shared}): the motion does not determine these forces, and the "
            "recorded ones are one share of many"
        )
    if report.halved:
        yield Note(
            f"fixed steps were halved {report.halved}: Newton's method did not solve them whole; a smaller step, or a "
            "tolerance in its place, does without"
        )
    if report.decided_by_shares:
        yield _doubt(
            f"the motion depends on how these share their load, which rigid bodies leave open: "
            f"{report.decided_by_shares}; they share as springs of one stiffness do. Make the stops compliant with "
            "'stiffness', or use three points"
        )
    if report.crowded:
        yield Note(
            f"{', '.join(report.crowded)}: more kinks in time than count; steps end at the first "
            f"{THRESHOLDS.most_kinks:,} of each, and meet later ones anywhere"
        )
    if report.unresolved:
        yield Note(
            f"{'; '.join(report.unresolved[:MOST_NAMED])}: fixed steps do not resolve what happens there, though "
            "they are split; take a tolerance in place of a step"
        )
    yield from notes_on_rows(report)
    if report.drifts:
        yield _doubt(
            f"the energy drifted by {100 * report.drift_of_exchanged:.2g} %: the motion may be wrong "
            "although the joints are closed; compare with a smaller step, or with the integrator dop853 at a "
            "tolerance of 1e-10"
        )
    open_by = report.position_violation
    if open_by.value > FAR_OPEN * report.position_floor / EPSILON:
        yield _doubt(
            f"{open_by.owner} was open by {open_by.value:.2g} (m, rad) at t = {open_by.time:.4g} s: this is not "
            "the mechanism's motion; use a projection method, gpopm for example, or a smaller step"
        )
    asked = report.settings.projection.tolerance
    if asked is not None and report.settings.projection.test == "violation" and asked < report.position_floor:
        yield Note(
            f"the projection's tolerance of {asked:.0e} is below round-off, {report.position_floor:.0e}: the "
            "iterations stop where the violation falls no further"
        )
    finest = report.settings.tolerance
    if finest is not None and finest < report.round_off:
        yield Note(
            f"the tolerance of {finest:.0e} is below what round-off leaves of positions, {report.round_off:.0e} of the "
            "mechanism's length: smaller steps make nothing more accurate"
        )
    if report.swamped:
        from mbproj.dynamics.rank.massless import SHOWN

        yield _doubt(
            f"round-off of the other bodies' forces decides motions with less than {HARDLY_ANY:.0e} of the "
            f"largest inertia: {'; '.join(report.swamped[:SHOWN])}; give these bodies more inertia, or joints that "
            "hold them"
        )
    if report.counters["projection_failures"]:
        yield Note(
            f"{report.counters['projection_failures']} projections missed their tolerance; the largest violation "
            f"is {report.position_violation.value:.1e}"
        )


def notes_on_rows(report: Report) -> Iterator[Note]:
    """Yield notes where the rows of energy and momenta may hide a wrong motion, or correct nothing."""
    projection, rows = report.settings.projection, report.rows
    if rows.refused:
        yield _doubt(
            f"the rows of energy and momenta were refused at {rows.refused} of {rows.steps + rows.rest + rows.refused} "
            f"steps: there they asked for more than {100 * THRESHOLDS.row_refused:g} % of what the step changed; the "
            "motion may be wrong; take a smaller step or tolerance"
        )
    if report.hidden > 1.0:
        per_step = f"the energy row gave or took {rows.moved / rows.steps:.2g} J a step"
        in_sum = f"the energy row gave or took up to {rows.furthest:.2g} J in sum"
        yield _doubt(
            f"{per_step if report.degrees_of_freedom == 1 else in_sum}, where the run exchanged "
            f"{report.exchanged:.2g} J: the motion may be wrong although the balance is kept; take a smaller step or "
            "tolerance"
        )
    if projection.momentum and not rows.momenta and not projection.energy:
        yield Note("joints to the ground, gravity or forces act on every momentum: its rows keep none")


def _doubt(text: str) -> Note:
    return Note(text, doubts_motion=True)
