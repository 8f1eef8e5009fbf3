"""C++ of this folder, compiled by the system's compiler when it is first needed, and called through ctypes."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from mbproj.motion.steppers.tableau import load_tableau
from peers.peer import (
    NotConverged,
    Observation,
    Setting,
    ode_label,
    seconds_of,
    steps_per_interval,
    tolerance_label,
    tolerances,
)
from peers.problem import Array, Mechanism

#: (tableau, ..., y, duration, steps, tolerance) -> steps; y is advanced in place.
Integrate = Callable[[str, Array, float, int, float], None]


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
    """The shared library of a source file of this folder, kept in ~/.cache/mbproj-peers. Raises NoCompiler."""
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        raise NoCompiler("no C++ compiler")
    here = Path(__file__).parent
    command = [compiler, "-std=c++17", "-O3", "-DNDEBUG", "-shared", "-fPIC", str(here / source), *flags]
    texts = [path.read_bytes() for path in (here / source, here / "runge_kutta.hpp")]
    key = hashlib.sha256(b"".join([*texts, " ".join(command).encode()])).hexdigest()[:16]
    target = Path.home() / ".cache" / "mbproj-peers" / f"{key}.so"
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
    """An exported `integrate` of C++ with its first arguments bound. A step that vanishes raises NotConverged."""

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
            raise NotConverged("the step became too small")

    return run


def fixed_settings(
    run: Integrate, start: Array, measure: Callable[[Array], Observation], mechanism: Mechanism, counts: tuple[int, int]
) -> Iterator[Setting]:
    """RK4 with so many steps between outputs; `measure` takes the states (T, n) at the reference's times."""
    for per_interval in steps_per_interval(*counts):
        total = per_interval * len(mechanism.times)

        def integrate(total: int = total) -> float:
            y = start.copy()
            return seconds_of(lambda: run("rk4", y, mechanism.duration, total, 0.0))

        def observe(per_interval: int = per_interval) -> Observation:
            y, states = start.copy(), []
            for _ in mechanism.times:
                run("rk4", y, mechanism.interval, per_interval, 0.0)
                states.append(y.copy())
            return measure(np.array(states))

        yield Setting(ode_label(mechanism.interval / per_interval), integrate, observe)


def controlled_settings(
    run: Integrate, start: Array, measure: Callable[[Array], Observation], mechanism: Mechanism
) -> Iterator[Setting]:
    """DOP853 to a tolerance. It is observed by runs that end at each of the reference's times, so that the outputs
    neither shorten a step nor are interpolated."""
    for tolerance in tolerances(2, 13):

        def reach(time: float, tolerance: float = tolerance) -> Array:
            y = start.copy()
            run("dop853", y, time, 0, tolerance)
            return y

        def integrate(reach: Callable[[float], Array] = reach) -> float:
            return seconds_of(lambda: reach(mechanism.duration))

        def observe(reach: Callable[[float], Array] = reach) -> Observation:
            return measure(np.array([reach(float(time)) for time in mechanism.times]))

        yield Setting(tolerance_label(tolerance), integrate, observe)
