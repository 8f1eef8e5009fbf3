"""A plate through points that lie in a plane, as a link with three joints or more has it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.pages.look.parts import UPRIGHT, Mesh, Part

#: Points lie in a plane where they leave it by less than this many thicknesses; on a line likewise.
FLAT = 1.0
#: Corners of a round corner.
ROUND = 12


def plate(points: Sequence[Array], thickness: float) -> tuple[Part, ...]:
    """The plate with round corners about points (3,) in a plane; nothing where they are in none, or on a line."""
    cloud = np.array(points)
    middle = cloud.mean(axis=0)
    _, sizes, axes = np.linalg.svd(cloud - middle)
    if len(points) < 3 or sizes[2] > FLAT * thickness or sizes[1] < 2.0 * FLAT * thickness:
        return ()
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    round_corner = 1.3 * thickness * np.column_stack([np.cos(turn), np.sin(turn)])
    spread = ((cloud - middle) @ axes[:2].T)[:, None, :] + round_corner
    outline = hull(spread.reshape(-1, 2))
    return (Part("mesh", (), middle, np.array(UPRIGHT), _prism(outline, axes, thickness)),)


def hull(points: Array) -> Array:
    """The corners (k, 2) of the convex hull of points in a plane, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(map(tuple, points.tolist()))

    def half(sequence: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
        chain: list[tuple[float, ...]] = []
        for x, y in sequence:
            while len(chain) > 1 and _turns_right(chain[-2], chain[-1], (x, y)):
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))


def _turns_right(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0.0


def _prism(outline: Array, axes: Array, thickness: float) -> Mesh:
    """The outline in the plane of axes[0] and axes[1], made `thickness` thick."""
    count, normal = len(outline), np.cross(axes[0], axes[1])
    flat = outline @ axes[:2]
    vertices = np.concatenate([flat + 0.5 * thickness * normal, flat - 0.5 * thickness * normal])
    fan = [(0, i, i + 1) for i in range(1, count - 1)]
    back = [(count, count + i + 1, count + i) for i in range(1, count - 1)]
    after = [(i + 1) % count for i in range(count)]
    sides = [(i, count + i, after[i]) for i in range(count)] + [
        (after[i], count + i, count + after[i]) for i in range(count)
    ]
    return Mesh(vertices, np.array(fan + back + sides, dtype=np.intp))
