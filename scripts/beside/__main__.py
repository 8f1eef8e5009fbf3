"""mbproj, other programs and equations derived by hand, side by side on the same mechanisms.

    python -m scripts.beside five-bar slider-crank             the least time below errors, each program at its best
    python -m scripts.beside four-bar-1e6 governor-1e8         the same of stiff mechanisms, k in N/m
    python -m scripts.beside chain-5 chain-20 chain-100        time a step, by links
    python -m scripts.beside brake oscillator valve-train-1    dry friction and contact, over steps
    python -m scripts.beside long-crank-rocker-10000 --figure FILE   error after 10,000 s, with and without the row of
                                                               the energy, beside symplectic methods
    python -m scripts.beside --chaos                           how long chaotic motions are followed, to 1 mm

A name that ends with "-" in the list of --help takes a number. Needs the extra `peers`, or parts of it: a program that
is not installed is left out with a line that says so. Run it from the folder of the repository. One thread, processor
time of the integration alone. Each program sweeps its own steps or tolerances, and for each error the table has the
cheapest setting whose measured error is below it, median of interleaved repetitions: a dash where there is none. Where
a problem has steps of its own, or with --all, the table has every setting."""

from __future__ import annotations

import argparse
import json
from itertools import chain
from pathlib import Path
from typing import Any

from .figure import drawn
from .measure import PROGRAMS, compare, installed, print_all, print_cheapest, sweep, tried
from .problem import Problem
from .problems import PROBLEMS, chaotic, problem_of


def main() -> None:
    """Runs what is asked for, prints the tables, writes the JSON and the figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "problem", nargs="*", help=", ".join(f"{each}NUMBER" * each.endswith("-") or each for each in PROBLEMS)
    )
    parser.add_argument("--program", choices=[*PROGRAMS], nargs="+", default=[*PROGRAMS])
    parser.add_argument("--errors", type=float, nargs="+", help="default: those of each problem")
    parser.add_argument("--all", action="store_true", help="every setting")
    parser.add_argument("--repeat", type=int, default=5, help="repetitions; at least 5 for numbers to publish")
    parser.add_argument("--longest", type=float, default=20.0, help="a sweep ends after a run of so many seconds")
    parser.add_argument("--chaos", action="store_true", help="how long chaotic motions are followed")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="error over work")
    asked = parser.parse_args()
    tables: dict[str, list[dict[str, Any]]] = {}
    if asked.chaos:
        return follow()
    for name in asked.problem:
        try:
            problem = problem_of(name)
        except (KeyError, ValueError):
            parser.error(f"there is no problem {name!r}")
        rows = measured(problem, asked)
        tables[name] = [row | {"problem": problem.title, "unit": problem.unit} for row in rows]
        if asked.json:
            asked.json.write_text(json.dumps(tables, indent=1), encoding="utf-8")
    if asked.figure:
        drawn([row for rows in tables.values() for row in rows], asked.figure)
    return None


def measured(problem: Problem, asked: argparse.Namespace) -> list[dict[str, Any]]:
    """Prints the table of a problem; its rows."""
    programs = installed(problem, asked.program)
    errors = asked.errors or problem.errors
    if problem.tried or asked.all or not errors:
        trials = (
            tried(problem, program) if problem.tried else sweep(problem, program, errors or (0.0,), asked.longest)
            for program in programs
        )
        done = print_all(problem, chain.from_iterable(trials))
        return [trial.facts() | {"certain": problem.reference[1]} for trial in done]
    found = compare(problem, programs, errors, asked.repeat, asked.longest)
    print_cheapest(problem, errors, found)
    return [trial.facts() for trials in found.values() for trial in trials]


def follow() -> None:
    """Prints how long mbproj follows chaotic motions, with and without the row of the energy."""
    print("| mechanism | method | step | s |\n|---|---|---|---|")
    for problem in chaotic():
        for program in installed(problem, ["mbproj"]):
            for trial in tried(problem, program):
                cells = (problem.title, program.name, trial.setting.label, f"{trial.followed:.1f}")
                print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
