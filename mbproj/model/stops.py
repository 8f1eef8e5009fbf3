"""Stops as arrays: what coordinates may not pass."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.model.primitive_set import PrimitiveSet


@dataclass(frozen=True, eq=False)
class Stops:
    """S one-sided limits on scalar coordinates s: the gap g = side (s - bound) is never negative at a rigid stop. A
    compliant one pushes while its penetration δ = -g is positive, with k δᵖ (1 + c δ') (Hunt & Crossley 1975). With a
    restitution it pushes with k δᵖ (1 + d δ' / √(δ'² + κ 2V/m)), where V is its energy and m the mass that it sees.

    `coordinates`: the s as primitives, S rows. `joint_coordinate` (S,): which of the system's coordinates s is, so
    that an angle counts its turns; -1 for the distance of two points, or of a point from a plane. `side` (S,): 1 for
    the least that s may be, -1 for the most; `bound` (S,) in m or rad. `stiffness` k (S,), in N or N m per m or rad
    to the power `exponent` p (S,): infinite where a stop is rigid. `restitution` (S,): the part of the speed of
    approach with which a free impact ends, NaN where the damping is given. `damping` c (S,) in s/m or s/rad, NaN
    where the restitution is given. `resistance` d, `softening` κ (S,), from the restitution. `owners`: "joint
    'hinge'" or "force 'bumper'", for messages; `places`: where each stands in the scene. `impact_law`: that of all
    rigid ones, by its name in `registry.IMPACT_LAWS`.
    """

    coordinates: PrimitiveSet
    joint_coordinate: Integers
    side: Array
    bound: Array
    stiffness: Array
    exponent: Array
    restitution: Array
    damping: Array
    resistance: Array
    softening: Array
    owners: tuple[str, ...]
    places: tuple[Place | None, ...]
    impact_law: str = "newton"

    @property
    def size(self) -> int:
        """S."""
        return len(self.side)

    def pushes_by(self, k: int, row: Array) -> float:
        """What the damping of a compliant stop goes by while it touches: c, or κ 2k / ((p + 1) m), where 1/m = |N|² of
        its `row` N (f,) in coordinates in which the kinetic energy is ½|x|²."""
        if np.isnan(self.restitution[k]):
            return float(self.damping[k])
        return float(self.gives_by[k] * (row @ row))

    @property
    def gives_by(self) -> Array:
        """Of a compliant stop with a restitution κ 2k / (p + 1), (S,): its damping goes by that over the mass."""
        return 2.0 * self.softening * self.stiffness / (self.exponent + 1.0)

    @property
    def counts_turns(self) -> npt.NDArray[np.bool_]:
        """Which are of angles that count turns, (S,)."""
        return (self.joint_coordinate >= 0) & ~self.coordinates.is_length

    @property
    def is_rigid(self) -> npt.NDArray[np.bool_]:
        """Which are rigid, (S,)."""
        return np.isinf(self.stiffness)
