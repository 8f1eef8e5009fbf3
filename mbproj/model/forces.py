"""Forces as arrays: laws on scalar coordinates (distances, joint coordinates), bushings, and given forces on bodies."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.model.bushings import COORDINATES, Bushings
from mbproj.model.primitive_set import PrimitiveSet, bind


@dataclass(frozen=True, eq=False)
class Laws:
    """E generalised forces, each on one coordinate s, positive where it drives s up:

        F = -stiffness (s - free) - damping s' + program(t, s, s')

    `coordinates`: the s as primitives, E rows. `joint_coordinate` (E,): which of the system's coordinates s is, so that
    an angle counts the turns of its joint; -1 for distances. `stiffness`, `damping`, `free` (E,). `program` (E,): its
    number in `Forces.programs`, -1 where a law has none. `loses` (E,): whether what the program gives is energy
    lost, as a damper's, not work done. `bearing` (E,): whose load what the program gives is multiplied by, a number of
    `System.bearings`; -1 for none. `apart` (E,): whether what it loses is an integral of its own.
    `partner` (E,): of friction in a plane, the law along the other tangent, or -1; `sliding` (E, 2): the direction of
    sliding along both. What its program gives of the speed in the plane is along the velocity, as long as that has not
    turned round.
    """

    coordinates: PrimitiveSet
    joint_coordinate: Integers
    stiffness: Array
    damping: Array
    free: Array
    program: Integers
    loses: npt.NDArray[np.bool_]
    bearing: Integers
    apart: npt.NDArray[np.bool_]
    partner: Integers
    sliding: Array

    @property
    def size(self) -> int:
        """E."""
        return len(self.stiffness)

    @property
    def is_angle(self) -> Integers:
        """1 for laws on angles, which count turns, 0 for the others, (E,)."""
        return (~self.coordinates.is_length).astype(np.intp)


@dataclass(frozen=True, eq=False)
class BodyForces:
    """W given forces (N) and torques (N m), each on one body.

    `body` (W,), `point` (W, 3) in the body's axes, `is_torque` (W,). The components are those of `program` (W, 3) in
    axes that `turn` (W, 3, 3) takes to the body's where `in_body` (W,), and else to the global ones.
    """

    body: Integers
    point: Array
    is_torque: npt.NDArray[np.bool_]
    in_body: npt.NDArray[np.bool_]
    turn: Array
    program: Integers

    @property
    def size(self) -> int:
        """W."""
        return len(self.body)


@dataclass(frozen=True, eq=False)
class Forces:
    """All forces of a scene but gravity. `law_owners`, `program_owners`, `bushing_names`: the names of the forces that
    laws, programs and bushings belong to, for messages.

    What forces act along are the coordinates of the laws, and then six of each bushing, F in all.
    """

    laws: Laws
    bushings: Bushings
    on_bodies: BodyForces
    programs: ProgramSet
    law_owners: tuple[str, ...]
    program_owners: tuple[str, ...]
    bushing_names: tuple[str, ...]

    @property
    def is_empty(self) -> bool:
        """Whether there are none."""
        return not (self.size or self.on_bodies.size)

    @property
    def size(self) -> int:
        """F."""
        return self.laws.size + len(COORDINATES) * self.bushings.size

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each coordinate, m or rad, (F,)."""
        return (*self.laws.coordinates.units, *self.bushings.units)

    @property
    def owners(self) -> tuple[str, ...]:
        """The force that acts along each coordinate, (F,)."""
        return (*self.law_owners, *(name for name in self.bushing_names for _ in COORDINATES))


def _nothing() -> Forces:
    none: Array = np.zeros(0)
    empty = np.zeros(0, dtype=np.intp)
    return Forces(
        laws=Laws(
            bind([]),
            empty,
            none,
            none,
            none,
            empty,
            np.zeros(0, dtype=bool),
            empty,
            np.zeros(0, dtype=bool),
            empty,
            np.zeros((0, 2)),
        ),
        bushings=Bushings.none(),
        on_bodies=BodyForces(
            empty,
            np.zeros((0, 3)),
            np.zeros(0, dtype=bool),
            np.zeros(0, dtype=bool),
            np.zeros((0, 3, 3)),
            np.zeros((0, 3), dtype=np.intp),
        ),
        programs=flatten([]),
        law_owners=(),
        program_owners=(),
        bushing_names=(),
    )


#: Of a scene without any.
NO_FORCES = _nothing()
