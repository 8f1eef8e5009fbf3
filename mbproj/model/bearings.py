"""Bearings as arrays: what joints carry, by which dry friction goes."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass


@dataclass(frozen=True, eq=False)
class Bearings:
    """B loads of joints. A joint exerts the force F and the torque T on its body 2 at its point there. Along its axis z
    a bearing of two supports at a distance ℓ carries

        load = preload + radial (|f₁| + |f₂|) + axial |F·z|,    f₁, f₂ = ½ (F - (F·z) z) ± (T × z)/ℓ.

    `joint` (B,): its number. `axis` (B, 3): z in the axes of its body 2. `radial` and `axial` (B,): arms in m where the
    friction is a torque, parts of the force (1 or 0) where it is a force. `length` ℓ (B,) in m, infinite where moments
    do not count. `preload` (B,) in N m or N. The push of a stop is another load: Σ part λ. The λ is that of the only
    row of each joint in `parts` (B,), pairs of a joint and its part; empty for all else.
    """

    joint: Integers
    axis: Array
    radial: Array
    axial: Array
    length: Array
    preload: Array
    parts: tuple[tuple[tuple[int, float], ...], ...]

    @property
    def size(self) -> int:
        """B."""
        return len(self.joint)

    @property
    def is_push(self) -> Flags:
        """Which are the push of a stop, (B,)."""
        return np.array([len(each) > 0 for each in self.parts], dtype=bool)
