"""A planar four-bar with a choice of joints."""

from __future__ import annotations

from mbproj.scene.records import Body, Joint, Pair
from tests.support import scene_of

ROUND = ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01))


def parallelogram(kinds: str = "rrrr", scale: float = 1.0, mass: float = 1.0):
    """A planar four-bar of 1 m by 0.5 m in the x-z plane; letters r, u, s choose its joints."""
    names = {"r": "revolute", "s": "spherical", "u": "universal"}
    corners = [(0.0, 0.0, 0.0), (0.0, 0.0, scale), (0.5 * scale, 0.0, scale), (0.5 * scale, 0.0, 0.0)]
    middles = [(0.0, 0.0, 0.5 * scale), (0.25 * scale, 0.0, scale), (0.5 * scale, 0.0, 0.5 * scale)]
    inertia = tuple(tuple(mass * scale**2 * x for x in row) for row in ROUND)
    bodies = [Body(name, mass, inertia, middle) for name, middle in zip(("left", "top", "right"), middles, strict=True)]
    ends = [("ground", "left"), ("left", "top"), ("top", "right"), ("right", "ground")]
    axes = {"r": Pair((0.0, 1.0, 0.0), (0.0, 1.0, 0.0)), "u": Pair((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), "s": None}
    joints = [
        Joint(f"J{number}", names[kind], ends[number], Pair(corners[number], corners[number]), axes[kind])
        for number, kind in enumerate(kinds)
    ]
    return scene_of(bodies, joints)
