"""`mbproj compare-results`: whether two results are the same motion, and where they part."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.commands.options import Part, explained, option, results_file
from mbproj.commands.report.text import json_text
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.files import COMPARISON

if TYPE_CHECKING:
    from mbproj.results.analysis.comparison import MotionComparison, QuantityComparison

EXAMPLES = (
    ("Say whether two runs are the same motion, to a millionth.", "mbproj compare-results results.h5 again.h5"),
    ("Say whether two runs agree to a thousandth.", "mbproj compare-results results.h5 gopm.h5 --tolerance 1e-3"),
)


@explained("compare-results", EXAMPLES)
@click.argument("first", type=results_file(path_type=Path))
@click.argument("second", type=results_file(path_type=Path))
@option(
    Part.ACCURACY,
    "--tolerance",
    default="1e-6",
    show_default=True,
    metavar="NUMBER",
    help="Difference allowed, relative to the largest magnitude of a quantity.",
)
@option(
    Part.ACCURACY,
    "--absolute",
    multiple=True,
    metavar="QUANTITY=VALUE",
    help='Absolute difference allowed for one quantity instead, e.g. --absolute "bodies/position=1 mm"; repeatable.',
)
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the table.")
def command(first: Path, second: Path, tolerance: str, absolute: tuple[str, ...], as_json: bool) -> int:
    """Tells whether the results FIRST and SECOND are the same motion.

    Compares them at the sample times that both have, without interpolation. A table shows the largest difference of
    each quantity, where and when it occurs, and the difference allowed.

    Exit code 0: the same motion; 4: they differ, or one is longer; 2: they cannot be compared.
    """
    from mbproj.base.errors import ExitCode
    from mbproj.results.analysis.comparison import compare_motions
    from mbproj.results.reader import open_results
    from mbproj.scene.fields.quantities import Number, given_number

    part = given_number(tolerance, "--tolerance", Number(above=0.0))
    limits = dict(_limit(text) for text in absolute)
    with open_results(first) as one, open_results(second) as other:
        comparison = compare_motions(one, other, part, limits)
    if as_json:
        click.echo(json_text(report_of(COMPARISON, comparison, first=first, second=second)))
    else:
        for line in _lines(comparison, first, second):
            click.echo(line)
    return int(ExitCode.DONE if comparison.same else ExitCode.CHECK_FAILED)


def _limit(text: str) -> tuple[str, float]:
    """The name and the value of a text QUANTITY=VALUE, the value in the unit of the quantity."""
    from mbproj.commands.python.files import allowed

    name, _, value = text.partition("=")
    return name, allowed(name, value)


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
