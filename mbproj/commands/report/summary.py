"""The summary of a run in words, with the report on the rows of energy and momenta in its projections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees, inf, isfinite
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.registry import PROJECTIONS, is_explicit
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.model.system import System
from mbproj.motion.report import Report, Worst
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.runs import EXPECTATIONS
from mbproj.scene.records import Passage

if TYPE_CHECKING:
    from mbproj.base.arrays import Array
    from mbproj.results.analysis.expectations import Outcome
    from mbproj.results.trust import Trust
    from mbproj.scene.records import Expectation
    from mbproj.studies.record import Run


# --- The expectations of a scene and the measured values, as text and for JSON ----------------------------------------


def subject(expected: Expectation) -> str:
    """The subject of an expectation: "marker tip, position x at 3 s"."""
    what = "" if expected.of == "diagnostic" else f"{expected.of} {expected.item}, "
    further = f" to {expected.over}" if expected.over else f" between {' and '.join(expected.between)}"
    further = further if expected.over or expected.between else ""
    part = f" {expected.component}" if expected.component else ""
    return f"{what}{expected.quantity}{part}{further} {moment(expected)}"


def moment(expected: Expectation) -> str:
    """The time of an expectation: "at 3 s", "at the end", "at its maximum"."""
    if isinstance(expected.at, Passage):
        value = f"{degrees(expected.at.value):.10g}°" if expected.at.unit == "rad" else f"{expected.at.value:.10g} m"
        return f"where {expected.at.coordinate} is {value}"
    if not isinstance(expected.at, str):
        return f"at {expected.at:.10g} s"
    return "at the end" if expected.at == "end" else f"at its {expected.at}"


def expected_text(expected: Expectation) -> str:
    """The expected value: "0.12 ± 1e-06 m", "≤ 1e-12"."""
    unit = f" {expected.unit}" if expected.unit else ""
    if expected.value is not None:
        return f"{_numbers(expected.value)} ± {expected.tolerance:.3g}{unit}"
    bound, sign = (expected.below, "≤") if expected.below is not None else (expected.above, "≥")
    return f"{sign} {bound:.6g}{unit}"


def error_words(outcome: Outcome) -> str:
    """The error and the error allowed: "2.3e-07 of 1e-06 m". For a bound, the value reached and the bound."""
    expected, unit = outcome.expectation, f" {outcome.expectation.unit}" if outcome.expectation.unit else ""
    if outcome.measured is None:
        return "no such sample"
    doubt = "" if outcome.unique else "; not unique, joints or contacts can share it in any proportion"
    if outcome.error is not None:
        return f"{outcome.error:.1e} of {expected.tolerance:.3g}{unit}{doubt}"
    return f"{outcome.measured[0]:.3g}{'' if outcome.holds else ', not'} {expected_text(expected)}{doubt}"


def verdict(outcome: Outcome) -> str:
    """The verdict on an outcome in one or two words."""
    return "holds" if outcome.holds else "falls short" if outcome.checked else "not checked"


def summary_lines(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield the number of expectations that hold, and a line for each."""
    holding = sum(outcome.holds for outcome in outcomes)
    yield f"  expectations        {holding} of {len(outcomes)} hold"
    width = max(len(outcome.expectation.name) for outcome in outcomes)
    for outcome in outcomes:
        expected = outcome.expectation
        yield f"    {expected.name:{width}}  {verdict(outcome):11}  {error_words(outcome)}  ({subject(expected)})"


def record(outcome: Outcome) -> dict[str, Any]:
    """The outcome as a dictionary for JSON."""
    expected = outcome.expectation
    named = {name: value for name in ("over", "between") if (value := getattr(expected, name))}
    values = {"measured": _shortest(outcome.measured), "value": _shortest(expected.value)}
    return report_of(EXPECTATIONS.fields, outcome, component=expected.component or None, **named, **values)


def _numbers(values: Sequence[float]) -> str:
    texts = [f"{value:.10g}" for value in values]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"


def _shortest(values: Sequence[float] | None) -> Any:
    """A list of values, or the number itself for a single value."""
    if values is None:
        return None
    return values[0] if len(values) == 1 else values


