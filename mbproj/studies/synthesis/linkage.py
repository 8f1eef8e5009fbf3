"""Linkages of a crank and dyads: their points in closed form, for many designs and crank angles at once. Points are
complex numbers, x + iz."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array
from mbproj.dataclass import dataclass

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
