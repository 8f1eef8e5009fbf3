"""Bearings as arrays: the loads of joints, in proportion to which dry friction acts."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass

#: Terms of a sum of multipliers: the number of the joint, the number of its row from 0, and the factor of the
#: multiplier.
Parts: TypeAlias = "tuple[tuple[int, int, float], ...]"


@dataclass(frozen=True, eq=False)
class Bearings:
    """B loads on which dry frictions depend. A joint exerts the force F and the torque T on its body 2, at its point
    there. With z the joint's axis, a bearing with two supports at a distance ℓ carries

        load = preload + radial (|f₁| + |f₂|) + axial |F·z|,    f₁, f₂ = ½ (F - (F·z) z) ± (T × z)/ℓ.

    `joint` (B,): the number of the joint. `axis` (B, 3): z in the axes of body 2. `radial` and `axial` (B,): arms in m
    where the friction is a torque, factors (1 or 0) where it is a force. `length` ℓ (B,) in m, infinite where moments
    do not count. `preload` (B,) in N m or N.

    The push of a stop is a load of another kind: Σ part λ over its `parts` (B,), which are empty for bearings of
    joints. With `axial` 1 the load is |Σ part λ|, as for the pull of a rope.
    """

    joint: Integers
    axis: Array
    radial: Array
    axial: Array
    length: Array
    preload: Array
    parts: tuple[Parts, ...]

    @property
    def size(self) -> int:
        """B."""
        return len(self.joint)

    @property
    def is_of_rows(self) -> Flags:
        """Whether each load is a sum of multipliers, (B,)."""
        return np.array([len(each) > 0 for each in self.parts], dtype=bool)

    @property
    def is_push(self) -> Flags:
        """Whether each load is the push of a stop, (B,)."""
        return np.asarray(self.is_of_rows & (self.axial == 0.0))
