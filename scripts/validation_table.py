"""Runs every validation case and prints the README's table: what is compared, the error reached, and the time it took.

    python scripts/validation_table.py [--columns] [NAME ...]

The error is that of the column that comes nearest to its tolerance; --columns shows all of them.
"""

from __future__ import annotations

import argparse
from time import perf_counter

from validation.case import CASES, Case
from validation.compare import Deviation, deviations, regular_text, run_case
from validation.quantities import UNITS, Column

from mbproj import InputError


def row(case: Case, regular: bool, columns: bool) -> str:
    """One line of the table; `regular`: with planar loops closed by a point on a line."""
    label = f"`{case.name}`" + (", loops closed by `point_on_line`" if regular else "")
    started = perf_counter()
    try:
        done = run_case(case, regular_text(case) if regular else None)
    except InputError as error:
        return f"| {label} | {case.origin} | refused: {error.problems[0].message} | | | |"
    seconds = perf_counter() - started
    found = deviations(case, done)
    for each in found if columns else ():
        print(f"    {case.name} {shown(each)} {each.tolerance:.1e}, times: {each.count}, largest {each.largest:.3g}")
    worst = max(found, key=lambda each: each.ratio)
    reached = f"{shown(worst)} | {worst.tolerance:.2g}"
    return f"| {label} | {case.origin} | {reached} | {done.report.formulation} | {seconds:.2f} |"


def shown(deviation: Deviation) -> str:
    """A column's error with its unit."""
    unit = UNITS[Column.of(deviation.column).quantity]
    return f"`{deviation.column}` {deviation.error:.1e}{'' if unit == '1' else ' ' + unit}"


def main() -> None:
    """Prints the table of the cases that are named, or of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--columns", action="store_true", help="every column's error too")
    given = parser.parse_args()
    print("| case | origin | largest error | tolerance | formulation | time, s |\n|---|---|---|---|---|---|")
    for case in (CASES[name] for name in given.names or CASES):
        for regular in (False, True) if case.loops else (False,):
            print(row(case, regular, given.columns), flush=True)


if __name__ == "__main__":
    main()
