"""The compiled kernel alone: µs per step, RK4 and GPOPM to the default tolerance, without recording.

    python scripts/bench_kernel.py [--only NAME ...] [--formulation reduced|planar] [--repeat 5] [--quick] [--json FILE]

The paper's mechanisms with the steps of their scenes; chains, trees, stars, ladders and wheels (scripts/kernel_bench)
with steps of a tenth of a radian of their highest frequency, spatial (reduced) and planar. Times are processor time of
the thread, the smallest and the median of the repetitions. A phase's share is that of the steps whose phases are timed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from kernel_bench.case import FAMILIES, Case, family_case, paper_case
from kernel_bench.goals import verdicts
from kernel_bench.measure import measure, memory

from mbproj.kernel import build_info, core
from mbproj.motion.formulations.compiled import PHASES

#: The paper's mechanisms and the formulations that fit them.
PAPER = {"five_bar": ("reduced", "planar"), "spatial_slider_crank": ("reduced",)}
#: Links of the chains whose memory is measured.
MEMORY_LINKS, QUICK_MEMORY_LINKS = 10_000, 1000
ROW = dict[str, Any]


def paper_rows(only: list[str], formulations: list[str], repeat: int) -> list[ROW]:
    """A row for each of the paper's mechanisms and formulation."""
    return [
        {"size": name} | measure(paper_case(name, formulation == "planar"), repeat)
        for name, fitting in PAPER.items()
        for formulation in fitting
        if name in only and formulation in formulations
    ]


def family_cases(name: str, formulations: list[str], quick: bool) -> Iterator[tuple[int, Case]]:
    """The sizes of a family, each in each formulation."""
    family = FAMILIES[name]
    for formulation in formulations:
        for size in family.quick if quick else family.sizes:
            print(f"{name} of {size} {family.what}, {formulation} ...", file=sys.stderr, flush=True)
            yield size, family_case(family, size, formulation == "planar")


def memory_rows(formulations: list[str], links: int) -> list[ROW]:
    """Bytes a body of a chain in each formulation."""
    rows = []
    for formulation in formulations:
        case = family_case(FAMILIES["chain"], links, formulation == "planar")
        rows.append({"formulation": formulation, "bodies": case.bodies} | memory(case))
    return rows


def print_rows(title: str, what: str, rows: list[ROW]) -> None:
    """The table as Markdown."""
    print(f"\n{title}\n")
    heads = [
        what,
        "formulation",
        "rad/s",
        "step, ms",
        "steps",
        "µs a step: fastest",
        "median",
        "µs a step and body",
        "passes",
        "closed to",
        *(f"{phase}, %" for phase in PHASES),
    ]
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for row in rows:
        frequency = "-" if row["frequency"] is None else f"{row['frequency']:.3g}"
        shares = [f"{100 * row['phases'][phase]:.0f}" if row["phases"] else "-" for phase in PHASES]
        cells = [
            str(row["size"]),
            row["formulation"],
            frequency,
            f"{1e3 * row['step']:.3g}",
            str(row["steps"]),
            f"{row['fastest']:.4g}",
            f"{row['median']:.4g}",
            f"{row['fastest'] / row['bodies']:.3g}",
            f"{row['passes_per_step']:.2f}",
            f"{row['position_peak']:.0e}",
            *shares,
        ]
        print(f"| {' | '.join(cells)} |", flush=True)


def print_memory(rows: list[ROW]) -> None:
    """The table as Markdown."""
    print("\nMemory of a run\n\n| bodies | formulation | resident, bytes a body | allocated, bytes a body |")
    print("|---|---|---|---|")
    for row in rows:
        allocated = "-" if row["allocated"] is None else f"{row['allocated']:.0f}"
        print(f"| {row['bodies']} | {row['formulation']} | {row['resident']:.0f} | {allocated} |")


def main() -> None:
    """Measures what is asked for, prints the tables, writes the JSON."""
    names = [*PAPER, *FAMILIES, "memory"]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="NAME", help=", ".join(names))
    parser.add_argument("--formulation", choices=("reduced", "planar"), action="append", help="default: both")
    parser.add_argument("--repeat", type=int, default=5, help="repetitions; at least 5 for numbers to publish")
    parser.add_argument("--quick", action="store_true", help="small sizes, 2 repetitions")
    parser.add_argument("--json", type=Path, metavar="FILE")
    asked = parser.parse_args()
    build = build_info()
    if core() is None or isinstance(build, str):
        raise SystemExit(f"there is no compiled kernel: {build}")
    print(" ".join(f"{key}: {value}." for key, value in build.items()))
    repeat, formulations = 2 if asked.quick else asked.repeat, asked.formulation or ["reduced", "planar"]
    tables = {"paper": paper_rows(asked.only, formulations, repeat)}
    if tables["paper"]:
        print_rows("The paper's mechanisms", "mechanism", tables["paper"])
    for name in [name for name in FAMILIES if name in asked.only]:
        cases = family_cases(name, formulations, asked.quick)
        tables[name] = [{"size": size} | measure(case, repeat) for size, case in cases]
        print_rows(FAMILIES[name].title, FAMILIES[name].what, tables[name])
    if "memory" in asked.only:
        tables["memory"] = memory_rows(formulations, QUICK_MEMORY_LINKS if asked.quick else MEMORY_LINKS)
        print_memory(tables["memory"])
    print("\n| goal | measured | met |\n|---|---|---|")
    for goal, value, met in verdicts(tables):
        print(f"| {goal} | {value} | {'yes' if met else 'no'} |")
    if asked.json:
        asked.json.write_text(json.dumps({"build": build} | tables, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
