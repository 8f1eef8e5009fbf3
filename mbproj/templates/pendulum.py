"""A bar on a pin: the first mechanism, with its period in closed form."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from mbproj.errors import InputError
from mbproj.templates.values import Values, refused

DEFAULTS = {"length": "1 m", "mass": "1 kg", "angle": "60 deg"}
#: Steps of the arithmetic-geometric mean: each doubles the number of correct digits.
MEANS = 7


def pendulum(values: Values) -> Iterator[str]:
    """Yield the lines of a pendulum over two periods. Raises InputError for an angle that gives no swing."""
    if not 0.0 < abs(values.number["angle"]) < pi:
        raise InputError(refused("angle", "must be between 0 and 180 deg", "it is counted from hanging straight down"))
    yield from (
        "# A uniform bar on a pin, released from rest. Its period has a closed form with the arithmetic-geometric",
        "# mean M of two numbers: 2π / (rate M(1, cos(angle/2))). Look at the joint's angle, and at the expectations.",
        "mbproj: 1",
        "title: Pendulum",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("length", "mass", "angle"),
        "  radius: length / 50                    # of the bar",
        "  moment: mass * (radius**2 / 4 + length**2 / 3)          # about the pin",
        "  rate: sqrt(mass * g * length / (2 * moment))            # rad/s, of small swings",
        "  a0: 1                                  # arithmetic and geometric means",
        "  b0: cos(angle / 2)",
        *(
            line
            for k in range(1, MEANS)
            for line in (f"  a{k}: (a{k - 1} + b{k - 1}) / 2", f"  b{k}: sqrt(a{k - 1} * b{k - 1})")
        ),
        f"  period: 2 * pi / (rate * a{MEANS - 1})",
        "simulation:",
        "  duration: 2 * period",
        "  step: period / 1000",
        "  integrator: dop853",
        "  output_step: period / 200",
        "bodies:",
        "  bar:                                   # its axis is its body x, which points away from the pin",
        "    mass: mass",
        "    shape: {cylinder: {radius: radius, length: length, axis: x}}",
        "    position: [length/2 * sin(angle), 0, -length/2 * cos(angle)]",
        "    orientation: {axis: [0, 1, 0], angle: 90 deg - angle}",
        "joints:",
        "  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}",
        "markers:",
        "  end: {body: bar, location: {bar: [length/2, 0, 0]}}",
        "expect:",
        "  hangs: {joint: pin, quantity: angle, at: period/4, value: angle, absolute: 1.0e-7, source: exact period}",
        "  fastest: {joint: pin, quantity: angle_speed, at: period/4, relative: 1.0e-6,",
        "            value: 2 * rate * sin(angle/2), source: energy}",
        "  pull: {joint: pin, quantity: reaction_force, component: norm, at: period/4, relative: 1.0e-6,",
        "         value: mass * (g + length/2 * (2 * rate * sin(angle/2))**2), source: weight and centripetal force}",
        "  returns: {joint: pin, quantity: angle, at: period, value: 0, absolute: 1.0e-7, source: exact period}",
        *closed_and_kept("1.0e-8", "mass * g * length", values.number["length"]),
    )


def closed_and_kept(drift: str, energy: str = "", size: float = 1.0) -> Iterator[str]:
    """Yield the expectations that scenes share: joints closed to the round-off of coordinates of `size` in m, and
    energy kept. Its drift is below `drift` times `energy`, an expression in J; where that is "", times the energy that
    the run exchanges."""
    bound = f"{max(1e-12, 2e-15 * size):.1e}"
    yield f"  closed: {{diagnostic: position_violation, at: maximum, below: {bound}, source: joints are closed}}"
    diagnostic, below = ("energy_drift", f"{drift} * {energy}") if energy else ("energy_drift_relative", drift)
    yield f"  energy: {{diagnostic: {diagnostic}, at: maximum, below: {below}, source: balance of energy}}"
