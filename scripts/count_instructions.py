"""Instructions a step of the compiled kernel, by callgrind, and the arithmetic among them: counts repeat where times do
not.

    python scripts/count_instructions.py [--only NAME ...]
    python scripts/count_instructions.py --events [--only NAME ...]

RK4 and GPOPM with the steps of the scenes; needs valgrind and objdump. With `--events` instead the instructions of an
event of contacts, with the steps before it, in steps of the five-bar in the plane. Each case runs twice, with so many
runs or events and more: their difference leaves out what starting Python costs. The arithmetic is what the kernel
itself does to doubles: sums, products, quotients and roots. A vector of four counts as four, a fused product and sum
as two. A comparison is fair on one machine with one compiler.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path

from kernel_bench.case import paper_case
from kernel_bench.events import SCENES, run_events

from mbproj.kernel import core

CASES = {
    "five_bar in the plane": ("five_bar", True),
    "five_bar in space": ("five_bar", False),
    "spatial_slider_crank": ("spatial_slider_crank", False),
}
#: Runs of a short process, and by how many more a long one makes; and by how many times a run with events is longer.
FEW, MORE, LONGER = 1, 2, 10
FOREVER = 1e6
#: Arithmetic of doubles as objdump writes it, alone (`sd`) or in vectors (`pd`).
ARITHMETIC = re.compile(r"v?(add|sub|mul|div|sqrt|fn?m(?:add|sub)\d+)([sp])d\b")
KINDS = {"add": "sums", "sub": "sums", "mul": "products", "div": "quotients", "sqrt": "roots"}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=[*CASES, *SCENES])
    parser.add_argument("--events", action="store_true", help="what events cost")
    parser.add_argument("--runs", type=int, help=argparse.SUPPRESS)  # set in the processes that are counted
    given = parser.parse_args()
    if given.runs is not None:
        print(json.dumps(run(given.only[0], given.runs)))
        return 0
    if core() is None:
        print("needs the compiled kernel", file=sys.stderr)
        return 2
    if given.events:
        return events(given.only or list(SCENES))
    for name in given.only or CASES:
        per_step = of_a_step(name)
        arithmetic = ", ".join(f"{per_step[kind]:.0f} {kind}" for kind in dict.fromkeys(KINDS.values()))
        print(f"{name:24s} {per_step['instructions']:10.0f} instructions a step, of them {arithmetic}", flush=True)
    return 0


def of_a_step(name: str) -> dict[str, float]:
    """Instructions of a step, and operations on doubles by kind."""
    few, more = counted(name, FEW)[0], counted(name, FEW + MORE)[0]
    steps = paper_case(*CASES[name]).steps
    return {key: (more[key] - few[key]) / (MORE * steps) for key in more}


def events(names: list[str]) -> int:
    """Print what an event costs in each of these scenes."""
    step = of_a_step("five_bar in the plane")["instructions"]
    for name in names:
        (few, before), (more, after) = counted(name, FEW), counted(name, FEW + LONGER)
        found = {key: (after[key] - before[key]) / (after["events"] - before["events"]) for key in after}
        cost = (more["instructions"] - few["instructions"]) / (after["events"] - before["events"]) / step
        print(
            f"{name:40s} {cost:6.1f} steps of the five-bar an event, with {found['steps']:.1f} steps, "
            f"{found['evaluations']:.0f} evaluations, {found['projections']:.1f} projections",
            flush=True,
        )
    return 0


def run(name: str, runs: int) -> dict[str, int]:
    """The work that is counted; for events, how many they were and what the run did."""
    if name in SCENES:
        return run_events(name, runs)
    case = paper_case(*CASES[name])
    for _ in range(runs):
        case.compiled.run(case.start, case.settings).advance(2, FOREVER)
    return {}


def counted(name: str, runs: int) -> tuple[Counter[str], dict[str, int]]:
    """Instructions of a process that makes so many runs, with the operations of the kernel on doubles by kind. And what
    it prints."""
    with tempfile.TemporaryDirectory() as folder:
        profile = Path(folder) / "profile"
        callgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={profile}", "--dump-instr=yes"]
        form = ["--dump-line=no", "--compress-strings=no", "--compress-pos=no"]
        command = [*callgrind, *form, sys.executable, __file__, "--only", name, "--runs", str(runs)]
        same = os.environ | {"PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=same)
        collected = re.search(r"Collected : (\d+)", done.stderr)
        if collected is None:
            raise RuntimeError(f"callgrind counted nothing: {done.stderr[-500:]}")
        found = Counter(instructions=int(collected[1]))
        for address, times in executed(profile).items():
            for kind, operations in arithmetic_of_kernel().get(address, {}).items():
                found[kind] += times * operations
    return found, json.loads(done.stdout)


def executed(profile: Path) -> Counter[int]:
    """How many times each instruction of the kernel ran, by its address."""
    found: Counter[int] = Counter()
    inside = after_call = False
    for line in profile.read_text(encoding="utf-8").splitlines():
        if line.startswith("ob="):
            inside = "_core" in Path(line[3:]).name
        elif line.startswith("calls="):
            after_call = True  # the next line is what was called
        elif line.startswith("0x"):
            if inside and not after_call:
                address, times = line.split()
                found[int(address, 16)] += int(times)
            after_call = False
    return found


@cache
def arithmetic_of_kernel() -> dict[int, Counter[str]]:
    """The operations on doubles of each instruction of the kernel that has any, by its address."""
    kernel = core()
    assert kernel is not None
    listing = subprocess.run(
        ["objdump", "-d", "--no-show-raw-insn", str(kernel.__file__)], capture_output=True, text=True, check=True
    )
    found: dict[int, Counter[str]] = {}
    for line in listing.stdout.splitlines():
        address, _, instruction = line.partition(":\t")
        if what := ARITHMETIC.match(instruction):
            lanes = 1 if what[2] == "s" else 4 if "%ymm" in instruction else 2
            kinds = [KINDS[what[1]]] if what[1] in KINDS else ["sums", "products"]
            found[int(address, 16)] = Counter(dict.fromkeys(kinds, lanes))
    return found


if __name__ == "__main__":
    sys.exit(main())
