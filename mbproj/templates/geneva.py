"""A Geneva drive that turns freely: its energy is constant, which gives the speed of the driver in closed form."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.templates.values import Values

DEFAULTS = {"slots": "4", "length": "100 mm", "mass": "1 kg", "speed": "10 rad/s"}


def geneva(values: Values) -> Iterator[str]:
    """Yield the lines of a driver and a slotted wheel; the run takes two turns and ends in the middle of a slot."""
    yield from (
        "# A Geneva drive: in each of its turns the pin of the driver turns the wheel by one slot, and then its disc",
        "# holds the wheel. Nothing drives it: the driver slows down while the wheel turns, and gets all of it back.",
        "# Look at the speeds of the joints. Other couplings: `mbproj help couple_joints`.",
        "mbproj: 1",
        "title: Geneva drive",
        "gravity: [0, 0, 0]",
        "parameters:",
        *values.parameters("slots", "length", "mass", "speed"),
        "  k: sin(pi / slots)                     # crank over distance: the pin enters its slot along it",
        "  J1: mass * length**2 / 5               # of the driver about its axle",
        "  J2: mass * length**2 / 20              # of the wheel",
        "simulation:",
        "  duration: 2 * 2*pi / speed",
        "  tolerance: 1.0e-12",
        "  integrator: dop853",
        "  output_step: 2*pi / speed / 100",
        "bodies:",
        "  driver: {mass: mass, inertia: [J1, J1, J1], position: [0, 0, 0]}",
        "  wheel: {mass: mass, inertia: [J2, J2, J2], position: [length, 0, 0]}",
        "joints:",
        "  input: {type: revolute, bodies: [ground, driver], location: [0, 0, 0], axis: [0, -1, 0],",
        "          angle: -180 deg, speed: speed}",
        "  output: {type: revolute, bodies: [ground, wheel], location: [length, 0, 0], axis: [0, -1, 0],",
        "           angle: pi / slots}",
        "  drive: {type: geneva, joints: [input, output], slots: slots}",
        "markers:",
        "  pin: {body: driver, location: {driver: [k * length, 0, 0]}}",
        "  rim: {body: wheel, location: {wheel: [-0.9 * length * sqrt(1 - k**2), 0, 0]}}",
        "expect:",
        "  slows: {joint: input, quantity: angle_speed, at: minimum, relative: 1.0e-3,",
        "          value: speed / sqrt(1 + J2/J1 * (k / (1 - k))**2), source: energy in the middle of a slot}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-11, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-11, source: joints are closed}",
    )
