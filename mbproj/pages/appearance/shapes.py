"""The shapes of a scene's bodies as solids."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.model.euler_parameters import product
from mbproj.pages.appearance.parts import Solid, bar, sphere
from mbproj.scene.appearance import PlacedShape

_HALF = 0.5**0.5
#: The Euler parameters that turn z to the axis of a shape.
TO_AXIS: Mapping[str, tuple[float, ...]] = {
    "x": (_HALF, 0.0, _HALF, 0.0),
    "y": (_HALF, -_HALF, 0.0, 0.0),
    "z": (1.0, 0.0, 0.0, 0.0),
}


def part_of(shape: PlacedShape, thickness: float) -> tuple[Solid, ...]:
    """The solids that a shape is drawn as. A rod and a point have no thickness of their own and take this one."""
    sizes, position, turn = shape.sizes, np.array(shape.position), np.array(shape.orientation)
    along = product(turn, np.array(TO_AXIS[shape.axis]))
    if shape.kind == "box":
        return (Solid("box", (sizes["a"], sizes["b"], sizes["c"]), position, turn),)
    if shape.kind == "cylinder":
        return (Solid("cylinder", (sizes["radius"], sizes["length"]), position, along),)
    if shape.kind == "tube":
        return (Solid("tube", (sizes["outer_radius"], sizes["inner_radius"], sizes["length"]), position, along),)
    if shape.kind == "rod":
        half = np.array([0.0, 0.0, 0.5 * sizes["length"]])
        return tuple(part.moved(position, along) for part in bar(-half, half, 0.7 * thickness))
    radius = {"sphere": sizes.get("r"), "hollow_sphere": sizes.get("outer_radius")}.get(shape.kind)
    return (sphere(radius if radius is not None else 1.5 * thickness, position),)
