"""`mbproj compare-results` and `mbproj.compare_results`: whether two results are the same motion, and where they
part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.errors import ExitCode, InputError, Place, Problem, choose_from
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import Assignments, Positive
from mbproj.commands.options import NOTHING, Option, Part, SomeResults, json_option
from mbproj.commands.report.text import json_text
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.files import COMPARISON

if TYPE_CHECKING:
    from mbproj.commands.arguments import Quantity
    from mbproj.results.analysis.comparison import MotionComparison, QuantityComparison

EXAMPLES = (
    ("Say whether two runs are the same motion, to a millionth.", "mbproj compare-results results.h5 again.h5"),
    ("Say whether two runs agree to a thousandth.", "mbproj compare-results results.h5 gopm.h5 --tolerance 1e-3"),
)


def _allowed(name: str, value: Any, place: str) -> float:
    """The difference that a quantity is allowed, in its unit. Raises InputError for an unknown quantity, or a value
    that is not a positive number in its unit."""
    from mbproj.results.analysis.comparison import COMPARED

    units = {dataset.path: dataset.unit for dataset in COMPARED}
    if name not in units:
        hint = choose_from(name, units, "quantities")
        raise InputError(Problem(f"there is no quantity '{name}'", Place(place), hint))
    unit_text = "rad" if name == "bodies/orientation" else units[name]
    return float(Positive(None if " or " in unit_text else unit_text.replace(" ", "*")).of(value, place))


Tolerance = Annotated[
    "Quantity",
    Option(
        Part.ACCURACY, "Difference allowed, relative to the largest magnitude of a quantity.", Positive(""), "NUMBER"
    ),
]
Absolute = Annotated[
    "Mapping[str, Quantity]",
    Option(
        Part.ACCURACY,
        'Absolute difference allowed for one quantity instead, e.g. --absolute "bodies/position=1 mm"; repeatable.',
        Assignments(_allowed, '--absolute "bodies/position=1 mm"'),
        "QUANTITY=VALUE",
        many=True,
    ),
]


@declared
def compare_results(
    first: SomeResults, second: SomeResults, *, tolerance: Tolerance = 1e-6, absolute: Absolute = NOTHING
) -> MotionComparison:
    """Tells whether the results FIRST and SECOND are the same motion.

    Compares them at the sample times that both have, without interpolation. A table shows the largest difference of
    each quantity, where and when it occurs, and the difference allowed.

    Exit code 0: the same motion; 4: they differ, or one is longer; 2: they cannot be compared.

    In Python `found.same` tells whether they are the same motion. Raises InputError where the results cannot be
    compared.
    """
    from mbproj.commands.stored_run import opened
    from mbproj.results.analysis.comparison import compare_motions

    asked = read(compare_results, locals())
    with opened(asked.first) as one, opened(asked.second) as other:
        return compare_motions(one, other, asked.tolerance, asked.absolute)


@command_of(compare_results, EXAMPLES, json_option)
def command(asked: Asked[MotionComparison], as_json: bool) -> int:
    first, second, comparison = asked.given["first"], asked.given["second"], asked.result()
    if as_json:
        click.echo(json_text(report_of(COMPARISON, comparison, first=first, second=second)))
    else:
        for line in _lines(comparison, first, second):
            click.echo(line)
    return int(ExitCode.DONE if comparison.same else ExitCode.CHECK_FAILED)


def _lines(comparison: MotionComparison, first: Path, second: Path) -> Iterator[str]:
    from mbproj.results.analysis.loads import in_words

    for path, count, end in zip((first, second), comparison.counts, comparison.ends, strict=True):
        yield f"{path}: {count} samples to t = {end:.6g} s"
    yield f"compared at the {comparison.samples} times that both have"
    for kind, names in comparison.missing.items():
        yield f"only one of them has the {kind} {', '.join(names)}"
    if comparison.left_out:
        yield f"not compared, because redundant joints can share it in any proportion: {in_words(comparison.left_out)}"
    rows = [_row(each) for each in comparison.quantities]
    header = ("quantity", "largest difference", "of", "at", "allowed", "")
    widths = [max(len(row[place]) for row in (header, *rows)) for place in range(len(header))]
    for row in (header, *rows):
        yield "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
    yield _verdict(comparison)


def _row(each: QuantityComparison) -> tuple[str, ...]:
    largest = each.largest
    return (
        each.quantity,
        f"{largest.difference:.2e} {each.unit}",
        largest.name,
        f"{largest.time:.6g} s",
        f"{each.allowed:.2e} {each.unit}",
        "same" if each.same else "differs",
    )


def _verdict(comparison: MotionComparison) -> str:
    parting = comparison.parting
    if parting is not None and parting.first is not None:
        of = f" of '{parting.first.name}'" if parting.first.name else ""
        return (
            f"they part at t = {parting.first.time:.6g} s: {parting.quantity}{of} differs by "
            f"{parting.first.difference:.2e} {parting.unit}, {parting.allowed:.2e} is allowed"
        )
    if not comparison.as_long:
        return f"the same motion until t = {min(comparison.ends):.6g} s, where one of them ends"
    return "the same motion"
