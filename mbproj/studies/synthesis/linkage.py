"""Linkages of a crank and dyads: their points in closed form, for many designs and crank angles at once. Points are
complex numbers, x + iz.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass

#: Numbers (B, 1) of B designs by their names.
Numbers = Mapping[str, Array]
#: Points (B, N) of B designs at N crank angles.
Points = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Link:
    """A body from the point `origin` towards the point `toward`, at the distance that the parameter `length` names;
    further points that it `carries` by their two coordinates along and across."""

    name: str
    origin: str
    toward: str
    length: str
    carries: Mapping[str, tuple[str, str]] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True)
class Dyad:
    """Two links with the same point `toward`. The parameter `side` is 1 where this point is to the left of the line
    from the first origin to the second, and -1 to the right."""

    first: str
    second: str
    side: str


@dataclass(frozen=True)
class Slide:
    """A link whose end moves on a line through the crank's pivot, tilted by the angle `tilt` and shifted across by
    `offset`. `side` is 1 where the end is ahead of the link's origin along the line."""

    link: str
    tilt: str
    offset: str
    side: str


@dataclass(frozen=True)
class Linkage:
    """A topology: `pivots` in the ground by their coordinates' parameters; the first of the `links` is the crank.
    `output` is the link whose angle is the function, `traced` carries the point P of the path."""

    pivots: Mapping[str, tuple[str, str]]
    links: tuple[Link, ...]
    steps: tuple[Dyad | Slide, ...]
    output: str = ""
    traced: str = ""

    def link(self, name: str) -> Link:
        """The link with this name."""
        return next(each for each in self.links if each.name == name)

    @property
    def sides(self) -> tuple[str, ...]:
        """The parameters ±1 that select the assembly."""
        return tuple(step.side for step in self.steps)

    def solved(self, p: Numbers, crank: Array) -> Mapping[str, Points]:
        """Return the points, by name, of designs with numbers (B, 1) at crank angles (B, N) or (N,); NaN where a design
        does not close."""
        with np.errstate(all="ignore"):
            return dict(self._points(p, crank))

    def _points(self, p: Numbers, crank: Array) -> Iterator[tuple[str, Points]]:
        known: dict[str, Any] = {name: p[x] + 1j * p[z] for name, (x, z) in self.pivots.items()}
        first = self.links[0]
        known[first.toward] = known[first.origin] + p[first.length] * np.exp(1j * crank)
        for step in self.steps:
            if isinstance(step, Slide):
                links = [self.link(step.link)]
                known[links[0].toward] = _slid(known[links[0].origin], known[first.origin], p, step, links[0])
            else:
                links = [self.link(step.first), self.link(step.second)]
                one, two = links
                ends = known[one.origin], known[two.origin]
                known[one.toward] = meeting_point(*ends, p[one.length], p[two.length], p[step.side])
            for link in links:
                along = (known[link.toward] - known[link.origin]) / p[link.length]
                for name, (x, z) in link.carries.items():
                    known[name] = known[link.origin] + along * (p[x] + 1j * p[z])
        shape = np.broadcast_shapes(*(np.shape(each) for each in known.values()))
        yield from ((name, np.broadcast_to(each, shape)) for name, each in known.items())


def meeting_point(a: Points, b: Points, from_a: Array, from_b: Array, side: Array) -> Points:
    """Return the point at given distances from a and from b, to the left of the line from a to b where `side` is 1. NaN
    where a and b are too far apart or too near."""
    apart = np.abs(b - a)
    along = (from_a**2 - from_b**2 + apart**2) / (2.0 * apart)
    points: Points = a + (b - a) / apart * (along + 1j * side * np.sqrt(from_a**2 - along**2))
    return points


def _slid(origin: Points, pivot: Points, p: Numbers, step: Slide, link: Link) -> Points:
    line = np.exp(1j * p[step.tilt])
    seen = (origin - pivot) / line
    across = p[step.offset] - seen.imag
    ahead = seen.real + p[step.side] * np.sqrt(p[link.length] ** 2 - across**2)
    points: Points = pivot + line * (ahead + 1j * p[step.offset])
    return points


# --- A spatial four-bar -----------------------------------------------------------------------------------------------
# Two levers on axes that are skew, and a rod between balls at their ends (RSSR), in closed form.
# The crank turns about -y at the origin; its end is a (cos θ, 0, sin θ). The lever turns about an axis that is tilted
# by `twist` about x, at the point (1, y, z) in m; its end is b (cos ψ e1 + sin ψ e2) from there.


LENGTHS = ("crank_length", "rod_length", "lever_length")


class SpatialFourBar:
    """A spatial four-bar, for functions only: the rod may turn about its axis, so that its points have no unique
    path."""

    sides = ("side",)

    def angle(self, p: Numbers, crank: Array) -> Array:
        """The lever's angle ψ (B, N) at crank angles; NaN where the rod is too long or too short."""
        a, rod, b = (p[name] for name in LENGTHS)
        x, y, z = a * np.cos(crank) - 1.0, -p["dy"], a * np.sin(crank) - p["dz"]
        across = y * np.sin(p["twist"]) + z * np.cos(p["twist"])
        wanted = (x**2 + y**2 + z**2 + b**2 - rod**2) / (2.0 * b)
        with np.errstate(all="ignore"):
            return np.asarray(np.arctan2(across, x) + p["side"] * np.arccos(wanted / np.hypot(x, across)))

    def bounds(self) -> dict[str, tuple[float, float]]:
        """The bounds of its numbers; the axes are 1 m apart along x."""
        near = dict.fromkeys(LENGTHS, (0.05, 3.0))
        return {**near, "dy": (-2.0, 2.0), "dz": (-2.0, 2.0), "twist": (-np.pi, np.pi), "start": (-np.pi, np.pi)}


# --- The library of topologies, and the bounds of their numbers -------------------------------------------------------


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
