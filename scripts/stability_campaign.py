"""Runs the extremes with every projection method in every formulation, and prints a table of what holds.

    python scripts/stability_campaign.py [--brief] [--method METHOD] [--formulation FORMULATION] [-o CSV] [NAME ...]

Each line is a value of an extreme in one formulation: the methods by what became of their runs (see
`extremes.trial.Outcome`), the largest closure of those that correct in units of what round-off allows, the largest
errors of the motion and of the energy, both relative. --brief takes the values of the tests. The exit code is 1 where a
run told less than the truth.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterable
from dataclasses import asdict, fields
from pathlib import Path

from extremes.extremes import EXTREMES
from extremes.trial import Outcome, attempt, combinations

from mbproj.base.registry import FORMULATIONS, PROJECTIONS

HEAD = ("extreme", "value", "formulation", "what became of the methods", "closure, floors", "motion", "energy")


def line(outcomes: list[Outcome]) -> str:
    """A line of the table for the methods of one value and formulation."""
    first, ran = outcomes[0], [each for each in outcomes if each.verdict in ("right", "open", "warned", "WRONG")]
    verdicts = {
        verdict: [each.method for each in outcomes if each.verdict == verdict]
        for verdict in dict.fromkeys(each.verdict for each in outcomes)
    }
    became = "; ".join(
        verdict if len(verdicts) == 1 else f"{verdict}: {', '.join(methods)}" for verdict, methods in verdicts.items()
    )
    closed = [each.closure / each.floor for each in ran if PROJECTIONS[each.method].corrects and each.floor > 0.0]
    numbers = (
        f"{max(closed):.2g}" if closed else "",
        *(
            f"{max(errors):.0e}" if errors else ""
            for errors in ([each.error for each in ran], [each.energy for each in ran])
        ),
    )
    return "| " + " | ".join((first.extreme, f"{first.value:g}", first.formulation, became, *numbers)) + " |"


def write(path: Path, outcomes: Iterable[Outcome]) -> None:
    """All outcomes as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, [field.name for field in fields(Outcome)])
        table.writeheader()
        table.writerows(asdict(each) for each in outcomes)


def main() -> None:
    """Runs the extremes that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(EXTREMES)}")
    parser.add_argument("--brief", action="store_true", help="the values of the tests")
    parser.add_argument("--method", choices=tuple(PROJECTIONS), help="this projection method alone")
    parser.add_argument("--formulation", choices=FORMULATIONS[1:], help="this formulation alone")
    parser.add_argument("-o", "--output", type=Path, help="a CSV file for every run")
    given = parser.parse_args()
    unknown = [name for name in given.names if name not in EXTREMES]
    if unknown:
        parser.error(f"there is no extreme '{unknown[0]}'; there are {', '.join(EXTREMES)}")
    print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|")
    outcomes: list[Outcome] = []
    for extreme in (EXTREMES[name] for name in given.names or EXTREMES):
        for value in extreme.brief if given.brief else extreme.values:
            for formulation in extreme.formulations:
                if given.formulation not in (None, formulation):
                    continue
                found = [
                    attempt(extreme, value, method, own)
                    for method, own in combinations(extreme)
                    if own == formulation and given.method in (None, method)
                ]
                outcomes += found
                if found:
                    print(line(found), flush=True)
    if given.output:
        write(given.output, outcomes)
    sys.exit(0 if all(each.honest for each in outcomes) else 1)


if __name__ == "__main__":
    main()
