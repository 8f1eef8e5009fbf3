"""The summary of a run in words, with the report on the rows of energy and momenta in its projections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli.report.expectations import summary_lines
from mbproj.dynamics.equations.round_off import EPSILON, HARDLY_ANY
from mbproj.integrate.reporting.report import Report, Worst
from mbproj.model.system import System
from mbproj.registry import PROJECTIONS, is_explicit
from mbproj.scene.records import ProjectionSettings, Settings
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.analysis import Outcome
    from mbproj.results.trust import Trust

#: The violation above which a note tells that joints were open, relative to the coordinates in the rows.
FAR_OPEN = 1e-4
#: The most dry frictions with a line each, and the most short movements that are named.
MOST_FRICTIONS = 6
#: The timed steps that are needed to tell shares of the time; every 64th step is timed.
ENOUGH_STEPS = 640


def print_summary(
    title: str,
    system: System,
    report: Report,
    numbers: dict[str, Any],
    trust: Trust | None = None,
    outcomes: Sequence[Outcome] = (),
    frictions: Sequence[str] = (),
) -> None:
    """Print the summary on stdout: the certificate, the `outcomes` of the scene's expectations, and lines on its dry
    `frictions`. Warnings go to stderr."""
    counts, settings = report.counters, report.settings
    seconds = report.integration_seconds
    lines = [
        title,
        f"  {7 * system.bodies} coordinates, {system.constraints} constraints{_redundant(report)}, "
        f"{report.degrees_of_freedom} degrees of freedom",
        f"  {report.formulation} formulation: {report.why}",
        f"  {_method(report, system)}",
        *(f"    {line}" for line in report.methods),
        f"  {counts['steps']} steps to t = {settings.duration:g} s in {seconds:.2f} s "
        f"({_time(seconds / max(counts['steps'], 1))} a step), {counts['evaluations']} evaluations, "
        f"{counts['rejected_steps']} steps rejected",
        f"  position violation  {_worst(report.position_violation)}; round-off allows {report.position_floor:.0e}",
        f"  velocity violation  {_worst(report.velocity_violation)}; {_velocity_floor(report)}",
        f"  energy drift        {report.energy_drift:.2e} J "
        f"({report.energy_drift_relative:.1e} of the largest kinetic energy + |ΔV|)",
        *_account(report, system),
        f"  projection          {counts['projections']} times, {counts['projection_iterations']} position and "
        f"{counts['velocity_iterations']} velocity iterations, {counts['projection_failures']} failures"
        f"{_fallbacks(counts)}",
        *lines_on_rows(report),
        *_shortened(frictions),
        *_phases(report),
        *_trust(trust),
        *(summary_lines(outcomes) if outcomes else ()),
        f"  written to {numbers['output']}",
    ]
    click.echo("\n".join(lines))
    for warning in warnings(report):
        click.echo(f"note: {warning}", err=True)


def _trust(trust: Trust | None) -> Iterator[str]:
    if trust is not None:
        from mbproj.cli.report.trust import lines_on

        yield from lines_on(trust)


def warnings(report: Report) -> list[str]:
    """The warnings that a user should not overlook."""
    notes = [report.stiffness] if report.stiffness else []
    if report.passed:
        notes.append(
            f"fixed steps passed over edges of laws, from which the motion is pushed back ({report.passed}): no method "
            "keeps its order there; 'coulomb' of a friction on the joint sticks"
        )
    if report.shared:
        notes.append(
            f"contacts share a load arbitrarily ({report.shared}): the motion does not determine these forces, and the "
            "recorded ones are one share of many"
        )
    if report.halved:
        notes.append(
            f"fixed steps were halved {report.halved}: Newton's method did not solve them whole; a smaller --step or a "
            "--tolerance does without"
        )
    if report.decided_by_shares:
        notes.append(
            f"the motion depends on how these share their load, which rigid bodies leave open: "
            f"{report.decided_by_shares}; they share as springs of one stiffness do. Make the stops compliant with "
            "'stiffness', or use three points"
        )
    if report.crowded:
        notes.append(
            f"{', '.join(report.crowded)}: more kinks in time than count; steps end at the first "
            f"{THRESHOLDS.most_kinks:,} of each, and meet later ones anywhere"
        )
    if report.unresolved:
        notes.append(
            f"{'; '.join(report.unresolved[:MOST_FRICTIONS])}: fixed steps do not resolve what happens there, though "
            "they are split; take --tolerance in place of --step"
        )
    notes += warnings_on_rows(report)
    if report.drifts:
        notes.append(
            f"the energy drifted by {100 * report.drift_of_exchanged:.2g} %: the motion may be wrong "
            "although the joints are closed; compare with a smaller --step, or with --integrator dop853 --tolerance "
            "1e-10"
        )
    open_by = report.position_violation
    if open_by.value > FAR_OPEN * report.position_floor / EPSILON:
        notes.append(
            f"{open_by.owner} was open by {open_by.value:.2g} (m, rad) at t = {open_by.time:.4g} s: this is not "
            "the mechanism's motion; use a projection method, gpopm for example, or a smaller step"
        )
    asked = report.settings.projection.tolerance
    if asked is not None and report.settings.projection.test == "violation" and asked < report.position_floor:
        notes.append(
            f"the projection's tolerance of {asked:.0e} is below round-off, {report.position_floor:.0e}: the "
            "iterations stop where the violation falls no further"
        )
    finest = report.settings.tolerance
    if finest is not None and finest < report.round_off:
        notes.append(
            f"the tolerance of {finest:.0e} is below what round-off leaves of positions, {report.round_off:.0e} of the "
            "mechanism's length: smaller steps make nothing more accurate"
        )
    if report.swamped:
        from mbproj.dynamics.rank.massless import SHOWN

        notes.append(
            f"round-off of the other bodies' forces decides motions with less than {HARDLY_ANY:.0e} of the "
            f"largest inertia: {'; '.join(report.swamped[:SHOWN])}; give these bodies more inertia, or joints that "
            "hold them"
        )
    if report.counters["projection_failures"]:
        notes.append(
            f"{report.counters['projection_failures']} projections missed their tolerance; the largest violation "
            f"is {report.position_violation.value:.1e}"
        )
    return notes


def step_words(settings: Settings) -> str:
    """The step or the tolerance in words; a kinematic scene may have neither."""
    if settings.step is None and settings.tolerance is None:
        return "kinematic"
    return f"step {settings.step:g} s" if settings.step is not None else f"tolerance {settings.tolerance:g}"


def _method(report: Report, system: System) -> str:
    """The projection, the integrator and the step of the run, in words."""
    settings = report.settings
    if report.kinematic:
        from mbproj.integrate.formulations.kinematic import kinematic_description

        return f"kinematic: {kinematic_description(system, settings)}"
    return f"{projection_words(settings.projection)}, {settings.integrator}, {step_words(settings)}"


def _redundant(report: Report) -> str:
    return f", {report.redundant_rows} of them redundant" if report.redundant_rows else ""


def _fallbacks(counts: dict[str, int]) -> str:
    """The number of projections that fell back on gopm's metric, in words; "" where none did."""
    return f", {counts['projection_fallbacks']} in gopm's metric" if counts["projection_fallbacks"] else ""


