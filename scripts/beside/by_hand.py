"""Equations in minimal coordinates, derived by hand for one mechanism alone: what a general program cannot beat.

Compiled ones (`by_hand.cpp`) run with RK4 and DOP853, and on long motions with the Gauss methods, which are symplectic;
those in Python (`lagrange.py`) with SciPy's Radau.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from time import process_time

import numpy as np
from scipy.integrate import solve_ivp

from .compiled import NoCompiler, advance, library, runge_kutta_settings
from .problem import (
    Array,
    Equations,
    Hand,
    NotDone,
    Outcome,
    Problem,
    Program,
    Setting,
    step_label,
    tolerance_label,
    tolerances,
)

#: Orders of the Gauss methods that run on long motions.
ORDERS = (4, 6, 8)


def by_gauss(
    hand: Hand, order: int, span: float, steps: int, *, extended: bool = False, start: Sequence[float] = ()
) -> tuple[Array, int]:
    """The state (2n,) after `span` s by a Gauss method, and its evaluations."""
    own, y, parts = library("by_hand.cpp"), np.array(start or hand.start, dtype=float), np.zeros(4)
    parts[: len(hand.parts)] = hand.parts
    function = own.gauss_extended if extended else own.gauss_double
    function.restype = ctypes.c_double
    size = ctypes.c_double(span if extended else span / steps)
    done = function(hand.system, _at(parts), order // 2, size, ctypes.c_long(steps), _at(y))
    return y, int(done)


def by_dop853(hand: Hand, span: float, tolerance: float) -> Array:
    """The state (2n,) after `span` s."""
    y, parts = np.array(hand.start, dtype=float), np.array(hand.parts, dtype=float)
    advance(library("by_hand.cpp").advance, hand.system, _at(parts))("dop853", y, span, 0, tolerance)
    return y


def solved(
    equations: Equations, times: Array, relative: float, absolute: float, method: str = "Radau"
) -> tuple[float, Array]:
    """Seconds, and coordinates and speeds at times (T, 2n), by SciPy."""
    begun, span = process_time(), (0.0, float(times[-1]))
    found = solve_ivp(equations.slope, span, equations.start, method=method, rtol=relative, atol=absolute, t_eval=times)
    if not found.success:
        raise NotDone(found.message)
    return process_time() - begun, np.asarray(found.y.T)


def _at(array: Array) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)  # it keeps the array


def _gauss(problem: Problem, hand: Hand, order: int, name: str) -> Iterator[Setting]:
    def run(count: int, times: Array) -> Outcome:
        y, states, evaluations, begun = list(hand.start), [], 0, process_time()
        for _ in times:
            end, done = by_gauss(hand, order, float(times[-1]) / len(times), count // len(times), start=y)
            y, evaluations = end.tolist(), evaluations + done
            states.append(end)
        seconds = process_time() - begun
        return Outcome(hand.watched(np.array(states)), seconds, None, evaluations)

    for step, count in problem.steps(name):
        yield Setting(step_label(step), partial(run, count), count)


def _radau(equations: Equations) -> Iterator[Setting]:
    def run(tolerance: float, times: Array) -> Outcome:
        seconds, y = solved(equations, times, tolerance, tolerance)
        return Outcome(equations.watched(y), seconds)

    for tolerance in tolerances(8):
        yield Setting(tolerance_label(tolerance), partial(run, tolerance))


def programs(problem: Problem) -> Iterator[Program]:
    """Of the equations that the problem has."""
    if problem.equations is not None:
        yield Program("by hand, SciPy's Radau", partial(_radau, problem.equations))
    hand = problem.hand
    if hand is None:
        return
    try:
        function = library("by_hand.cpp").advance
    except NoCompiler as error:
        print(f"left out: equations by hand ({error})", file=sys.stderr)
        return
    parts = np.array(hand.parts, dtype=float)
    run = advance(function, hand.system, _at(parts))
    yield from runge_kutta_settings(
        "by hand", problem, run, np.array(hand.start, dtype=float), lambda states: (hand.watched(states), None)
    )
    for order in ORDERS if problem.rattle is not None else ():
        name = f"by hand, Gauss {order}"
        yield Program(name, partial(_gauss, problem, hand, order, name))
