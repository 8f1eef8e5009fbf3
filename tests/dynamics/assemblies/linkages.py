"""Linkages whose numbers of assemblies are known, as scenes."""

from __future__ import annotations

import numpy as np

FOUR_BAR = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  crank: {mass: 0.4, inertia: [1e-3, 1e-3, 1e-3], position: [0.1, 0, 0]}
  coupler: {mass: 1.0, inertia: [2e-2, 2e-2, 2e-2], position: [0.4, 0, 0.2]}
  rocker: {mass: 0.8, inertia: [1e-2, 1e-2, 1e-2], position: [0.65, 0, 0.2]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, coupler], location: [0.2, 0, 0], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [coupler, rocker], location: [0.6, 0, 0.4], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [ground, rocker], location: [0.7, 0, 0], axis: [0, 1, 0]}
"""


#: Dietmaier, The Stewart-Gough platform of general geometry can have 40 real postures (Advances in Robot Kinematics
#: 1998): ends of the legs in the ground and in the platform, and the legs' lengths.
BASE = (
    (0.0, 0.0, 0.0),
    (1.107915, 0.0, 0.0),
    (0.549094, 0.756063, 0.0),
    (0.735077, -0.223935, 0.525991),
    (0.514188, -0.526063, -0.368418),
    (0.590473, 0.094733, -0.205018),
)
PLATFORM = (
    (0.0, 0.0, 0.0),
    (0.542805, 0.0, 0.0),
    (0.956919, -0.528915, 0.0),
    (0.665885, -0.353482, 1.402538),
    (0.478359, 1.158742, 0.107672),
    (-0.137087, -0.235121, 0.353913),
)
LEGS = (1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071)


def platform(base, ends, lengths, position, *joints):
    """A scene's text: a platform, its centre at `position`, on rods of these lengths from points of the ground to
    points of its own, from its centre; and other joints, as YAML."""
    rods = [
        f"L{k}: {{type: distance, bodies: [ground, platform], length: {length}, "
        f"locations: [{list(start)}, {[x + y for x, y in zip(end, position, strict=True)]}]}}"
        for k, (start, end, length) in enumerate(zip(base, ends, lengths, strict=True), 1)
    ]
    listed = "\n".join(f"  {each}" for each in [*rods, *joints])
    return f"""
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  platform: {{mass: 1, inertia: [1e-2, 1e-2, 1e-2], position: {list(position)}}}
joints:
{listed}
"""


#: A planar 3-RPR platform: 6 assemblies, by the signs of its sextic along a turn.
RPR_BASE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-0.68, -0.08, 0.0))
RPR_PLATFORM = ((0.0, 0.0, 0.0), (0.58, 0.0, 0.0), (0.15, -0.41, 0.0))
RPR_LEGS = (0.8, 1.45, 0.85)
IN_PLANE = "plane: {type: planar, bodies: [ground, platform], location: [0.3, 0.3, 0], axis: [0, 0, 1]}"

#: A Stephenson III six-bar: crank, coupler, rocker and ground of its four-bar, the coupler's point from its pin at the
#: crank, the tip of its input, and the link between. The input's circle meets the coupler curve 6 times.
BARS, POINT, TIP, LINK = (0.77, 0.86, 1.29, 1.12), (1.01, 0.77), (-0.9, 0.3), 1.49
PIVOT = (-0.9, -0.2)


def coupler_curve(theta, sign):
    """(pin at the crank, pin at the rocker, coupler point) at crank angles (n,), (n, 2) each; nan where it is open."""
    a, b, c, g = BARS
    pin = np.stack([a * np.cos(theta), a * np.sin(theta)], axis=-1)
    x, y = g - pin[..., 0], -pin[..., 1]
    r = np.hypot(x, y)
    with np.errstate(invalid="ignore"):
        turn = np.arctan2(y, x) + sign * np.arccos((r**2 + b**2 - c**2) / (2.0 * r * b))
    along = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    across = np.stack([-np.sin(turn), np.cos(turn)], axis=-1)
    return pin, pin + b * along, pin + POINT[0] * along + POINT[1] * across


def crank_angles():
    """(crank angle, sign) of each assembly of the six-bar, by bisection along the coupler curve."""

    def off(theta, sign):
        return np.hypot(*(coupler_curve(theta, sign)[2] - TIP).T) - LINK

    found, theta = [], np.linspace(0.0, 2.0 * np.pi, 4001)
    for sign in (1.0, -1.0):
        values = off(theta, sign)
        for k in np.flatnonzero(values[1:] * values[:-1] < 0.0):
            low, high = theta[k], theta[k + 1]
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if off(middle, sign) * off(low, sign) > 0.0 else (low, middle)
            found.append((0.5 * (low + high), sign))
    return found


def six_bar(motions=""):
    """Its scene's text at the first assembly, in the x-y plane."""
    theta, sign = crank_angles()[0]
    pin, other, point = (part.tolist() for part in coupler_curve(np.array(theta), sign))
    ends = {
        "crank": ([0.0, 0.0], pin),
        "coupler": (pin, other),
        "rocker": (other, [BARS[3], 0.0]),
        "link": (point, list(TIP)),
        "input": (list(PIVOT), list(TIP)),
    }
    pins = {
        "A": ("ground", "crank", [0.0, 0.0]),
        "B": ("crank", "coupler", pin),
        "C": ("coupler", "rocker", other),
        "D": ("ground", "rocker", [BARS[3], 0.0]),
        "E": ("coupler", "link", point),
        "G": ("link", "input", list(TIP)),
        "F": ("ground", "input", list(PIVOT)),
    }
    centres = {name: [0.5 * (x + y) for x, y in zip(*both, strict=True)] for name, both in ends.items()}
    bodies = "\n".join(
        f"  {name}: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: {[*centre, 0.0]}}}"
        for name, centre in centres.items()
    )
    joints = "\n".join(
        f"  {name}: {{type: revolute, bodies: [{first}, {second}], location: {[*place, 0.0]}, axis: [0, 0, 1]}}"
        for name, (first, second, place) in pins.items()
    )
    return f"\nmbproj: 1\ngravity: [0, -9.81, 0]\nbodies:\n{bodies}\njoints:\n{joints}\n{motions}"
