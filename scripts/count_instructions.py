"""Instructions a step of the compiled kernel, by callgrind, and the arithmetic among them: counts repeat where times do
not.

    python scripts/count_instructions.py [--only NAME ...]

RK4 and GPOPM with the steps of the scenes; needs valgrind and objdump. Each case runs twice, with so many runs and
more: their difference leaves out what starting Python costs. The arithmetic is what the kernel itself does to doubles:
sums, products, quotients and roots. A vector of four counts as four, a fused product and sum as two. A comparison is
fair on one machine with one compiler.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path

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
#: Arithmetic of doubles as objdump writes it, alone (`sd`) or in vectors (`pd`).
ARITHMETIC = re.compile(r"v?(add|sub|mul|div|sqrt|fn?m(?:add|sub)\d+)([sp])d\b")
KINDS = {"add": "sums", "sub": "sums", "mul": "products", "div": "quotients", "sqrt": "roots"}


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
        more, few = counted(name, FEW + MORE), counted(name, FEW)
        per_step = {key: (more[key] - few[key]) / (MORE * steps_of(name)) for key in more}
        arithmetic = ", ".join(f"{per_step[kind]:.0f} {kind}" for kind in dict.fromkeys(KINDS.values()))
        print(f"{name:24s} {per_step['instructions']:10.0f} instructions a step, of them {arithmetic}", flush=True)
    return 0


def steps_of(name: str) -> int:
    return paper_case(*CASES[name]).steps


def run(name: str, runs: int) -> None:
    """The work that is counted."""
    case = paper_case(*CASES[name])
    for _ in range(runs):
        case.compiled.run(case.start, case.settings).advance(2, FOREVER)


def counted(name: str, runs: int) -> Counter[str]:
    """Instructions of a process that makes so many runs, and the operations of the kernel on doubles by kind."""
    with tempfile.TemporaryDirectory() as folder:
        profile = Path(folder) / "profile"
        callgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={profile}", "--dump-instr=yes"]
        form = ["--dump-line=no", "--compress-strings=no", "--compress-pos=no"]
        command = [*callgrind, *form, sys.executable, __file__, "--only", name, "--runs", str(runs)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        collected = re.search(r"Collected : (\d+)", done.stderr)
        if collected is None:
            raise RuntimeError(f"callgrind counted nothing: {done.stderr[-500:]}")
        found = Counter(instructions=int(collected[1]))
        for address, times in executed(profile).items():
            for kind, operations in arithmetic_of_kernel().get(address, {}).items():
                found[kind] += times * operations
    return found


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
