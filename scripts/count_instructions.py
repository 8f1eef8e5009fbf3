"""Instructions a step of the compiled kernel, by callgrind: they repeat where times do not.

    python scripts/count_instructions.py [--only NAME ...]

RK4 and GPOPM with the steps of the scenes; needs valgrind. Each case runs twice, with so many runs and more: their
difference leaves out what starting Python costs. A comparison is fair on one machine with one compiler.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys

from kernel_bench.case import paper_case

from mbproj.kernel import core

CASES = {
    "five_bar in the plane": ("five_bar", True),
    "five_bar in space": ("five_bar", False),
    "spatial_slider_crank": ("spatial_slider_crank", False),
}
#: Runs of a short process, and by how many more a long one makes.
FEW, MORE = 1, 2
FOREVER = 1e6


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(CASES), default=list(CASES))
    parser.add_argument("--runs", type=int, help=argparse.SUPPRESS)  # set in the processes that are counted
    given = parser.parse_args()
    if given.runs is not None:
        run(given.only[0], given.runs)
        return 0
    if core() is None:
        print("needs the compiled kernel", file=sys.stderr)
        return 2
    for name in given.only:
        per_step = (counted(name, FEW + MORE) - counted(name, FEW)) / (MORE * steps_of(name))
        print(f"{name:24s} {per_step:10.0f} instructions a step", flush=True)
    return 0


def steps_of(name: str) -> int:
    return paper_case(*CASES[name]).steps


def run(name: str, runs: int) -> None:
    """The work that is counted."""
    case = paper_case(*CASES[name])
    for _ in range(runs):
        case.compiled.run(case.start, case.settings).advance(2, FOREVER)


def counted(name: str, runs: int) -> int:
    """Instructions of a process that makes so many runs."""
    command = [sys.executable, __file__, "--only", name, "--runs", str(runs)]
    done = subprocess.run(
        ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command],
        capture_output=True,
        text=True,
        check=True,
    )
    found = re.search(r"Collected : (\d+)", done.stderr)
    if found is None:
        raise RuntimeError(f"callgrind counted nothing: {done.stderr[-500:]}")
    return int(found[1])


if __name__ == "__main__":
    sys.exit(main())
