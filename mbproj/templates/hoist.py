"""A drum, a rope and a moving block whose load falls; the fall and the tension of the rope have closed forms."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.templates.values import Values

DEFAULTS = {"radius": "10 cm", "mass": "50 kg", "length": "2 m"}


def hoist(values: Values) -> Iterator[str]:
    """Yield the lines of a hoist whose load falls by the option `length`."""
    yield from (
        "# A hoist whose brake has failed: the load hangs on a moving block, around which a rope runs from the drum to",
        "# the ceiling. So two strands carry it, and the drum pays out twice as much rope as the load falls.",
        "# `mbproj help run_a_rope_over_sheaves` has more places and ropes.",
        "mbproj: 1",
        "title: Hoist",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("radius", "mass", "length"),
        "  drum: 0.4 * mass                       # a solid cylinder",
        "  inertia: drum * radius**2 / 2          # of the drum about its axle",
        "  fall: g * mass / (mass + 4 * inertia / radius**2)       # m/s^2",
        "  time: sqrt(2 * length / fall)          # until the load has fallen by the length",
        "simulation:",
        "  duration: time",
        "  tolerance: 1.0e-10",
        "  integrator: dop853",
        "  output_step: time / 100",
        "bodies:",
        "  drum: {mass: drum, shape: {cylinder: {radius: radius, length: 4 * radius, axis: y}}, position: [0, 0, 0]}",
        "  load: {mass: mass, shape: {box: [2*radius, 2*radius, 2*radius]}, position: [2*radius, 0, -length]}",
        "joints:",
        "  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: [0, 1, 0]}",
        "  guide: {type: prismatic, bodies: [ground, load], location: [2*radius, 0, -length], axis: [0, 0, 1]}",
        "  rope:",
        "    type: rope",
        "    normal: [0, -1, 0]",
        "    path:",
        "      - {drum: drum, radius: radius, bends: right}",
        "      - {sheave: load, radius: radius, bends: left}",
        "      - {point: ground, at: [3*radius, 0, 0]}",
        "markers:",
        "  hook: {body: load, location: {load: [0, 0, radius]}}",
        "expect:",
        "  falls: {joint: guide, quantity: displacement, at: end, value: -length, relative: 1.0e-9, source: m a = F}",
        "  turns: {joint: axle, quantity: angle, at: end, value: 2*length / radius, relative: 1.0e-9, source: no slip}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-9, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 2.0e-13, source: joints are closed}",
    )
