"""Overconstrained and singular mechanisms of the literature, as scenes of chosen size and mass."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from mbproj import Scene
from mbproj.scene.records import Body, Joint, Pair
from tests.support import scene_of

GROUND = "ground"


def body(name: str, position: Sequence[float], mass: float = 1.0, inertia: Sequence[float] = (0.01,) * 3) -> Body:
    rows = tuple(tuple(float(x) for x in row) for row in np.diag(inertia))
    return Body(name, mass, rows, tuple(float(x) for x in position))


def joint(
    name: str, kind: str, bodies: tuple[str, str], at: Sequence[float], axis: Sequence[float] | None = None
) -> Joint:
    point = tuple(float(x) for x in at)
    along = None if axis is None else tuple(float(x) for x in axis)
    return Joint(name, kind, bodies, Pair(point, point), None if along is None else Pair(along, along))


def closed_chain(points: np.ndarray, axes: np.ndarray, kind: str = "revolute") -> Scene:
    """A loop of bodies from the ground and back: a joint at each point (k, 3) with its axis (k, 3), A, B, C, ..."""
    count = len(points)
    bodies = [body(f"link{number}", (points[number - 1] + points[number]) / 2) for number in range(1, count)]
    names = [GROUND, *(entry.name for entry in bodies), GROUND]
    joints = [
        joint("ABCDEFGH"[number], kind, (names[number], names[number + 1]), points[number], axes[number])
        for number in range(count)
    ]
    return scene_of(bodies, joints)


def scaled(scene: Scene, length: float, mass: float) -> Scene:
    """The scene in other units of length and mass."""

    def longer(vector):
        return tuple(length * x for x in vector)

    bodies = [
        dataclasses.replace(
            entry,
            mass=mass * entry.mass,
            inertia=tuple(tuple(mass * length**2 * x for x in row) for row in entry.inertia),
            position=longer(entry.position),
        )
        for entry in scene.bodies
    ]
    joints = [
        dataclasses.replace(entry, points=Pair(longer(entry.points.first), longer(entry.points.second)))
        for entry in scene.joints
    ]
    return dataclasses.replace(scene, bodies=tuple(bodies), joints=tuple(joints))


def four_bar() -> Scene:
    """Revolutes about y in the x-z plane, no right angles."""
    points = np.array([[0.0, 0, 0], [0.1, 0, 0.3], [0.7, 0, 0.5], [0.6, 0, -0.1]])
    return closed_chain(points, np.tile([0.0, 1, 0], (4, 1)))


def bennett(turn: float = 0.7) -> Scene:
    """Bennett (1903): opposite links alike, a / sin α = b / sin β; it moves with one freedom though 6 (n - g - 1) + Σf
    = -2. Denavit and Hartenberg's frames, each joint's axis the z of its own."""
    a, alpha = 1.0, 0.6
    b = 0.7
    beta = np.arcsin(b * np.sin(alpha) / a)
    # tan(θ1/2) tan(θ2/2) = sin((β + α)/2) / sin((β - α)/2); opposite angles are 2π - θ.
    other = 2.0 * np.arctan(np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2) / np.tan(turn / 2))
    frame, points, axes = np.eye(4), [], []
    for link, twist, angle in ((a, alpha, turn), (b, beta, other), (a, alpha, -turn), (b, beta, -other)):
        points.append(frame[:3, 3])
        axes.append(frame[:3, 2])
        frame = frame @ _step(angle, link, twist)
    assert np.allclose(frame, np.eye(4), atol=1e-12)
    return closed_chain(np.array(points), np.array(axes))


def _step(angle: float, link: float, twist: float) -> np.ndarray:
    c, s, C, S = np.cos(angle), np.sin(angle), np.cos(twist), np.sin(twist)
    return np.array([[c, -s * C, s * S, link * c], [s, c * C, -c * S, link * s], [0, S, C, 0], [0, 0, 0, 1.0]])


def bricard() -> Scene:
    """Bricard's trihedral case with links of unit length and right angles, six revolutes on edges of a cube."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1], [0, 0, 1]])
    axes = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]])
    return closed_chain(points, axes)


def parallelogram(cranks: int, angle: float = 1.0, kinds: Sequence[str] = ("revolute", "revolute")) -> Scene:
    """A coupler along x on parallel cranks of 0.3 m at this angle from x; joints A0, B0, A1, B1, ..."""
    arm = 0.3 * np.array([np.cos(angle), 0.0, np.sin(angle)])
    feet = [np.array([0.5 * number, 0.0, 0.0]) for number in range(cranks)]
    bodies = [body(f"crank{number}", foot + arm / 2) for number, foot in enumerate(feet)]
    bodies.append(body("coupler", np.mean(feet, axis=0) + arm))
    joints = []
    for number, foot in enumerate(feet):
        axis = {kind: (0.0, 1.0, 0.0) if kind == "revolute" else None for kind in kinds}
        joints.append(joint(f"A{number}", kinds[0], (GROUND, f"crank{number}"), foot, axis[kinds[0]]))
        joints.append(joint(f"B{number}", kinds[1], (f"crank{number}", "coupler"), foot + arm, axis[kinds[1]]))
    return scene_of(bodies, joints)


def slider_crank(rod: float, angle: float) -> Scene:
    """Crank of 0.2 m at this angle from x, revolutes about y and a prismatic joint along x: the slider is at
    0.2 cos + sqrt(rod² - (0.2 sin)²)."""
    pin = 0.2 * np.array([np.cos(angle), 0.0, np.sin(angle)])
    slide = np.array([pin[0] + np.sqrt(max(rod**2 - pin[2] ** 2, 0.0)), 0.0, 0.0])
    bodies = [body("crank", pin / 2), body("rod", (pin + slide) / 2), body("slider", slide)]
    across = (0.0, 1.0, 0.0)
    return scene_of(
        bodies,
        [
            joint("A", "revolute", (GROUND, "crank"), (0, 0, 0), across),
            joint("B", "revolute", ("crank", "rod"), pin, across),
            joint("C", "revolute", ("rod", "slider"), slide, across),
            joint("D", "prismatic", (GROUND, "slider"), slide, (1, 0, 0)),
        ],
    )


def door() -> Scene:
    """Two hinges on one vertical axis: five rows too many."""
    heights = {"low": 0.2, "high": 1.8}
    hinges = [joint(name, "revolute", (GROUND, "door"), (0, 0, z), (0, 0, 1)) for name, z in heights.items()]
    return scene_of([body("door", (0.5, 0.0, 1.0), 20.0, (6.0, 7.0, 2.0))], hinges)
