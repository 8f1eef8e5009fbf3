"""A drum whose load falls: a row couples the two coordinates; the fall and the force in the rope have closed forms."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.templates.values import Values

DEFAULTS = {"radius": "10 cm", "mass": "50 kg", "length": "2 m"}


def winch(values: Values) -> Iterator[str]:
    """Yield the lines of a winch whose load falls by the option `length`."""
    yield from (
        "# A load hangs on the drum of a winch whose brake has failed. A coupling says that the load rises by what the",
        "# drum winds up. So both fall as one mass, m + J / r². Change the row to see other couplings:",
        "# `mbproj help couple_joints`.",
        "mbproj: 1",
        "title: Winch",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("radius", "mass", "length"),
        "  drum: 0.4 * mass                       # a solid cylinder",
        "  inertia: drum * radius**2 / 2          # of the drum about its axle",
        "  fall: g * mass / (mass + inertia / radius**2)           # m/s^2",
        "  time: sqrt(2 * length / fall)          # until the load has fallen by the length",
        "simulation:",
        "  duration: time",
        "  tolerance: 1.0e-10",
        "  integrator: dop853",
        "  output_step: time / 100",
        "bodies:",
        "  drum: {mass: drum, shape: {cylinder: {radius: radius, length: 4 * radius, axis: y}}, position: [0, 0, 0]}",
        "  load: {mass: mass, shape: {box: [2*radius, 2*radius, 2*radius]}, position: [radius, 0, -length/2]}",
        "joints:",
        "  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: [0, 1, 0]}",
        "  guide: {type: prismatic, bodies: [ground, load], location: [radius, 0, -length/2], axis: [0, 0, 1]}",
        "  rope: {type: coupler, of: {axle.angle: radius, guide.displacement: 1}}",
        "markers:",
        "  hook: {body: load, location: {load: [0, 0, radius]}}",
        "expect:",
        "  falls: {joint: guide, quantity: displacement, at: end, value: -length, relative: 1.0e-9, source: m a = F}",
        "  turns: {joint: axle, quantity: angle, at: end, value: length / radius, relative: 1.0e-9, source: no slip}",
        "  pull: {joint: rope, quantity: reaction_force, component: z, at: end, relative: 1.0e-8,",
        "         value: mass * (g - fall), source: what is left of the weight}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-9, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-13, source: joints are closed}",
    )
