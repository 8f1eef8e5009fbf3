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
    """E generalised forces, each along one coordinate s, positive where it drives s up:

        F = -stiffness (s - free) - damping s' + program(t, s, s')

    `coordinates`: the s as primitives, E rows. `joint_coordinate` (E,): the number of s among the system's coordinates,
    so that an angle counts the turns of its joint; -1 for distances. `stiffness`, `damping`, `free` (E,). `program`
    (E,): the number in `Forces.programs`, -1 for none. `loses` (E,): whether the work of the program is energy lost, as
    in a damper. `bearing` (E,): the number in `System.bearings` of the load that multiplies the program; -1 for none.
    `apart` (E,): whether a separate integral counts the energy it loses.

    For friction in a plane `partner` (E,) is the law along the other tangent, else -1, and `sliding` (E, 2) the
    direction of sliding along both tangents. Its program, of the speed in the plane, gives a force along the velocity,
    as long as the velocity has not reversed.
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

    `body` (W,), `point` (W, 3) in the body's axes, `is_torque` (W,). `program` (W, 3): the numbers of the components'
    programs. Where `in_body` (W,), `turn` (W, 3, 3) takes them to the body's axes; else they are in global axes.
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
    """All forces of a scene but gravity. They act along F coordinates: first those of the laws, then six of each
    bushing.

    `law_owners`, `program_owners`, `bushing_names`: the names of the forces to which laws, programs and bushings
    belong, for messages.
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
        """Whether the scene has no force."""
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


#: The forces of a scene without any.
NO_FORCES = _nothing()
