"""Bars on the rim of a hub that turns, as on a carousel."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.templates.bars import SIMULATION
from mbproj.templates.pendulum import closed_and_kept
from mbproj.templates.values import Values

DEFAULTS = {"links": "6", "length": "1 m", "mass": "1 kg", "speed": "3 rad/s"}


def star(values: Values) -> Iterator[str]:
    """Yield the lines of a hub with as many bars as the option `links` says."""
    links = values.count("links")
    yield from (
        "# A hub turns about the vertical; bars hang from its rim, each on a pin along the rim, and swing outwards.",
        "# All of them do the same, and the hub turns slower while they are out. Look at its speed.",
        "mbproj: 1",
        f"title: Star of {links}",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("length", "mass", "speed"),
        "  radius: length / 50                    # of the bars",
        "  rim: length                            # radius of the hub",
        f"  hub_mass: {links} * mass",
        f"  apart: 360 deg / {links}",
        "  energy: hub_mass * (g * length + (speed * rim)**2)      # J, of the size of what the run exchanges",
        *SIMULATION,
        "bodies:                                  # a bar's axis is its body z",
        "  hub: {mass: hub_mass, shape: {cylinder: {radius: rim, length: rim/10, axis: z}}, position: [0, 0, 0]}",
    )
    for k in range(links):
        yield f"  bar{k + 1}:"
        yield "    mass: mass"
        yield "    shape: {cylinder: {radius: radius, length: length, axis: z}}"
        yield f"    position: [rim * cos({k} * apart), rim * sin({k} * apart), -length/2]"
    yield "joints:"
    yield "  shaft: {type: revolute, bodies: [ground, hub], location: [0, 0, 0], axis: [0, 0, 1], speed: speed}"
    for k in range(links):
        yield f"  pin{k + 1}: {{type: revolute, bodies: [hub, bar{k + 1}], speed: 0,"
        yield f"    location: [rim * cos({k} * apart), rim * sin({k} * apart), 0],"
        yield f"    axis: [-sin({k} * apart), cos({k} * apart), 0]}}"
    yield from (
        "markers:",
        "  end: {body: bar1, location: {bar1: [0, 0, -length/2]}}",
        "expect:",
        "  never_faster: {joint: shaft, quantity: angle_speed, at: maximum,",
        "                 below: speed * (1 + 1e-9) + 1e-9 * sqrt(g / length),",
        "                 source: constant angular momentum; the moment of inertia is smallest at the start}",
        *closed_and_kept("1.0e-6", "energy", 2 * values.number["length"]),
    )
