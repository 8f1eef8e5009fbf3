"""Two stiff mechanisms beside Exudyn, MuJoCo and SciPy: the least time of each below an error, all in one run.

    python scripts/stiff_beside_peers.py [--dials 1e6 1e8] [--errors 1e-3 1e-4 1e-5 1e-6 1e-7] [--program FILE ...]
        [--mechanism NAME ...]

The four-bar of `mechanisms/split_coupler.yaml` and the governor of `mechanisms/governor.yaml` over 0.2 s, with the
stiffness of the bushing and of the spring as a dial (`scripts/stiff/beside`). The error is the largest of two points at
ten times: the near half's end and the rocker's, a ball from above and the collar. The reference is SciPy's DOP853 at
1e-11 on equations derived by hand. That all have the same mechanism is seen from the accelerations at its start. Each
program sweeps its own steps or tolerances; for each error the table has the setting of the least processor time, best
of `--repeat` runs in turn; a dash where there is none. Only integration is timed, in one thread. A program that is not
installed is left out with a line that says so.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from stiff.beside.by_scipy import solved
from stiff.beside.four_bar import FourBar
from stiff.beside.governor import Governor
from stiff.beside.program import Array, NotDone, Problem, Program, Setting, off

MECHANISMS: dict[str, Callable[[float], Problem]] = {"four-bar": FourBar, "governor": Governor}
#: The files of scripts/stiff/beside.
FILES = ("by_mbproj", "by_exudyn", "by_mujoco", "by_scipy")


#: So many runs that are fine enough, or as long as anybody waits, end a sweep.
LATE = 3.0
#: Runs of less than so many seconds are repeated so many times more.
SHORT, MORE = 0.02, 4


class Trial(NamedTuple):
    """A setting, its error in m, and the seconds it took."""

    setting: Setting
    error: float
    seconds: float


def installed(files: list[str], problem: Problem) -> list[Program]:
    """The programs that are here."""
    found: list[Program] = []
    for name in files:
        try:
            found += import_module(f"stiff.beside.{name}").programs(problem)
        except ImportError as error:
            print(f"left out: {name} ({error})", file=sys.stderr)
    return found


def reference(problem: Problem) -> Array:
    """Points at the samples, by another method than all that are compared."""
    _, y = solved(problem, 1e-11, 1e-13, "DOP853")
    return problem.points(y[:, : y.shape[1] // 2])


def sweep(program: Program, points: Array, smallest: float, longest: float) -> list[Trial]:
    """From coarse to fine: to the smallest error that is asked for, or until runs take too long."""
    found: list[Trial] = []
    late = 0.0
    for setting in program.settings():
        try:
            seconds, reached = setting.run()
        except NotDone:
            continue
        found.append(Trial(setting, off(reached, points), seconds))
        late += seconds / longest if seconds > longest else float(found[-1].error < smallest)
        if late > LATE:
            break
    return found


def timed(trials: list[Trial], repeat: int) -> dict[str, float]:
    """The least seconds of each setting, of so many runs in turn."""
    best = {trial.setting.label: trial.seconds for trial in trials}
    for k in range(MORE * repeat):
        for trial in trials:
            if k >= repeat and trial.seconds > SHORT:
                continue
            best[trial.setting.label] = min(best[trial.setting.label], trial.setting.run()[0])
    return best


def compare(problem: Problem, programs: list[Program], errors: list[float], repeat: int, longest: float) -> None:
    """Prints the table of one stiffness."""
    points, hand = reference(problem), problem.slope(0.0, problem.start)[len(problem.start) // 2 :]
    print(f"\n{problem.name}, {problem.k:.0e} N/m, 0.2 s: ms of processor time (setting)\n")
    chosen: dict[str, dict[float, Trial]] = {}
    for program in programs:
        apart = float(np.abs(program.accelerations() - hand).max() / np.abs(hand).max())
        found = sweep(program, points, min(errors), longest)
        smallest = min((trial.error for trial in found), default=np.inf)
        print(
            f"{program.name}: accelerations at the start are {apart:.0e} apart, smallest error {smallest:.1e} m",
            file=sys.stderr,
        )
        within = {error: [trial for trial in found if trial.error <= error] for error in errors}
        chosen[program.name] = {
            error: min(row, key=lambda trial: trial.seconds) for error, row in within.items() if row
        }
    print("| |" + "".join(f" ≤ {error:.0e} m |" for error in errors) + "\n|---|" + "---|" * len(errors))
    for name, row in chosen.items():
        seconds = timed(list({one.setting.label: one for one in row.values()}.values()), repeat)
        cells = (
            f"{1e3 * seconds[row[error].setting.label]:.3g} ({row[error].setting.label})" if error in row else "-"
            for error in errors
        )
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def main() -> None:
    """Prints a table for each stiffness."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--dials", nargs="+", type=float, default=[1e6, 1e8])
    parser.add_argument("--errors", nargs="+", type=float, default=[1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
    parser.add_argument("--program", nargs="+", choices=FILES, default=list(FILES))
    parser.add_argument("--mechanism", nargs="+", choices=MECHANISMS, default=list(MECHANISMS))
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--longest", type=float, default=0.25, help="s: a sweep ends after runs that take longer")
    asked = parser.parse_args()
    for mechanism in asked.mechanism:
        for k in asked.dials:
            problem = MECHANISMS[mechanism](k)
            compare(problem, installed(asked.program, problem), asked.errors, asked.repeat, asked.longest)


if __name__ == "__main__":
    main()
