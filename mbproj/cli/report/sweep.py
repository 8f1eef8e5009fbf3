"""The output of a sweep: before it runs, and at its end."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import TYPE_CHECKING, Any

from mbproj.cli.report.junit import TestCase, cases_as_xml
from mbproj.cli.report.text import columns

if TYPE_CHECKING:
    from mbproj.scene.ranges import Item
    from mbproj.studies.sweep.run import Progress
    from mbproj.studies.sweep.spec import SweepSpec
    from mbproj.studies.sweep.summary import CaseEntry

#: The most kinds of failure that are shown.
KINDS = 10


def preview(spec: SweepSpec, shown: int) -> str:
    """The number of cases, and the first of them."""
    from mbproj.scene.ranges.family import column_of, with_unit

    design = spec.design
    count = f"{design.count} {'case' if design.count == 1 else 'cases'} ({design.name})"
    names = [with_unit(column_of(path), spec.units[path]) for path in design.paths]
    rows = [[str(number), *map(_item, design.case(number))] for number in range(min(design.count, shown))]
    more = [] if design.count <= shown else ["..."]
    measures = f"measured: {', '.join(with_unit(each.name, each.unit) for each in spec.measures)}"
    return "\n".join([count, "", columns(["case", *names], rows), *more, "", measures])


def _item(value: Item) -> str:
    return f"{value:.10g}" if isinstance(value, float) else value


def failures(entries: Iterable[CaseEntry]) -> list[dict[str, Any]]:
    """The failed cases by their message, most frequent first: each message with its number of cases and the first of
    them."""
    found: dict[str, dict[str, Any]] = {}
    for number, entry in enumerate(entries):
        if entry.row is None or entry.status == "done":
            continue
        known = found.setdefault(
            entry.row.message, {"message": entry.row.message, "status": entry.status, "count": 0, "first_case": number}
        )
        known["count"] += 1
    return sorted(found.values(), key=lambda kind: -int(kind["count"]))


def said(reached: Progress, kinds: list[dict[str, Any]]) -> str:
    """The numbers of cases, and the kinds of failure."""
    left = f", {reached.left} left" if reached.left else ""
    arrays = f" ({reached.by_arrays} by arrays)" if reached.by_arrays else ""
    counts = f"{reached.computed} computed{arrays}, {reached.reused} reused, {reached.failed} failed{left}"
    lines = [f"{reached.whole} {'case' if reached.whole == 1 else 'cases'}: {counts}"]
    for kind in islice(kinds, KINDS):
        lines.append(f"  {kind['count']} {kind['status']}, the first is case {kind['first_case']}: {kind['message']}")
    if len(kinds) > KINDS:
        lines.append(f"  and {len(kinds) - KINDS} other messages, in summary.csv")
    return "\n".join(lines)


def junit(spec: SweepSpec, entries: Iterable[CaseEntry]) -> str:
    """A testsuite with a testcase for each case."""
    found = []
    for number, entry in enumerate(entries):
        values = ", ".join(
            f"{path}={_item(value)}" for path, value in zip(spec.design.paths, entry.values, strict=True)
        )
        if entry.row is None:
            found.append(TestCase(f"{number}: {values}", 0.0, "skipped", entry.status))
        else:
            ended = () if entry.status == "done" else ("error", entry.row.message, entry.status)
            found.append(TestCase(f"{number}: {values}", entry.row.seconds, *ended))
    return cases_as_xml(spec.path, found)
