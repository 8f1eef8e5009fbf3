"""A verification as a table of text, and for JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mbproj.results.verification import Check, Verification

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
