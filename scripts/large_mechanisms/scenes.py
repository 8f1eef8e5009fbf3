"""Scenes of any size, as text: chains, ladders, grids of scissors, four-bars that share bodies, walking linkages.

Every one but the walking linkage starts closed. Chains have no redundant rows, ladders none, all others have.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import product

import numpy as np
import numpy.typing as npt

from .walking_linkage import walking_linkage

#: Angle of the scissors with the plane of the grid, rad, and length of their bars, m.
OPENED, BAR = math.radians(40.0), 1.0
Point = Sequence[float] | npt.NDArray[np.float64]


def chain(links: int) -> str:
    """Bars of 1 m that hang in a row; the axes of their hinges alternate between x and y."""
    bodies = [_body(f"b{k}", 1.0, 0.08, (0.0, 0.0, -k - 0.5)) for k in range(links)]
    joints = [
        _hinge(f"j{k}", f"b{k - 1}" if k else "ground", f"b{k}", (0.0, 0.0, -k), (k % 2, 1 - k % 2, 0.0))
        for k in range(links)
    ]
    return scene(f"a chain of {links} links", bodies, joints)


def ladder(loops: int) -> str:
    """Parallelograms one below the other, closed in space without redundant rows."""
    bodies, joints = [], []
    for k in range(loops):
        frame, left, right, rung = f"rung{k - 1}" if k else "ground", f"left{k}", f"right{k}", f"rung{k}"
        bodies += [
            _body(left, 1.0, 0.08, (-0.5, 0.0, -k - 0.5)),
            _body(right, 1.0, 0.08, (0.5, 0.0, -k - 0.5)),
            _body(rung, 1.0, 0.08, (0.0, 0.0, -k - 1)),
        ]
        joints += [
            _hinge(f"A{k}", frame, left, (-0.5, 0.0, -k), (0, 1, 0)),
            _hinge(f"D{k}", frame, right, (0.5, 0.0, -k), (0, 1, 0)),
            f"B{k}: {{type: spherical, bodies: [{left}, {rung}], location: {_list((-0.5, 0.0, -k - 1))}}}",
            f"C{k}: {{type: universal, bodies: [{rung}, {right}], location: {_list((0.5, 0.0, -k - 1))}, "
            f"axes: [[0, 0, 1], [0, 1, 0]]}}",
        ]
    return scene(f"a ladder of {loops} loops", bodies, joints)


def scissor_grid(cells: int) -> str:
    """A grid of cells × cells: hubs above each other at its points, and scissors of two crossed bars between them."""
    step, height = BAR * math.cos(OPENED), BAR * math.sin(OPENED)
    points = list(product(range(cells + 1), repeat=2))
    bodies = [
        _body(f"{level}{i}_{j}", 0.1, 0.001, (i * step, j * step, z))
        for i, j in points
        for level, z in (("l", 0.0), ("u", height))
    ]
    joints: list[str] = []
    for along, (di, dj), axis in (("x", (1, 0), (0, 1, 0)), ("y", (0, 1), (1, 0, 0))):
        for i, j in points:
            if i + di > cells or j + dj > cells:
                continue
            near, far, name = f"{i}_{j}", f"{i + di}_{j + dj}", f"{along}{i}_{j}"
            start, end = np.array([i * step, j * step, 0.0]), np.array([(i + di) * step, (j + dj) * step, 0.0])
            up, middle = np.array([0.0, 0.0, height]), (start + end + [0.0, 0.0, height]) / 2
            bodies += [_body(f"{name}{bar}", 1.0, 0.08, middle) for bar in "ab"]
            joints += [
                _hinge(f"{name}c", f"{name}a", f"{name}b", middle, axis),
                _hinge(f"{name}1", f"l{near}", f"{name}a", start, axis),
                _hinge(f"{name}2", f"{name}a", f"u{far}", end + up, axis),
                _hinge(f"{name}3", f"u{near}", f"{name}b", start + up, axis),
                _hinge(f"{name}4", f"{name}b", f"l{far}", end, axis),
            ]
    return scene(f"a grid of {cells} x {cells} scissors", bodies, joints)


def shared_four_bars(loops: int) -> str:
    """Parallelograms in a row, which share their rockers: each rocker but the last carries two couplers."""
    rocker = [_body(f"rocker{k}", 1.0, 0.08, (float(k), 0.0, 0.5)) for k in range(loops + 1)]
    coupler = [_body(f"coupler{k}", 1.0, 0.08, (k + 0.5, 0.0, 1.0)) for k in range(loops)]
    joints = [_hinge(f"A{k}", "ground", f"rocker{k}", (float(k), 0.0, 0.0), (0, 1, 0)) for k in range(loops + 1)]
    for k in range(loops):
        joints.append(_hinge(f"B{k}", f"rocker{k}", f"coupler{k}", (float(k), 0.0, 1.0), (0, 1, 0)))
        joints.append(_hinge(f"C{k}", f"coupler{k}", f"rocker{k + 1}", (k + 1.0, 0.0, 1.0), (0, 1, 0)))
    return scene(f"{loops} four-bars that share their rockers", [*rocker, *coupler], joints)


def walker(pairs: int) -> str:
    """Pairs of legs on cranks, started open: see `walking_linkage`."""
    return scene(f"a walking linkage of {2 * pairs} legs", *walking_linkage(pairs))


def scene(title: str, bodies: Sequence[str], joints: Sequence[str]) -> str:
    """A scene of 100 steps, with 11 samples."""
    return "\n".join(_lines(title, bodies, joints)) + "\n"


def _lines(title: str, bodies: Sequence[str], joints: Sequence[str]) -> Iterator[str]:
    yield from ("mbproj: 1", f"title: {title}", "gravity: [0, 0, -9.8]", "simulation:", "  duration: 0.1 s")
    yield from ("  step: 0.001 s", "  output_step: 0.01 s", "  integrator: rk4", "  projection: gpopm", "bodies:")
    yield from (f"  {body}" for body in bodies)
    yield "joints:"
    yield from (f"  {joint}" for joint in joints)


def _body(name: str, mass: float, inertia: float, at: Point) -> str:
    return f"{name}: {{mass: {mass}, inertia: {_list([inertia] * 3)}, position: {_list(at)}}}"


def _hinge(name: str, first: str, second: str, at: Point, axis: Point) -> str:
    return f"{name}: {{type: revolute, bodies: [{first}, {second}], location: {_list(at)}, axis: {_list(axis)}}}"


def _list(numbers: Point) -> str:
    return f"[{', '.join(f'{float(number):.15g}' for number in numbers)}]"


#: The families by name, each with the bodies that one unit of size has, about.
FAMILIES: dict[str, Callable[[int], str]] = {
    "chain": chain,
    "ladder": ladder,
    "grid": scissor_grid,
    "four_bars": shared_four_bars,
    "walker": walker,
}
