"""A wheel about a fixed axle, which turns evenly."""

from __future__ import annotations

from mbproj.scene.records import Body, Joint, Marker, Pair
from tests.support import scene_of

ROUND = ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01))


def spinner(speed: float):
    """A wheel about z without gravity."""
    wheel = Body("wheel", 1.0, ROUND, (0.0, 0.0, 0.0))
    axis = Pair((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    joint = Joint("axle", "revolute", ("ground", "wheel"), Pair((0.0,) * 3, (0.0,) * 3), axis, speed={"angle": speed})
    return scene_of([wheel], [joint], [Marker("rim", "wheel", (1.0, 0.0, 0.0))], gravity=(0.0, 0.0, 0.0))