def _account(report: Report, system: System) -> list[str]:
    """The sources and sinks of energy over the run, where there are any, or where the method damps."""
    energy, settings = report.energy, report.settings
    if not (energy.work or energy.dissipation) and is_explicit(settings.integrator):
        return []
    others = {"impacts": system.stops, "dry friction": system.frictions}
    damping = " and ".join(["dampers", *(name for name, there in others.items() if there is not None)])
    projects = PROJECTIONS[settings.projection.method].corrects and system.constraints > system.bodies
    numerics = "integrator and projection" if projects else "the integrator"
    if report.kinematic:
        numerics = "the quadrature"
    return [
        f"  energy in, out      forces put in {energy.work:.2e} J, {damping} took {energy.dissipation:.2e} J, "
        f"{numerics} {'took' if energy.numerical < 0.0 else 'added'} {abs(energy.numerical):.2e} J"
    ]


def _time(seconds: float) -> str:
    if seconds >= 1.0:
        return f"{seconds:.3g} s"
    return f"{1e6 * seconds:.3g} µs" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms"


def _phases(report: Report) -> list[str]:
    """The shares of the time that the phases of a step take."""
    total = sum(report.phases.values())
    if total == 0.0 or report.counters["steps"] < ENOUGH_STEPS:
        return []
    shares = ", ".join(f"{name} {100 * seconds / total:.0f} %" for name, seconds in report.phases.items())
    return [f"  time                {shares}; recording {_time(report.recording_seconds)} more"]


def _shortened(frictions: Sequence[str]) -> list[str]:
    """The first lines, and the number of the others."""
    more = [f"and {len(frictions) - MOST_FRICTIONS} more dry frictions, which mbproj info lists"]
    shown = [*frictions[:MOST_FRICTIONS], *(more if len(frictions) > MOST_FRICTIONS else [])]
    return [f"  {line}" for line in shown]


def _worst(violation: Worst) -> str:
    if violation.value == 0.0:
        return "0"
    return f"{violation.value:.1e}  ({violation.owner} at t = {violation.time:.4g} s)"


def _velocity_floor(report: Report) -> str:
    """The violation C' that round-off alone allows, in words."""
    return "nothing moves" if report.rests else f"round-off allows {report.velocity_floor:.0e}"


def lines_on_rows(report: Report) -> list[str]:
    """Lines on the rows: the number of steps that satisfied them, the energy that they added, and the steps without
    them. Empty where a run has no such rows."""
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


def _energy_row_words(report: Report) -> str:
    rows = report.rows
    if report.degrees_of_freedom == 1:
        return f"the energy row gave or took {rows.moved / rows.steps:.2g} J a step"
    return f"the energy row gave or took up to {rows.furthest:.2g} J in sum"


def warnings_on_rows(report: Report) -> list[str]:
    """Warnings where these rows may hide a wrong motion, or correct nothing."""
    projection, rows = report.settings.projection, report.rows
    notes = []
    if rows.refused:
        notes.append(
            f"the rows of energy and momenta were refused at {rows.refused} of {rows.steps + rows.rest + rows.refused} "
            f"steps: there they asked for more than {100 * THRESHOLDS.row_refused:g} % of what the step changed; the "
            "motion may be wrong; take a smaller --step or --tolerance"
        )
    if report.hidden > 1.0:
        notes.append(
            f"{_energy_row_words(report)}, where the run exchanged {report.exchanged:.2g} J: the motion may be wrong "
            "although the balance is kept; take a smaller --step or --tolerance"
        )
    if projection.momentum and not rows.momenta and not projection.energy:
        notes.append("joints to the ground, gravity or forces act on every momentum: --momentum-row keeps none")
    return notes
