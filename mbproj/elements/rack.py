"""A rack on a pinion: the displacement is the pinion's radius times the angle."""

from __future__ import annotations

from mbproj.elements.element import Element, Row


def rack(name: str, angle: str, displacement: str, radius: float) -> Element:
    """s - r φ = const of two joint coordinates; `radius` r in m, negative where they go opposite ways."""
    return Element(name, rows=(Row("mesh", {displacement: 1.0, angle: -radius}),))
