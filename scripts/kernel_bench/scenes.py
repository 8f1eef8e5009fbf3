"""Scenes of any size: chains, trees, stars, ladders and wheels of loops, which hang at rest but for a kick.

Bars are those of the paper's five-bar: 1 m, 1 kg. Every body starts with its axes along the global ones and every joint
is closed, in its velocities too, so that no assembly is needed. In a plane all axes are y; in space those of chains and
trees alternate between x and y, and loops are closed as in mechanisms/planar_four_bar.yaml, by revolute, spherical,
universal and revolute joint: 17 independent rows, 1 freedom.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from peers.problem import ACROSS, ALONG, GRAVITY, LENGTH, MASS, Array

from mbproj.base.settings import Settings
from mbproj.scene.records import GROUND, Body, Joint, Matrix, Pair, Vector
from mbproj.scene.scene import Scene

#: Standard deviation of the kick, rad/s for each bar; its generator's seed.
KICK, SEED = 1.0, 5
ACROSS_X, ACROSS_Y, DOWN = np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([0, 0, -LENGTH])
#: Inertia of bars along x and along z, kg m².
ALONG_X, ALONG_Z = (ALONG, ACROSS, ACROSS), (ACROSS, ACROSS, ALONG)
#: Radius of a star's hub, m.
RADIUS = 1.0


def chain(links: int, planar: bool) -> Scene:
    """Links in a row, the first on the ground."""
    return _tree([number - 1 for number in range(links)], planar)


def tree(bodies: int, planar: bool) -> Scene:
    """A binary tree: two bars hang on the end of each."""
    return _tree([(number - 1) // 2 for number in range(bodies)], planar)


def star(spokes: int, planar: bool) -> Scene:
    """Bars on the rim of a hub, which turns about its centre: upright in a plane, lying on a ball joint in space."""
    rng = np.random.default_rng(SEED)
    hub = _bar("hub", np.zeros(3), (ACROSS, ACROSS, ACROSS))
    bodies, joints = [hub], [_joint("H", "revolute" if planar else "spherical", (GROUND, "hub"), np.zeros(3), ACROSS_Y)]
    for number, angle in enumerate(2.0 * np.pi * np.arange(spokes) / spokes):
        cosine, sine = np.cos(angle), np.sin(angle)
        at = RADIUS * (np.array([cosine, 0.0, sine]) if planar else np.array([cosine, sine, 0.0]))
        axis = ACROSS_Y if planar else np.array([-sine, cosine, 0.0])
        omega = KICK * rng.normal() * axis
        bodies.append(_bar(f"b{number}", at + DOWN / 2, ALONG_Z, np.cross(omega, DOWN / 2), omega))
        joints.append(_joint(f"j{number}", "revolute", ("hub", f"b{number}"), at, axis))
    return _scene(bodies, joints)


def ladder(loops: int, planar: bool) -> Scene:
    """Loops one below the other: two rails and a rung, which is the frame of the next loop."""
    bodies, joints, speed = [], [], np.zeros(3)
    for number, rate in enumerate(KICK * np.random.default_rng(SEED).normal(size=loops)):
        frame = f"rung{number - 1}" if number else GROUND
        loop = _four_bar(number, frame, number * DOWN, speed, rate, planar)
        bodies += loop[0]
        joints += loop[1]
        speed = np.array(loop[0][-1].velocity)
    return _scene(bodies, joints)


def wheel(loops: int, planar: bool) -> Scene:
    """Loops side by side on one shaft, which turns about its axis: twice as many joints on a body as loops."""
    bodies = [_bar("hub", np.zeros(3), (ACROSS, ACROSS, ACROSS))]
    joints = [_joint("H", "revolute", (GROUND, "hub"), np.zeros(3), ACROSS_Y)]
    for number, rate in enumerate(KICK * np.random.default_rng(SEED).normal(size=loops)):
        loop = _four_bar(number, "hub", number * ACROSS_Y, np.zeros(3), rate, planar)
        bodies += loop[0]
        joints += loop[1]
    return _scene(bodies, joints)


def _tree(parents: Iterable[int], planar: bool) -> Scene:
    """Bars that hang on the ends of their parents (-1: the ground)."""
    rng = np.random.default_rng(SEED)
    bodies, joints = [], []
    depths: list[int] = []
    ends: list[tuple[Array, Array, Array]] = []  # of each bar: where its end is, how fast, and how fast the bar turns
    for number, parent in enumerate(parents):
        depths.append(depths[parent] + 1 if parent >= 0 else 0)
        at, speed, omega = ends[parent] if parent >= 0 else (np.zeros(3), np.zeros(3), np.zeros(3))
        axis = ACROSS_Y if planar or depths[-1] % 2 == 0 else ACROSS_X
        turning = omega + (KICK * rng.normal() - omega @ axis) * axis  # does not add up along the chain
        arm = np.cross(turning, DOWN)
        ends.append((at + DOWN, speed + arm, turning))
        bodies.append(_bar(f"b{number}", at + DOWN / 2, ALONG_Z, speed + arm / 2, turning))
        joints.append(
            _joint(f"j{number}", "revolute", (f"b{parent}" if parent >= 0 else GROUND, f"b{number}"), at, axis)
        )
    return _scene(bodies, joints)


def _four_bar(
    number: int, frame: str, at: Array, speed: Array, rate: float, planar: bool
) -> tuple[list[Body], list[Joint]]:
    """Two rails that hang on a frame at ± half a length from `at`, and the rung between their ends; the rails turn at
    `rate` while the frame moves with `speed` without turning, and so does the rung."""
    left, right, rung = f"left{number}", f"right{number}", f"rung{number}"
    omega, half = rate * ACROSS_Y, LENGTH / 2 * ACROSS_X
    arm = np.cross(omega, DOWN)
    bodies = [
        _bar(left, at - half + DOWN / 2, ALONG_Z, speed + arm / 2, omega),
        _bar(right, at + half + DOWN / 2, ALONG_Z, speed + arm / 2, omega),
        _bar(rung, at + DOWN, ALONG_X, speed + arm),
    ]
    pins = [
        _joint(f"A{number}", "revolute", (frame, left), at - half, ACROSS_Y),
        _joint(f"D{number}", "revolute", (frame, right), at + half, ACROSS_Y),
    ]
    if planar:
        pins.append(_joint(f"B{number}", "revolute", (left, rung), at - half + DOWN, ACROSS_Y))
        pins.append(_joint(f"C{number}", "revolute", (rung, right), at + half + DOWN, ACROSS_Y))
    else:
        pins.append(_joint(f"B{number}", "spherical", (left, rung), at - half + DOWN))
        pins.append(_joint(f"C{number}", "universal", (rung, right), at + half + DOWN, DOWN, ACROSS_Y))
    return bodies, pins


def _bar(
    name: str, position: Array, inertia: Vector, velocity: Array | None = None, omega: Array | None = None
) -> Body:
    x, y, z = inertia
    tensor: Matrix = ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
    still = np.zeros(3)
    return Body(
        name,
        MASS,
        tensor,
        _vector(position),
        velocity=_vector(still if velocity is None else velocity),
        angular_velocity=_vector(still if omega is None else omega),
    )


def _joint(
    name: str, kind: str, bodies: tuple[str, str], at: Array, first: Array | None = None, second: Array | None = None
) -> Joint:
    point = _vector(at)
    if first is None or kind == "spherical":
        return Joint(name, kind, bodies, Pair(point, point))
    axes = Pair(_vector(first), _vector(first if second is None else second))
    return Joint(name, kind, bodies, Pair(point, point), axes)


def _vector(array: Array) -> Vector:
    x, y, z = array.tolist()
    return x, y, z


def _scene(bodies: list[Body], joints: list[Joint]) -> Scene:
    return Scene(
        title="",
        gravity=(0.0, 0.0, -GRAVITY),
        bodies=tuple(bodies),
        joints=tuple(joints),
        markers=(),
        parameters={},
        settings=Settings(),
        text="",
        path=None,
        overrides={},
        places={},
    )
