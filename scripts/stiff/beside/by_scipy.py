"""SciPy's Radau on equations that are derived by hand for one mechanism alone."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from time import process_time

import numpy as np
from scipy.integrate import solve_ivp

from stiff.beside.program import END, TIMES, Array, NotDone, Problem, Program, Setting, tolerances


def solved(problem: Problem, relative: float, absolute: float, method: str = "Radau") -> tuple[float, Array]:
    """Seconds, and coordinates and speeds at the samples (T, 2n)."""
    begun, span = process_time(), (0.0, END)
    found = solve_ivp(problem.slope, span, problem.start, method=method, rtol=relative, atol=absolute, t_eval=TIMES)
    if not found.success:
        raise NotDone(found.message)
    return process_time() - begun, np.asarray(found.y.T)


def _run(problem: Problem, tolerance: float) -> tuple[float, Array]:
    seconds, y = solved(problem, tolerance, tolerance)
    return seconds, problem.points(y[:, : y.shape[1] // 2])


def _settings(problem: Problem) -> Iterator[Setting]:
    for tolerance in tolerances(8):
        yield Setting(f"tolerance {tolerance:.0e}", partial(_run, problem, tolerance))


def programs(problem: Problem) -> list[Program]:
    """One."""

    def accelerations() -> Array:
        return problem.slope(0.0, problem.start)[len(problem.start) // 2 :]

    return [Program("SciPy Radau, by hand", partial(_settings, problem), accelerations)]
