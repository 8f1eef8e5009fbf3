"""A cam's law: a follower's coordinate is a function of the cam's angle."""

from __future__ import annotations

from mbproj.elements.element import Element, Row
from mbproj.functions.program import Program


def cam(name: str, angle: str, follower: str, lift: Program) -> Element:
    """s - f(φ) = const of two joint coordinates, with the `lift` f of COORDINATE in m or rad, which repeats with each
    turn."""
    return Element(name, rows=(Row("law", {angle: 0.0, follower: 1.0}, lift),))
