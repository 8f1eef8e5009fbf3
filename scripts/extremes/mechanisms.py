"""The smallest mechanisms that show an extreme, as scene files with parameters, and their exact motions.

All but the top swing as one pendulum, I φ'' = -K sin φ, by Jacobi's functions (Whittaker, Analytical Dynamics, § 44).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import ellipj, ellipk

from mbproj.base.arrays import Array

#: A bar on a pin, and a wheel on an axle at its end, which the bar does not turn.
WHEEL = """
mbproj: 1
gravity: [0, 0, -g]
parameters:
  {length: 1 m, g: 9.81, bar: 1 kg, wheel: 1 kg, moment: 0.01 * wheel * length**2, start: 60 deg, spin: 0 rad/s,
   tilt: 0, offset: 0 m, x: length * sin(start), z: -length * cos(start)}
simulation: {duration: 1, step: 10 ms}
bodies:
  bar:
    mass: bar
    inertia: [bar*length**2 / 1200, bar*length**2 / 12, bar*length**2 / 12]
    position: [x/2, 0, z/2]
    orientation: {axis: [0, 1, 0], angle: 90 deg - start}
  wheel: {mass: wheel, inertia: [moment/2, moment, moment/2], position: [x, 0, z]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0], speed: 0 rad/s}
  axle: {type: revolute, bodies: [bar, wheel], location: [x, 0, z], axis: [0, 1, 0], speed: spin}
"""

#: The same on a second pin in line with the first, or beside it by `offset`, or askew by the angle `tilt`.
TWO_PINS = (
    WHEEL
    + """\
  second: {type: revolute, bodies: [ground, bar], location: [offset, length/5, 0], axis: [0, cos(tilt), sin(tilt)]}
"""
)

#: Two bars of one length hang on the ground, and a coupler between their ends, which never turns: a loop.
PARALLELOGRAM = """
mbproj: 1
gravity: [0, 0, -g]
parameters:
  {length: 1 m, g: 9.81, left: 1 kg, coupler: 1 kg, right: 1 kg, reach: 2 * length, start: 60 deg,
   x: length * sin(start), z: -length * cos(start)}
simulation: {duration: 1, step: 10 ms}
bodies:
  left:
    mass: left
    inertia: [left*length**2 / 1200, left*length**2 / 12, left*length**2 / 12]
    position: [x/2, 0, z/2]
    orientation: {axis: [0, 1, 0], angle: 90 deg - start}
  coupler:
    mass: coupler
    inertia: [coupler*reach**2 / 1200, coupler*reach**2 / 12, coupler*reach**2 / 12]
    position: [x + reach/2, 0, z]
  right:
    mass: right
    inertia: [right*length**2 / 1200, right*length**2 / 12, right*length**2 / 12]
    position: [x/2 + reach, 0, z/2]
    orientation: {axis: [0, 1, 0], angle: 90 deg - start}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0], speed: 0 rad/s}
  B: {type: spherical, bodies: [left, coupler], location: [x, 0, z]}
  C: {type: universal, bodies: [coupler, right], location: [x + reach, 0, z], axes: [[0, 0, 1], [0, 1, 0]]}
  D: {type: revolute, bodies: [ground, right], location: [reach, 0, 0], axis: [0, 1, 0]}
"""

#: A symmetric top on a ball below its centre of mass, without gravity.
TOP = """
mbproj: 1
gravity: [0, 0, 0]
parameters: {spin: 1 rad/s, height: 0.1 m, mass: 1 kg, across: 0.02, along: 0.01}
simulation: {duration: 1, step: 10 ms}
bodies:
  top: {mass: mass, inertia: [across, across, along], position: [0, 0, height],
        velocity: [0, -0.3*spin*height, 0], angular_velocity: [0.3*spin, 0, spin]}
joints:
  ball: {type: spherical, bodies: [ground, top], location: [0, 0, 0]}
"""


def chain(links: int, heavy: float) -> str:
    """A straight chain of bars of 1 g, together 1 m long, that turns about its end at 1 rad/s without gravity; its last
    body has the mass `heavy`, in kg."""
    length = 1.0 / links
    bodies, joints = [], []
    for number in range(links):
        mass = heavy if number == links - 1 else 1e-3
        at, moment = (number + 0.5) * length, mass * length**2 / 12
        bodies.append(
            f"  b{number}: {{mass: {mass!r}, inertia: [{moment / 100!r}, {moment!r}, {moment!r}], "
            f"position: [{at!r}, 0, 0], velocity: [0, {at!r}, 0], angular_velocity: [0, 0, 1]}}"
        )
        below = f"b{number - 1}" if number else "ground"
        joints.append(
            f"  J{number}: {{type: revolute, bodies: [{below}, b{number}], location: [{number * length!r}, 0, 0], "
            "axis: [0, 0, 1]}"
        )
    head = "mbproj: 1\ngravity: [0, 0, 0]\nsimulation: {duration: 1, step: 10 ms}\nbodies:\n"
    return head + "\n".join([*bodies, "joints:", *joints, ""])


def pendulum(scene: Mapping[str, float]) -> tuple[float, float]:
    """I (kg m²) and K (N m) of the wheel's bar or of the parallelogram, from its parameters."""
    L = scene["length"]
    bars, carried = (
        (scene["bar"], scene["wheel"]) if "bar" in scene else (scene["left"] + scene["right"], scene["coupler"])
    )
    return (bars / 3 + carried) * L**2, (bars / 2 + carried) * L * scene["g"]


def swinging(amplitude: float, frequency: float, t: Array) -> Array:
    """φ (T,) of a pendulum from rest at this amplitude; `frequency` is that of small swings."""
    k = np.sin(amplitude / 2)
    sn = ellipj(ellipk(k * k) + frequency * t, k * k)[0]
    return np.asarray(2.0 * np.arcsin(k * sn))


def axis_of_top(scene: Mapping[str, float], t: Array) -> Array:
    """The top's axis (T, 3), which goes round its angular momentum at |L| / I about the ball."""
    across = scene["across"] + scene["mass"] * scene["height"] ** 2
    L = np.array([0.3 * across, 0.0, scene["along"]]) * scene["spin"]
    size = float(np.linalg.norm(L))
    n, axis, angle = L / size, np.array([0.0, 0.0, 1.0]), (size / across * t)[:, None]
    along = (n @ axis) * n
    return np.asarray(along + np.cos(angle) * (axis - along) + np.sin(angle) * np.cross(n, axis))
