"""Processor time of runs without recording, and what a run keeps in memory."""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Iterator
from contextlib import contextmanager
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


def memory(case: Case) -> dict[str, Any]:
    """Bytes a body that a run holds when it has begun: its growth of the resident memory, and where the C library tells
    it, what is allocated."""
    run = case.compiled.run(case.start, case.settings)  # what is loaded and built once is there before
    del run
    with _growth() as grown:
        run = case.compiled.run(case.start, case.settings)
        run.advance(1, FOREVER)
    return {key: None if size is None else size / case.bodies for key, size in grown.items()}


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


@contextmanager
def _growth() -> Iterator[dict[str, int | None]]:
    """How much the resident and the allocated memory, in bytes, have grown when the block ends."""
    grown: dict[str, int | None] = {}
    gc.collect()
    _trim()
    resident, allocated = _resident(), _allocated()
    yield grown
    _trim()
    now = _allocated()
    grown["resident"] = _resident() - resident
    grown["allocated"] = None if now is None or allocated is None else now - allocated


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * getpagesize()


class _Mallinfo(ctypes.Structure):
    """struct mallinfo2 of the GNU C library, from 2.33 on."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            "arena",
            "ordblks",
            "smblks",
            "hblks",
            "hblkhd",
            "usmblks",
            "fsmblks",
            "uordblks",
            "fordblks",
            "keepcost",
        )
    )


def _allocated() -> int | None:
    """What malloc has handed out, in its heap and in mappings of their own; None where the C library does not tell."""
    try:
        mallinfo2 = ctypes.CDLL(None).mallinfo2
    except AttributeError:
        return None
    mallinfo2.restype = _Mallinfo
    found = mallinfo2()
    return int(found.uordblks) + int(found.hblkhd)


def _trim() -> None:
    """Gives free memory back to the system, so that what follows does not hide in it."""
    try:
        ctypes.CDLL(None).malloc_trim(0)
    except AttributeError:
        return
