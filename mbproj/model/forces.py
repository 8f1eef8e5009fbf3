"""Forces as arrays: laws on scalar coordinates (distances, joint coordinates), bushings, given forces on bodies, and
reflected inertias."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Flags, Integers
from mbproj.base.dataclass import dataclass
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.model.primitive_set import PrimitiveSet, bind

#: The coordinates of a bushing, with their units.
COORDINATES = {"x": "m", "y": "m", "z": "m", "rx": "rad", "ry": "rad", "rz": "rad"}


@dataclass(frozen=True, eq=False)
class Bushings:
    """B bushings, each between a frame in one body and a frame in another.

    `body` (B, 2). Each frame in the axes of its body: `origin` (B, 2, 3), and `turn` (B, 2, 4), the Euler parameters of
    the rotation from frame to body. With s the six coordinates of a bushing, three translations and a rotation vector
    φ:

        F = preload - stiffness s - damping w,   stiffness and damping (B, 6, 6), preload (B, 6).

    For the translations w is s'; for the rotation w is the relative angular velocity, in place of φ', and F is a
    torque. No block of `stiffness` or `damping` couples translations with the rotation.
    """

    body: Integers
    origin: Array
    turn: Array
    stiffness: Array
    damping: Array
    preload: Array

    @classmethod
    def none(cls) -> Bushings:
        """No bushings."""
        turn, square = np.zeros((0, 2, 4)), np.zeros((0, 6, 6))
        return cls(np.zeros((0, 2), dtype=np.intp), np.zeros((0, 2, 3)), turn, square, square, np.zeros((0, 6)))

    @property
    def size(self) -> int:
        """B."""
        return len(self.body)

    @property
    def units(self) -> tuple[str, ...]:
        """The units of all coordinates, one bushing after the other."""
        return (*COORDINATES.values(),) * self.size

    @property
    def turns_freely(self) -> Flags:
        """Whether the relative rotation of its frames has no effect on what a bushing exerts, (B,). Such a bushing
        resists only the distance of the origins, alike in all directions, and the relative angular velocity, alike
        too."""
        rigid, viscous = self.stiffness, self.damping
        alike = _is_isotropic(rigid[:, :3, :3]) & _is_isotropic(viscous[:, 3:, 3:])
        others = (rigid[:, 3:, 3:], viscous[:, :3, :3], self.preload[:, None, :])
        return alike & ~np.any([part.any(axis=(1, 2)) for part in others], axis=0)

    def on_diagonal(self, matrices: Array) -> Array:
        """Return the diagonals of `stiffness` or `damping`, (6B,)."""
        return np.diagonal(matrices, axis1=1, axis2=2).ravel()


def _is_isotropic(matrices: Array) -> Flags:
    """Whether each of the matrices (B, 3, 3) is a multiple of the identity, (B,)."""
    isotropic: Flags = (matrices == matrices[:, :1, :1] * np.eye(3)).all(axis=(1, 2))
    return isotropic


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
    direction of sliding along both tangents. Its program is a function of the speed in the plane. The force is along
    the velocity until the velocity reverses.
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
    programs. Where `in_body` (W,) is true, the rotation `turn` (W, 3, 3) takes the components to the body's axes; else
    they are in global axes.
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


@dataclass(frozen=True, eq=False)
class ReflectedInertias:
    """k kinetic energies ½ I s'², each of one joint coordinate s: of bodies behind a gear that the scene does not have.

    A flywheel of moment J that a train of ratio n drives from a joint's angle θ moves with n θ'. Its kinetic energy is
    ½ J n² θ'² = ½ I θ'², and I = J n² is the inertia that the joint feels (the armature of robotics). The place of the
    flywheel and the direction of its axis do not count: only the momentum I θ' is modelled.

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
