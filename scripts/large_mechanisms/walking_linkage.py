"""Jansen's walking linkage: legs on cranks, with the lengths that he published for his Strandbeests (Jansen, The Great
Pretender, 2007)."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
#: The lengths of a leg by their published names, in units of 1 cm.
A, B, C, D, E, F, G = 38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7
H, I, J, K, L, M = 65.7, 49.0, 50.0, 61.9, 7.8, 15.0
UNIT, SPACING = 0.01, 0.2
#: How far bodies are from their places and turned at the start, m and rad, and the seed.
OFF, TURNED, SEED = 0.01, 0.05, 12


def walking_linkage(pairs: int) -> tuple[list[str], list[str]]:
    """Bodies and joints of a scene, as lines: a frame that slides forward, and pairs of legs, each pair with its crank.
    Seven pairs have 92 bodies, 42 loops and 126 redundant rows. The bodies' places are wrong by a little."""
    rng, places = np.random.default_rng(SEED), {"frame": np.zeros(3)}
    joints = [_joint("slide", "prismatic", {"ground": np.zeros(3), "frame": np.zeros(3)}, "[1, 0, 0]")]
    for pair in range(pairs):
        angle, crank = 2.0 * math.pi * pair / pairs, f"crank{pair}"
        pin = M * np.array([math.cos(angle), math.sin(angle)])
        centres = {"frame": np.zeros(2), crank: pin / 2.0}
        hinges = [(f"O{pair}", "frame", crank, np.zeros(2))]
        for side, mirror in (("l", np.array([1.0, 1.0])), ("r", np.array([-1.0, 1.0]))):
            points = [point * mirror for point in _leg(pin * mirror)]
            of_leg, pins = _bodies_and_hinges(f"{side}{pair}", crank, pin, *points)
            centres |= of_leg
            hinges += pins
        for name, (x, z) in list(centres.items())[1:]:
            places[name] = np.array([UNIT * x, SPACING * pair, UNIT * z])
        joints += [_hinge(*hinge, places, SPACING * pair) for hinge in hinges]
    bodies = []
    for name, at in places.items():
        (x, z), turn = OFF * rng.normal(size=2), math.degrees(TURNED * rng.normal())
        place = ", ".join(f"{number:.15g}" for number in (at + np.array([x, 0.0, z])).tolist())
        turned = f"orientation: {{axis: [0, 1, 0], angle: {turn:.6g} deg}}" if name != "frame" else ""
        bodies.append(f"{name}: {{mass: 1.0, inertia: [0.01, 0.01, 0.01], position: [{place}], {turned}}}")
    return bodies, joints


def _leg(pin: Array) -> tuple[Array, ...]:
    """The points of a left leg, in its plane: the frame's pivot, four hinges, and the foot."""
    pivot = np.array([-A, -L])
    top = _apex(pin, pivot, J, B, -1.0)
    hip = _apex(top, pivot, E, D, -1.0)
    low = _apex(pin, pivot, K, C, 1.0)
    knee = _apex(hip, low, F, G, -1.0)
    return pivot, top, hip, low, knee, _apex(knee, low, H, I, -1.0)


def _apex(first: Array, second: Array, from_first: float, from_second: float, side: float) -> Array:
    """The point at these distances from two others; `side` is 1 on the left of the way from the first to the second."""
    base = float(np.linalg.norm(second - first))
    along = (second - first) / base
    part = (from_first**2 - from_second**2 + base**2) / (2.0 * base)
    height = side * math.sqrt(from_first**2 - part**2)
    return np.asarray(first + part * along + height * np.array([-along[1], along[0]]))


def _bodies_and_hinges(
    leg: str, crank: str, pin: Array, pivot: Array, top: Array, hip: Array, low: Array, knee: Array, foot: Array
) -> tuple[dict[str, Array], list[tuple[str, str, str, Array]]]:
    """The six bodies of a leg with their centres, and its nine hinges: name, bodies and place."""
    names = [f"{part}_{leg}" for part in ("upper", "rod", "rocker", "thigh", "bar", "shin")]
    upper, rod, rocker, thigh, bar, shin = names
    corners = [(pin, top), (pin, low), (pivot, low), (pivot, top, hip), (hip, knee), (low, knee, foot)]
    hinges = [
        (crank, upper, pin),
        (upper, thigh, top),
        ("frame", thigh, pivot),
        (crank, rod, pin),
        (rod, shin, low),
        ("frame", rocker, pivot),
        (rocker, shin, low),
        (thigh, bar, hip),
        (bar, shin, knee),
    ]
    centres = {name: np.mean(points, axis=0) for name, points in zip(names, corners, strict=True)}
    return centres, [(f"{leg}_{number}", *hinge) for number, hinge in enumerate(hinges)]


def _hinge(name: str, first: str, second: str, at: Array, places: dict[str, Array], depth: float) -> str:
    point = np.array([UNIT * at[0], depth, UNIT * at[1]])
    return _joint(name, "revolute", {body: point - places[body] for body in (first, second)}, "[0, 1, 0]")


def _joint(name: str, kind: str, ends: dict[str, Array], axis: str) -> str:
    """A joint at points and along an axis of the bodies, which may stand anywhere."""
    location = ", ".join(f"{body}: [{', '.join(f'{x:.15g}' for x in at.tolist())}]" for body, at in ends.items())
    axes = ", ".join(f"{body}: {axis}" for body in ends)
    return f"{name}: {{type: {kind}, bodies: [{', '.join(ends)}], location: {{{location}}}, axis: {{{axes}}}}}"
