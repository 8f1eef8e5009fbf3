"""The expectations of a scene and the measured values, as text and for JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

from mbproj.report_schema import report_of
from mbproj.report_schema.run import EXPECTATIONS
from mbproj.scene.records import Passage

if TYPE_CHECKING:
    from mbproj.analysis import Outcome
    from mbproj.scene.records import Expectation


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
