"""Errors and times: of each program and each error asked for, the cheapest setting whose error is below it, side by
side.

Each setting runs once with all samples, for its error, and for its time once with the end alone. Those that may be the
quickest are timed again in turn. A coarse setting may be below an error by luck, in all programs alike.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from statistics import median
from typing import Any

import numpy as np

from .problem import NotDone, Outcome, Problem, Program, Setting

#: The files of programs, and what each needs that mbproj does not.
PROGRAMS = {
    "mbproj": "",
    "mujoco": "mujoco",
    "pinocchio": "pin; from C++: cmeel-eigen, c++",
    "exudyn": "exudyn",
    "simbody": "opensim",
    "hand": "c++",
    "rattle": "c++",
}
#: Runs shorter than this are repeated within a repetition, s.
SHORTEST = 2e-3
#: Runs shorter than this are timed three times at once, s: the first builds what others find.
SHORT = 0.05
#: A sweep ends when so many settings in a row did not lower the error by a tenth, or have failed.
PLATEAU, FAILED = 8, 100
#: Settings are timed in full whose first timing was within this factor of the quickest that is accurate enough.
NEAR = 1.5
#: A motion is lost that is so far off.
LOST = 1e-3


@dataclass
class Trial:
    """A setting of a program with its error, what it came to, and the seconds of each repetition."""

    problem: Problem
    program: Program
    setting: Setting
    error: float
    outcome: Outcome
    pilot: float
    seconds: list[float] = field(default_factory=list)

    @property
    def time(self) -> float:
        """The median of the repetitions, s."""
        return median(self.seconds) if self.seconds else self.pilot

    def run(self) -> float:
        """Seconds of the motion without samples before its end."""
        return self.setting.run(self.problem.times[-1:]).seconds

    @property
    def followed(self) -> float:
        """The last sample until which the error stays below LOST, s; NaN where the reference ends before."""
        exact, _ = self.problem.reference
        off = np.linalg.norm(self.outcome.watched - exact, axis=-1).max(axis=-1)
        lost = np.flatnonzero(~(off <= LOST))
        if not len(lost):
            return self.problem.end
        return float("nan") if np.isnan(off[lost[0]]) else float(self.problem.times[lost[0]])

    def facts(self) -> dict[str, Any]:
        """For JSON, and for the figure."""
        return {
            "program": self.program.name,
            "setting": self.setting.label,
            "error": self.error,
            "seconds": self.time,
            "all_seconds": self.seconds,
            "opening": self.outcome.opening,
            "steps": self.setting.steps,
            "evaluations": self.outcome.evaluations,
        }


def installed(problem: Problem, wanted: Iterable[str]) -> list[Program]:
    """The programs that are here and that can do the problem; those that are missing are named."""
    found: list[Program] = []
    for name in ["mbproj"] if problem.alone else wanted:
        try:
            found += import_module(f".by_{name}", __package__).programs(problem)
        except ImportError as error:
            print(f"left out: {name} ({error}; it needs {PROGRAMS[name]})", file=sys.stderr)
    return found


def tried(problem: Problem, program: Program) -> Iterator[Trial]:
    """All settings that finish, from coarse to fine, each run once with samples and once for its time."""
    failed = 0
    for setting in program.settings():
        try:
            seen = setting.run(problem.times)
            again = 3 if seen.seconds < SHORT else problem.samples > 1
            pilot = min([setting.run(problem.times[-1:]).seconds for _ in range(again)], default=seen.seconds)
        except NotDone as error:
            if problem.tried:
                print(f"{program.name}, {setting.label}: {error}", file=sys.stderr, flush=True)
            failed += 1
            if failed >= FAILED:
                return
            continue
        failed = 0
        yield Trial(problem, program, setting, problem.error(seen.watched), seen, pilot)


def sweep(problem: Problem, program: Program, errors: Sequence[float], longest: float) -> list[Trial]:
    """Until the smallest of `errors` is met, or the sweep is exhausted, slow or at its plateau."""
    trials: list[Trial] = []
    best, stuck = float("inf"), 0
    for trial in tried(problem, program):
        trials.append(trial)
        stuck = 0 if trial.error < 0.9 * best else stuck + 1
        best = min(best, trial.error)
        slow = trial.pilot > longest
        if best <= min(errors) or slow or (stuck >= PLATEAU and best < 0.1 * max(errors)):
            break
    return trials


def candidates(trials: Iterable[Trial], errors: Sequence[float]) -> list[Trial]:
    """The trials that may be the quickest for one of the errors."""
    chosen: list[Trial] = []
    for error in errors:
        able = [trial for trial in trials if trial.error <= error]
        quickest = min((trial.pilot for trial in able), default=0.0)
        chosen += [trial for trial in able if trial.pilot <= NEAR * quickest and trial not in chosen]
    return chosen


def interleave(trials: Sequence[Trial], repetitions: int) -> None:
    """Times all trials in turn, `repetitions` times over, so that a slow spell of the machine meets all of them."""
    for _ in range(repetitions):
        for trial in trials:
            count = max(1, round(SHORTEST / max(trial.pilot, 1e-6)))
            trial.seconds.append(median(trial.run() for _ in range(count)))


def cheapest(trials: Iterable[Trial], error: float) -> Trial | None:
    """The quickest trial whose error is at most `error`."""
    return min((trial for trial in trials if trial.error <= error), key=lambda trial: trial.time, default=None)


def compare(
    problem: Problem, programs: list[Program], errors: Sequence[float], repeat: int, longest: float
) -> dict[str, list[Trial]]:
    """By program the trials that may be the quickest, timed; nothing for a program that has no setting."""
    found: dict[str, list[Trial]] = {}
    for program in programs:
        print(f"sweeping {program.name} ...", file=sys.stderr, flush=True)
        trials = sweep(problem, program, errors, longest)
        if trials:
            best = min(trials, key=lambda trial: trial.error)
            told = f"  smallest error {best.error:.1e} {problem.unit} at {best.setting.label}"
            print(told, file=sys.stderr, flush=True)
            found[program.name] = candidates(trials, errors)
    interleave([trial for trials in found.values() for trial in trials], repeat)
    return found


def print_cheapest(problem: Problem, errors: Sequence[float], found: dict[str, list[Trial]]) -> None:
    """For each error the cheapest setting, as Markdown, and the settings behind it."""
    heads = " | ".join(f"≤ {error:.0e} {problem.unit}" for error in errors)
    print(f"\n{problem.title}: ms of processor time per second of motion\n")
    print(f"| | {heads} | open by, m |\n|---|{'---|' * (len(errors) + 1)}")
    chosen = {name: [cheapest(trials, error) for error in errors] for name, trials in found.items()}
    for name, cells in chosen.items():
        times = " | ".join("-" if cell is None else f"{1e3 * cell.time / problem.end:.2g}" for cell in cells)
        opened = [cell.outcome.opening for cell in cells if cell is not None and cell.outcome.opening is not None]
        extent = f"{min(opened):.0e} to {max(opened):.0e}" if opened else "-"
        print(f"| {name} | {times} | {extent} |")
    print("\nSettings:")
    for name, cells in chosen.items():
        print(f"- {name}: " + "; ".join(cell.setting.label if cell else "-" for cell in cells))


def print_all(problem: Problem, trials: Iterable[Trial]) -> list[Trial]:
    """Every setting of every program, as Markdown, while they run."""
    print(f"\n{problem.title}; the reference is certain to {problem.reference[1]:.0e} {problem.unit}\n")
    print(f"| program | setting | error, {problem.unit} | open by, m | evaluations | ms | µs a step |\n|{'---|' * 7}")
    done = []
    for trial in trials:
        done.append(trial)
        opened = "-" if trial.outcome.opening is None else f"{trial.outcome.opening:.0e}"
        evaluations = f"{trial.outcome.evaluations:.2e}" if trial.outcome.evaluations else "-"
        pace = f"{1e6 * trial.time / trial.setting.steps:.3g}" if trial.setting.steps else "-"
        cells = (trial.program.name, trial.setting.label, f"{trial.error:.1e}", opened, evaluations)
        print(f"| {' | '.join(cells)} | {1e3 * trial.time:.3g} | {pace} |", flush=True)
    return done
