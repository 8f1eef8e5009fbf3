"""A cam, its roller follower and a spring, designed for a lift law, a speed and a mass."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.templates.values import Values

DEFAULTS = {"radius": "40 mm", "mass": "0.5 kg", "speed": "30 rad/s"}


def cam(values: Values) -> Iterator[str]:
    """Yield the lines of a disc cam whose follower may lift off, with a spring that is just strong enough."""
    yield from (
        "# A disc cam lifts a roller follower against a spring: up over 120 deg, a dwell of 60 deg, down, and a dwell.",
        "# The contact may open: with --set reserve=0.3 the spring is too weak: the follower flies. See the profile by",
        "# `mbproj curve`. More of it: `mbproj help follow_a_curve`.",
        "mbproj: 1",
        "title: Cam",
        "gravity: [0, 0, -9.81 m/s^2]",
        "parameters:",
        *values.parameters("radius", "mass", "speed"),
        "  roller: 0.3 * radius",
        "  lift: 0.5 * radius",
        "  sharpest: 2*pi * lift * (speed / (2*pi/3))**2   # m/s^2, the largest acceleration of a cycloidal rise",
        "  reserve: 1.3                           # of the spring",
        "  stiffness: reserve * mass * (sharpest + 1 m/s^2) / (2*lift)",
        "  down: radius + roller                  # where the follower is at the lowest",
        "simulation:",
        "  duration: (1 + 150/360) * 2*pi / speed # a turn, and to the middle of the dwell",
        "  tolerance: 1.0e-10",
        "  integrator: dop853",
        "  output_step: (1 + 150/360) * 2*pi / speed / 204",
        "curves:",
        "  law:",
        "    lift:",
        "      base: radius",
        "      rises: [[120 deg, lift, cycloidal], [60 deg, lift, dwell],",
        "              [120 deg, 0 m, cycloidal], [60 deg, 0 m, dwell]]",
        "    roller: roller",
        "    clockwise: true                      # the cam turns counterclockwise: this is the order of the law",
        "bodies:",
        "  shaft: {mass: 2 * mass, shape: {cylinder: {radius: radius, length: roller, axis: y}}, position: [0, 0, 0]}",
        "  follower: {mass: mass, shape: {sphere: roller}, position: [0, 0, down]}",
        "joints:",
        "  axle: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, -1, 0]}",
        "  guide: {type: prismatic, bodies: [ground, follower], location: [0, 0, down], axis: [0, 0, 1]}",
        "  contact: {type: cam_contact, bodies: [shaft, follower], curve: law, axis: [0, -1, 0], x_axis: [0, 0, 1],",
        "            locations: [[0, 0, 0], [0, 0, down]],",
        "            limits: {gap: {range: [0, null], rigid: true, restitution: 0}}}",
        "forces:",
        "  spring: {type: spring_damper, points: {ground: [0, 0, 6*radius], follower: [0, 0, down]},",
        "           stiffness: stiffness, free_length: 6*radius - down + 2*lift}",
        "motions:",
        "  motor: {joint: axle, angle: {constant_speed: speed}}",
        "markers:",
        "  centre: {body: follower, location: {follower: [0, 0, 0]}}",
        "expect:",
        "  up: {joint: guide, quantity: displacement, at: end, value: lift, relative: 1.0e-8, source: the lift law}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-8, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-13, source: joints are closed}",
    )
