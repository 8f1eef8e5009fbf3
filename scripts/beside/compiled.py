"""C++ of this folder, compiled by the system's compiler when it is first needed, and called through ctypes."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from time import process_time

import numpy as np

from mbproj.motion.steppers.tableau import load_tableau

from .problem import Array, NotDone, Outcome, Problem, Program, Setting, step_label, tolerance_label, tolerances

#: (tableau, y, duration, steps, tolerance): y is advanced in place; a tolerance of 0 means fixed steps.
Integrate = Callable[[str, Array, float, int, float], None]
#: What is watched in states (T, n), and the opening.
Seen = Callable[[Array], tuple[Array, float | None]]


class NoCompiler(ImportError):
    """There is no C++ compiler, or it refuses the source."""


class _Tableau(ctypes.Structure):
    _fields_ = (
        ("stages", ctypes.c_int),
        ("estimates", ctypes.c_int),
        ("error_order", ctypes.c_int),
        ("a", ctypes.c_void_p),
        ("b", ctypes.c_void_p),
        ("error", ctypes.c_void_p),
    )


@cache
def tableau(name: str) -> tuple[_Tableau, tuple[Array, ...]]:
    """A method of mbproj's data files for the C++ side, with the arrays that it points into."""
    read = load_tableau(name)
    kept = tuple(np.ascontiguousarray(array) for array in (read.a, read.b, read.error))
    return _Tableau(read.stages, len(read.error), read.error_order, *(array.ctypes.data for array in kept)), kept


@cache
def library(source: str, flags: Sequence[str] = ()) -> ctypes.CDLL:
    """The shared library of a source file of this folder, kept in ~/.cache/mbproj-beside. Raises NoCompiler."""
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        raise NoCompiler("no C++ compiler")
    here = Path(__file__).parent
    command = [compiler, "-std=c++17", "-O3", "-DNDEBUG", "-shared", "-fPIC", str(here / source), *flags]
    texts = [path.read_bytes() for path in (here / source, here / "runge_kutta.hpp")]
    key = hashlib.sha256(b"".join([*texts, " ".join(command).encode()])).hexdigest()[:16]
    target = Path.home() / ".cache" / "mbproj-beside" / f"{key}.so"
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        print(f"compiling {source} ...", file=sys.stderr, flush=True)
        part = target.with_suffix(f".{os.getpid()}")
        done = subprocess.run([*command, "-o", str(part)], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise NoCompiler(f"{source} does not compile: {done.stderr.strip()[-300:]}")
        part.replace(target)
    return ctypes.CDLL(str(target))


def advance(function: Callable[..., int], *arguments: object) -> Integrate:
    """An exported `advance` of C++ with its first arguments bound. A step that vanishes raises NotDone."""

    def run(method: str, y: Array, duration: float, steps: int, tolerance: float) -> None:
        coefficients, _ = tableau(method)
        done = function(
            ctypes.byref(coefficients),
            *arguments,
            ctypes.c_void_p(y.ctypes.data),
            ctypes.c_double(duration),
            ctypes.c_long(steps),
            ctypes.c_double(tolerance),
        )
        if done < 0 or not np.isfinite(y).all():
            raise NotDone("the step became too small")

    return run


def runge_kutta_settings(name: str, problem: Problem, run: Integrate, start: Array, seen: Seen) -> Iterator[Program]:
    """RK4 with fixed steps and DOP853 to a tolerance."""

    def by_rk4(count: int, times: Array) -> Outcome:
        y, states, seconds = start.copy(), [], 0.0
        for _ in times:
            begun = process_time()
            run("rk4", y, float(times[-1]) / len(times), count // len(times), 0.0)
            seconds += process_time() - begun
            states.append(y.copy())
        watched, opened = seen(np.array(states))
        return Outcome(watched, seconds, opened, 4 * count)

    def by_dop853(tolerance: float, times: Array) -> Outcome:
        """By runs that end at each sample, so that outputs neither shorten a step nor are interpolated."""
        states, seconds = [], 0.0
        for time in times:
            y, begun = start.copy(), process_time()
            run("dop853", y, float(time), 0, tolerance)
            seconds = process_time() - begun
            states.append(y)
        watched, opened = seen(np.array(states))
        return Outcome(watched, seconds, opened)

    def fixed() -> Iterator[Setting]:
        for step, count in problem.steps(f"{name}, RK4"):
            yield Setting(step_label(step), partial(by_rk4, count), count)

    def controlled() -> Iterator[Setting]:
        for tolerance in tolerances():
            yield Setting(tolerance_label(tolerance), partial(by_dop853, tolerance))

    yield Program(f"{name}, RK4", fixed)
    if not problem.tried:
        yield Program(f"{name}, DOP853", controlled)
