"""Pinocchio called from C++ (the headers and libraries of its wheel): no Python between the steps.

Runs what pinocchio_python.py runs, with the RK4 and DOP853 of runge_kutta.hpp. Compiling its templates takes minutes
the first time. No -march=native: the alignment of Eigen must be that of the wheel, or it crashes. The headers of
Eigen come from the package cmeel-eigen.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pinocchio as pin

from peers.compiled import Integrate, NoCompiler, advance, controlled_settings, fixed_settings, library
from peers.peer import Observation, Peer, Setting, ode_label, seconds_of
from peers.pinocchio_python import Chain as PythonChain
from peers.pinocchio_python import SliderCrank as PythonSliderCrank
from peers.problem import FIVE_BAR, Array, Chain, Mechanism

PREFIX = next(parent for parent in Path(pin.__file__).parents if parent.name == "cmeel.prefix")
if not (PREFIX / "include" / "eigen3").is_dir():
    raise NoCompiler("no headers of Eigen beside Pinocchio's; pip install cmeel-eigen")
#: As Pinocchio's CMake files ask for.
DEFINITIONS = (
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION",
)
LIBRARY = library(
    "pinocchio_compiled.cpp",
    (
        *DEFINITIONS,
        f"-I{PREFIX}/include",
        f"-I{PREFIX}/include/eigen3",
        f"-L{PREFIX}/lib",
        "-lpinocchio_default",
        f"-Wl,-rpath,{PREFIX}/lib",
    ),
)
LIBRARY.chain.restype = LIBRARY.slider_crank.restype = ctypes.c_long
LIBRARY.chain_model.restype = LIBRARY.slider_crank_model.restype = ctypes.c_void_p


def _chain(links: int) -> Integrate:
    return advance(LIBRARY.chain, ctypes.c_void_p(LIBRARY.chain_model(ctypes.c_int(links))))


def _settings(method: str, mechanism: Mechanism) -> Iterator[Setting]:
    run: Integrate
    measure: Callable[[Array], Observation]
    if mechanism is FIVE_BAR:
        run, start, measure = _chain(5), np.zeros(10), PythonChain(5).measure
    else:
        crank = PythonSliderCrank()
        run = advance(LIBRARY.slider_crank, ctypes.c_void_p(LIBRARY.slider_crank_model()))
        start, measure = crank.start, crank.measure
    if method == "rk4":
        yield from fixed_settings(run, start, measure, mechanism, (20, 20_000))
    else:
        yield from controlled_settings(run, start, measure, mechanism)


def _chain_setting(chain: Chain) -> Setting:
    run, python = _chain(chain.links), PythonChain(chain.links)

    def end() -> Array:
        y = python.start.copy()
        run("rk4", y, chain.steps * chain.step, chain.steps, 0.0)
        return y

    return Setting(ode_label(chain.step), lambda: seconds_of(end), lambda: python.measure(end()[None]))


PEERS = (
    Peer("Pinocchio in C++, DOP853", partial(_settings, "dop853")),
    Peer("Pinocchio in C++, RK4", partial(_settings, "rk4"), _chain_setting),
)
