"""The library of topologies, and the bounds of their numbers."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from mbproj.studies.synthesis.linkage import Dyad, Link, Linkage, Slide

PATH, FUNCTION, POSITIONS = "path", "function", "positions"
_A, _D, _H = ("ax", "az"), ("dx", "dz"), ("hx", "hz")
_P, _E, _F = ("px", "pz"), ("ex", "ez"), ("fx", "fz")
_CRANK = Link("crank", "A", "B", "crank_length")
_ROCKER = Link("rocker", "D", "C", "rocker_length")


def _coupler(**carries: tuple[str, str]) -> Link:
    return Link("coupler", "B", "C", "coupler_length", MappingProxyType(carries))


def _second(**carries: tuple[str, str]) -> Link:
    return Link("rod", "E", "G", "rod_length", MappingProxyType(carries))


_LOOP = Dyad("coupler", "rocker", "side")
_NEXT = Dyad("rod", "lever", "next_side")
_LEVER = Link("lever", "H", "G", "lever_length")
_FOUR_BAR = Linkage({"A": _A, "D": _D}, (_CRANK, _coupler(P=_P), _ROCKER), (_LOOP,), "rocker", "coupler")
_SLIDER_CRANK = Linkage(
    {"A": _A}, (_CRANK, _coupler(P=_P)), (Slide("coupler", "tilt", "offset", "side"),), traced="coupler"
)
_WATT = Linkage(
    {"A": _A, "D": _D},
    (
        _CRANK,
        _coupler(E=_E),
        Link("rocker", "D", "C", "rocker_length", MappingProxyType({"F": _F})),
        _second(P=_P),
        Link("lever", "F", "G", "lever_length"),
    ),
    (_LOOP, _NEXT),
    traced="rod",
)
_STEPHENSON = Linkage(
    {"A": _A, "D": _D, "H": _H},
    (_CRANK, _coupler(E=_E), _ROCKER, _second(P=_P), _LEVER),
    (_LOOP, _NEXT),
    "lever",
    "rod",
)
#: The topologies by name and kind of task. The kinds differ in the link that carries the point of a path, or has the
#: angle of a function.
TOPOLOGIES: Mapping[str, Mapping[str, Linkage]] = MappingProxyType(
    {
        "four_bar": {PATH: _FOUR_BAR, FUNCTION: _FOUR_BAR, POSITIONS: _FOUR_BAR},
        "slider_crank": {PATH: _SLIDER_CRANK, POSITIONS: _SLIDER_CRANK},
        "watt": {
            PATH: _WATT,
            POSITIONS: _WATT,
            FUNCTION: Linkage(
                {"A": _A, "D": _D, "H": _H},
                (
                    _CRANK,
                    _coupler(),
                    Link("rocker", "D", "C", "rocker_length", MappingProxyType({"E": _E})),
                    _second(),
                    _LEVER,
                ),
                (_LOOP, _NEXT),
                "lever",
            ),
        },
        "stephenson": {PATH: _STEPHENSON, FUNCTION: _STEPHENSON, POSITIONS: _STEPHENSON},
    }
)
#: Fixed numbers of a function, which only shift, turn or scale the mechanism: its frame is 1 m.
_STILL = {"ax": 0.0, "az": 0.0, "dx": 1.0, "dz": 0.0}


def bounds(linkage: Linkage, wanted: str, centre: complex, size: float) -> dict[str, tuple[float, float]]:
    """Return the bounds of each number for a task with this centre and extent; a number with equal bounds is fixed."""
    limits: dict[str, tuple[float, float]] = {}
    for x, z in linkage.pivots.values():
        limits[x] = (centre.real - 2.0 * size, centre.real + 2.0 * size)
        limits[z] = (centre.imag - 2.0 * size, centre.imag + 2.0 * size)
    for link in linkage.links:
        limits[link.length] = (0.05 * size, 3.0 * size)
        for name, (x, z) in link.carries.items():
            idle = wanted == FUNCTION and name == "P"
            limits[x] = limits[z] = (0.0, 0.0) if idle else (-2.0 * size, 2.0 * size)
    for step in linkage.steps:
        if isinstance(step, Slide):
            limits[step.tilt], limits[step.offset] = (-np.pi, np.pi), (-size, size)
    limits["start"] = (-np.pi, np.pi)
    if wanted == FUNCTION:
        limits |= {name: (value, value) for name, value in _STILL.items() if name in limits}
    return limits
