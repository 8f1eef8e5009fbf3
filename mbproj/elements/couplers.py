"""Rows between joint coordinates: a rack on its pinion, a cam with its follower."""

from __future__ import annotations

from mbproj.elements.element import Element, Row
from mbproj.functions.program import Program


def rack(name: str, angle: str, displacement: str, radius: float) -> Element:
    """s - r φ = const of two joint coordinates; `radius` r in m, negative where they go opposite ways."""
    return Element(name, rows=(Row("mesh", {displacement: 1.0, angle: -radius}),))


def cam(name: str, angle: str, follower: str, lift: Program) -> Element:
    """s - f(φ) = const of two joint coordinates, with the `lift` f of COORDINATE in m or rad. It repeats with each turn
    and is twice differentiable, as tables that are `periodic`."""
    return Element(name, rows=(Row("law", {angle: 0.0, follower: 1.0}, lift),))