# --- The summary of a run in words, with the report on the rows of energy and momenta in its --------------------------


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
        from mbproj.motion.formulations.choice import kinematic_description

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
    from mbproj.results.analysis import contacts as creep
    from mbproj.results.analysis import contacts as friction

    lines = [f"  friction '{name}': {friction.friction_in_words(each)}" for name, each in (run.frictions or {}).items()]
    lines += [f"  friction '{name}': {creep.creep_in_words(each)}" for name, each in (run.creep or {}).items()]
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
    gave = f"; gave {rows.added:.2e} J, {rows.moved:.2e} J in sum" if projection.energy else ""
    largest = f"; changed the velocities by {rows.largest:.1e} of them at most"
    return [f"  rows of {asked}: closed at {rows.steps} steps{''.join(f', {each}' for each in left)}{gave}{largest}"]


def projection_words(projection: ProjectionSettings) -> str:
    """The projection method, with the rows of energy and momenta that it keeps."""
    rows = ["energy row"] * projection.energy + ["momentum rows"] * projection.momentum
    return projection.method + (f" with {' and '.join(rows)}" if rows else "")


def momenta(number: int) -> str:
    """The number of momenta that are kept, in words."""
    return f"{number or 'no'} moment{'um' if number == 1 else 'a'}"


# --- The trust horizons of a run, as a table and for JSON -------------------------------------------------------------


#: The most rows of the table.
MAX_POINTS = 8


def as_numbers(trust: Trust) -> dict[str, Any]:
    """The horizons as a dictionary for JSON. A time that is never reached is infinite; an unknown growth is NaN."""
    times = ("horizon", "horizon_low", "horizon_high")
    points = {
        name: {
            **{key: getattr(trust, key)[k] for key in times},
            **{key: getattr(trust, key)[k] for key in ("growth_rate", "growth_power")},
            "growth_law": trust.growth_law[k] or None,
            "largest_error": _largest(trust.error[:, k]),
            "largest_uncertainty": _largest(trust.uncertainty[:, k]),
        }
        for k, name in enumerate(trust.names)
    }
    words = {"solution": trust.solution, "remark": trust.remark or None}
    return {**words, "limits": trust.limits, "points": points}


def lines_on(trust: Trust) -> Iterator[str]:
    """Yield a table of the times at which errors exceed limits, a row for each point. Limits that no error reaches are
    left out."""
    if not trust.solution and trust.remark:
        yield f"  how far to trust it: {trust.remark}"
        return
    yield f"  how far to trust it, by {trust.solution}"
    limits = enumerate(trust.limits.tolist())
    reached = [(column, limit) for column, limit in limits if trust.horizon_low[:, column].min() < inf]
    points = trust.names[:MAX_POINTS]
    heads = [_limit_text(limit) for _, limit in reached]
    rows = [
        [
            *(_horizon(trust, k, column) for column, _ in reached),
            f"{_largest(trust.error[:, k]):.1e} m",
            _growth(trust, k),
        ]
        for k in range(len(points))
    ]
    table = [["error exceeds", *heads, "largest", "grows as"]]
    table += [[name, *row] for name, row in zip(points, rows, strict=True)]
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    for row in table:
        yield "    " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
    if len(trust.names) > MAX_POINTS:
        yield f"    the first {MAX_POINTS} of {len(trust.names)}: the results file has all"
    if trust.remark:
        yield f"    {trust.remark}"


def _limit_text(limit: float) -> str:
    """A limit in m as text: "1e-4 m", "2.5 m"."""
    mantissa, _, power = f"{limit:.2e}".partition("e")
    return f"{limit:.3g} m" if limit >= 1.0 else f"{float(mantissa):g}e{int(power)} m"


def _horizon(trust: Trust, k: int, column: int) -> str:
    """A time in s as text, with its uncertainty: "0.95 s", "4.1-4.7 s", "4.1 s or later", "-" where it never comes."""
    low, high = trust.horizon_low[k, column], trust.horizon_high[k, column]
    if not isfinite(low):
        return "-"
    if not isfinite(high):
        return f"{low:.3g} s or later"
    return f"{low:.3g} s" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g}-{high:.3g} s"


def _growth(trust: Trust, k: int) -> str:
    laws = {"exponential": f"exp({trust.growth_rate[k]:.2g} t)", "power": f"t^{trust.growth_power[k]:.2g}"}
    return laws.get(trust.growth_law[k], "-")


def _largest(values: Array) -> float:
    """The largest known value."""
    return max((value for value in values.tolist() if isfinite(value)), default=0.0)
