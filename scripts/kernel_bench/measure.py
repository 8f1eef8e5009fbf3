"""Processor time of runs without recording, and what a run keeps in memory."""

from __future__ import annotations

import ctypes
import gc
from pathlib import Path
from resource import getpagesize
from statistics import median
from time import thread_time
from typing import Any

from kernel_bench.case import Case
from mbproj.motion.formulations.compiled import PHASES

#: Longer than any run, s.
FOREVER = 1e6
#: A repetition repeats its run until it took so long, s, so that the clock's grain does not count.
LEAST_SECONDS = 0.05


def measure(case: Case, repeat: int) -> dict[str, Any]:
    """Times per step of each repetition, µs, and what the steps were: passes of the position projection a step, the
    largest |C| after any step (m or rad), the share of each phase."""
    _run(case)
    seconds, phases = [], dict.fromkeys(PHASES, 0.0)
    for _ in range(repeat):
        spent, runs = 0.0, 0
        while spent < LEAST_SECONDS:
            once, run = _run(case)
            spent, runs = spent + once, runs + 1
            for phase, part in zip(PHASES, run.phase_seconds, strict=True):
                phases[phase] += part
        seconds.append(1e6 * spent / (runs * case.steps))
    counters = run.counters.tolist()
    measured = sum(phases.values())
    return {
        "bodies": case.bodies,
        "formulation": case.compiled.name,
        "frequency": case.frequency,
        "step": case.settings.step,
        "steps": case.steps,
        "us_per_step": seconds,
        "fastest": min(seconds),
        "median": median(seconds),
        "passes_per_step": counters[4] / counters[0],
        "factorisations_per_step": counters[7] / counters[0],
        "position_peak": run.position_peak.value,
        "phases": {phase: part / measured for phase, part in phases.items()} if measured else None,
    }


def _run(case: Case) -> tuple[float, Any]:
    """Processor seconds of a run after its start, and the run. Its samples are the start and the end."""
    run = case.compiled.run(case.start, case.settings)
    run.advance(1, FOREVER)
    begun = thread_time()
    run.advance(1, FOREVER)
    spent = thread_time() - begun
    failure = case.compiled.failure(run, case.settings)
    if failure is not None:
        raise failure
    return spent, run


def memory(case: Case) -> float:
    """Bytes a body by which the resident memory grows when a run has begun. What is free goes back to the system before
    and after, so that what is new does not hide in it."""
    run = case.compiled.run(case.start, case.settings)  # what is loaded and built once is there before
    del run
    before = _resident()
    run = case.compiled.run(case.start, case.settings)
    run.advance(1, FOREVER)
    grown = _resident() - before
    del run
    return grown / case.bodies


def _resident() -> int:
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * getpagesize()
