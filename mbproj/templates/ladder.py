"""Loops one below the other: parallelograms, each hanging on the one above."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.templates.bars import SIMULATION
from mbproj.templates.pendulum import closed_and_kept
from mbproj.templates.values import Values

DEFAULTS = {"loops": "3", "length": "1 m", "mass": "1 kg"}


def ladder(values: Values) -> Iterator[str]:
    """Yield the lines of a ladder with as many loops as its option says."""
    loops = values.count("loops")
    yield from (
        "# A ladder of parallelograms: two rails and a rung, on which the next two rails hang. Each loop is closed by",
        "# revolute, spherical, universal and revolute joint: in space four revolutes would hold its plane twice over.",
        "# The rungs stay level, whatever the rails do.",
        "mbproj: 1",
        f"title: Ladder of {loops}",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("length", "mass"),
        "  radius: length / 50                    # of the bars",
        "  kick: 0.2 * sqrt(g / length)           # of the first rails at the start",
        *SIMULATION,
        "bodies:                                  # rails are along z, rungs along x",
    )
    for k in range(loops):
        yield from _bar(f"left{k + 1}", "z", f"-length/2, 0, -{k + 0.5:g} * length")
        yield from _bar(f"right{k + 1}", "z", f"length/2, 0, -{k + 0.5:g} * length")
        yield from _bar(f"rung{k + 1}", "x", f"0, 0, -{k + 1} * length")
    yield "joints:"
    for k in range(loops):
        frame, speed = (f"rung{k}", "0") if k else ("ground", "kick")
        n, top, low = k + 1, f"-{k} * length", f"-{k + 1} * length"
        yield f"  A{n}: {{type: revolute, bodies: [{frame}, left{n}], location: [-length/2, 0, {top}], axis: [0, 1, 0],"
        yield f"    speed: {speed}}}"
        yield f"  B{n}: {{type: spherical, bodies: [left{n}, rung{n}], location: [-length/2, 0, {low}]}}"
        yield f"  C{n}: {{type: universal, bodies: [rung{n}, right{n}], location: [length/2, 0, {low}],"
        yield "    axes: [[0, 0, 1], [0, 1, 0]]}"
        yield f"  D{n}: {{type: revolute, bodies: [{frame}, right{n}], location: [length/2, 0, {top}],"
        yield "    axis: [0, 1, 0]}"
    yield from (
        "markers:",
        f"  lowest: {{body: rung{loops}, location: {{rung{loops}: [0, 0, 0]}}}}",
        "expect:",
        f"  level: {{body: rung{loops}, quantity: orientation, at: end, value: [1, 0, 0, 0], absolute: 1.0e-10,",
        "          source: parallelograms}",
        *closed_and_kept("1.0e-6", size=loops * values.number["length"]),
    )


def _bar(name: str, axis: str, position: str) -> Iterator[str]:
    yield f"  {name}:"
    yield "    mass: mass"
    yield f"    shape: {{cylinder: {{radius: radius, length: length, axis: {axis}}}}}"
    yield f"    position: [{position}]"
