"""Reflected inertias: bodies behind a gear that turn with a joint's coordinate, and are not bodies of the scene.

A flywheel of moment J that a train of ratio n drives from a joint's angle θ moves with n θ'. Its kinetic energy is ½ J
n² θ'² = ½ I θ'², and I = J n² is the inertia that the joint feels (the armature of robotics). The place of the flywheel
and the direction of its axis do not count: only the momentum I θ' is modelled.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.model.primitive_set import PrimitiveSet, bind


@dataclass(frozen=True, eq=False)
class ReflectedInertias:
    """k kinetic energies ½ I s'², each of one joint coordinate s.

    `rows`: the coordinates as primitives, k rows. `joint_coordinate` (k,): the number of each among the system's
    coordinates. `inertia` (k,): I in kg m² for an angle, in kg for a displacement.
    """

    rows: PrimitiveSet
    joint_coordinate: Integers
    inertia: Array

    @property
    def size(self) -> int:
        """k."""
        return len(self.inertia)


#: The reflected inertias of a scene without any.
NO_REFLECTED = ReflectedInertias(bind([]), np.zeros(0, dtype=np.intp), np.zeros(0))
