"""Reflected inertias: what turns with a joint's coordinate behind a gear, and is no body of the scene.

A flywheel of moment J that a train of ratio n drives from a joint's angle θ moves with n θ': its kinetic energy is
½ J n² θ'² = ½ I θ'², and I = J n² is the inertia that the joint feels (the armature of robotics). Where on the bodies
the flywheel sits, and which way its axis points, does not count: of its momentum nothing but I θ' is taken along.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.model.primitive_set import PrimitiveSet, bind


@dataclass(frozen=True, eq=False)
class ReflectedInertias:
    """k kinetic energies ½ I s'², each of one joint coordinate s.

    `rows`: the coordinates as primitives, k rows; `joint_coordinate` (k,): which of the system's coordinates each is;
    `inertia` (k,): I in kg m² of an angle, in kg of a displacement.
    """

    rows: PrimitiveSet
    joint_coordinate: Integers
    inertia: Array

    @property
    def size(self) -> int:
        """k."""
        return len(self.inertia)


#: Of a scene without any.
NO_REFLECTED = ReflectedInertias(bind([]), np.zeros(0, dtype=np.intp), np.zeros(0))
