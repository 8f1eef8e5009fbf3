"""The summary of a run in words, with the report on the rows of energy and momenta in its projections."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from mbproj.cli.report.expectations import summary_lines
from mbproj.integrate.reporting.report import Report, Worst
from mbproj.model.system import System
from mbproj.registry import PROJECTIONS, is_explicit
from mbproj.scene.records import ProjectionSettings, Settings

if TYPE_CHECKING:
    from mbproj.results.trust import Trust
    from mbproj.runs.record import Run

#: The most dry frictions with a line each.
MOST_FRICTIONS = 6
#: The timed steps that are needed to tell shares of the time; every 64th step is timed.
ENOUGH_STEPS = 640


def print_summary(run: Run) -> None:
    """Print the summary of a run on stdout."""
    report, system = run.report, run.system
    counts, settings = report.counters, report.settings
    seconds = report.integration_seconds
    lines = [
        run.scene.title or run.attributes["scene"],
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
        *_frictions(run),
        *_phases(report),
        *_trust(run.trust),
        *(summary_lines(run.outcomes) if run.outcomes else ()),
        f"  written to {run.output}",
    ]
    click.echo("\n".join(lines))


def _trust(trust: Trust | None) -> Iterator[str]:
    if trust is not None:
        from mbproj.cli.report.trust import lines_on

        yield from lines_on(trust)


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


def _frictions(run: Run) -> list[str]:
    """Lines on the first dry frictions, and the number of the others."""
    if not (run.frictions or run.creep):
        return []
    from mbproj.analysis.contacts import creep, friction

    lines = [f"  friction '{name}': {friction.in_words(each)}" for name, each in (run.frictions or {}).items()]
    lines += [f"  friction '{name}': {creep.in_words(each)}" for name, each in (run.creep or {}).items()]
    more = f"  and {len(lines) - MOST_FRICTIONS} more dry frictions, which mbproj info lists"
    return [*lines[:MOST_FRICTIONS], *([more] if len(lines) > MOST_FRICTIONS else [])]


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
