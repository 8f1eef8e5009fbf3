"""Stops as arrays: one-sided limits of coordinates."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.registry import USUAL_IMPACT_LAW


@dataclass(frozen=True, eq=False)
class Stops:
    """S one-sided limits on scalar coordinates s: the gap g = side (s - bound) is never negative at a rigid stop. A
    compliant stop pushes while its penetration δ = -g is positive, with k δᵖ (1 + c δ') (Hunt & Crossley 1975). With a
    restitution it pushes with k δᵖ (1 + d δ' / √(δ'² + κ 2V/m)), where V is its energy and m the mass that it meets.

    `coordinates`: the s as primitives, S rows. `joint_coordinate` (S,): the number of s among the system's coordinates,
    so that an angle counts its turns; -1 for the distance of two points, or of a point from a plane. `side` (S,): 1 for
    a lower bound of s, -1 for an upper one; `bound` (S,) in m or rad. `stiffness` k (S,), in N or N m per m or rad to
    the power `exponent` p (S,): infinite for a rigid stop. `restitution` (S,): the ratio of the speeds after and before
    a free impact, NaN where the damping is given. `damping` c (S,) in s/m or s/rad, NaN where the restitution is given.
    `resistance` d, `softening` κ (S,) follow from the restitution.

    `owners`: "joint 'hinge'" or "force 'bumper'", for messages; `places`: the place of each in the scene. `impact_law`:
    the law of all rigid stops, by its name in `registry.IMPACT_LAWS`.
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
    impact_law: str = USUAL_IMPACT_LAW

    @property
    def size(self) -> int:
        """S."""
        return len(self.side)

    def pushes_by(self, k: int, row: Array) -> float:
        """Return the coefficient of damping of stop k while it touches: c, or κ 2k / ((p + 1) m) for a stop with a
        restitution. 1/m is |N|² of its `row` N (f,) in coordinates in which the kinetic energy is ½|x|²."""
        if np.isnan(self.restitution[k]):
            return float(self.damping[k])
        return float(self.gives_by[k] * (row @ row))

    @property
    def gives_by(self) -> Array:
        """κ 2k / (p + 1) of compliant stops with a restitution, (S,); divided by the mass it is the coefficient of
        damping."""
        return 2.0 * self.softening * self.stiffness / (self.exponent + 1.0)

    @property
    def is_rigid(self) -> npt.NDArray[np.bool_]:
        """Whether each stop is rigid, (S,)."""
        return np.isinf(self.stiffness)
