"""The scene as frozen records, in SI units and radians. There are no arrays here: the compiled System has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mbproj.dataclass import dataclass
from mbproj.settings import ProjectionSettings as ProjectionSettings
from mbproj.settings import Settings as Settings

if TYPE_CHECKING:
    from mbproj.elements import Kind
    from mbproj.functions.program import Program
    from mbproj.scene.appearance import Appearance, PlacedShape
    from mbproj.scene.coupled import Coupled
    from mbproj.scene.friction import DryFriction
    from mbproj.scene.stops import DistanceStop, Limit, PlaneStop

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix = tuple[Vector, Vector, Vector]
#: The path of a value in the scene file, e.g. ("joints", "A", "axis").
KeyPath = tuple[str | int, ...]

GROUND = "ground"


@dataclass(frozen=True)
class Body:
    """A rigid body: mass in kg, inertia tensor in kg m² about the centre of mass in body axes, and its pose at start.

    `position` is the centre of mass in m, `orientation` the unit Euler parameters (scalar first, body to global),
    `velocity` global in m/s, `angular_velocity` in body axes in rad/s. Assembly starts from them, or from the pose
    `start`. The body is drawn by its `appearance`, or the `shapes` that give its mass."""

    name: str
    mass: float
    inertia: Matrix
    position: Vector
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)
    angular_velocity: Vector = (0.0, 0.0, 0.0)
    start: tuple[Vector, Quaternion] | None = None
    shapes: tuple[PlacedShape, ...] = field(default=(), compare=False)
    appearance: Appearance | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Pair:
    """A point or a direction on each of a joint's two bodies.

    Where `local`, each is in its body's own axes (a point from the centre of mass), else global at the pose that
    `bodies` gives. One global vector serves both bodies: first == second.
    """

    first: Vector
    second: Vector
    local: bool = False


@dataclass(frozen=True)
class Orientations:
    """The orientation of a frame of each of two bodies, as Euler parameters of its axes: in the body's axes where
    `local`, and else in the global ones at the pose that `bodies` gives."""

    first: Quaternion
    second: Quaternion
    local: bool = False


@dataclass(frozen=True)
class Joint:
    """A joint of type `type` (a name in `mbproj.joints.JOINTS`) from bodies[0] to bodies[1].

    `axes` is None where the type has none. `start` are hard conditions on its coordinates at t = 0 (rad, m), `speed` on
    their rates (rad/s, m/s), by coordinate name. `parameters`: a pitch, a length (m), numbers of teeth, a curve.
    `reaction`: whether a joint that merges its bodies keeps them two, so that its reaction is known. `couples`: the row
    of a coupling; its `bodies` are then the second bodies of the first and the last of its joints.
    `reflected_inertia` (kg m², kg) and `limits` are by coordinate name. `frames`: the axes of each body that a merging
    joint makes coincide; None: the global axes at the scene's pose. `x_axis`: the direction of its x; None: any.
    """

    name: str
    type: str
    bodies: tuple[str, str]
    points: Pair
    axes: Pair | None = None
    start: Mapping[str, float] = field(default_factory=dict)
    speed: Mapping[str, float] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    reaction: bool = False
    couples: Coupled | None = None
    reflected_inertia: Mapping[str, float] = field(default_factory=dict)
    limits: Mapping[str, Limit] = field(default_factory=dict)
    frames: Orientations | None = None
    x_axis: Pair | None = None


@dataclass(frozen=True)
class Law:
    """A generalised force on a coordinate s, positive where it drives s up:

        F = -stiffness (s - free) - damping s' + function(t, s, s')

    SI units and radians. `free` None: the free length of a spring between two points is that at the scene's pose.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    free: float | None = None
    function: Program | None = None


@dataclass(frozen=True)
class PointForce:
    """A force along the line between a point of bodies[0] and one of bodies[1]; the law's coordinate is its length."""

    name: str
    bodies: tuple[str, str]
    points: Pair
    law: Law
    element: Kind | None = None


@dataclass(frozen=True)
class JointForce:
    """Forces on coordinates of a joint: `laws` by coordinate, "" for the only one in `unit` ("rad", "m", None: any).

    `coulomb`: dry frictions by coordinate, "" for the only one in their unit. `element` takes the place of one law.
    """

    name: str
    joint: str
    laws: Mapping[str, Law]
    unit: str | None = None
    coulomb: Mapping[str, DryFriction] = field(default_factory=dict)
    element: Kind | None = None

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The coordinates on which the force acts."""
        return tuple(dict.fromkeys((*self.laws, *self.coulomb)))

    def called(self, coordinate: str) -> str:
        """The name in results of the force along a coordinate: its own, with the coordinate where it has several."""
        return f"{self.name}.{coordinate}" if len(self.coordinates) > 1 else self.name


@dataclass(frozen=True)
class BodyForce:
    """A force in N, or a torque in N m (`torque`), of given components, each a function of t, on a body.

    They are along the global axes, or the body's where `body_axes`. A force acts at `location`: global at the scene's
    pose, or from the centre of mass in the body's axes where `local`; None: at the centre of mass.
    """

    name: str
    body: str
    components: tuple[Program, Program, Program]
    torque: bool
    body_axes: bool = False
    location: Vector | None = None
    local: bool = False


NO_MATRIX: Matrix = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Bushing:
    """An elastic element between a frame of bodies[0] and one of bodies[1], with their origins at `points`.

    It acts with preload - stiffness s - damping s' on the relative translation and on the rotation vector s. Each of
    the three is a pair (for the translation, for the rotation).
    """

    name: str
    bodies: tuple[str, str]
    points: Pair
    axes: Orientations
    stiffness: tuple[Matrix, Matrix] = (NO_MATRIX, NO_MATRIX)
    damping: tuple[Matrix, Matrix] = (NO_MATRIX, NO_MATRIX)
    preload: tuple[Vector, Vector] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


Force: TypeAlias = "PointForce | JointForce | BodyForce | Bushing | DistanceStop | PlaneStop"


@dataclass(frozen=True)
class Motion:
    """A coordinate of a joint as a function of t, in m or rad. `from_start`: the function is added to the value that
    the joint's own condition gives at t = 0; else it is the value."""

    name: str
    joint: str
    coordinate: str
    function: Program
    from_start: bool = False


@dataclass(frozen=True)
class Marker:
    """A point of a body whose path is recorded: `location` global at the scene's pose, or from the body's centre of
    mass in its own axes where `local`."""

    name: str
    body: str
    location: Vector
    local: bool = False


class Passage(NamedTuple):
    """The first time at which a joint coordinate ("crank.angle") has a value in its `unit`; angles modulo a turn."""

    coordinate: str
    value: float
    unit: str


@dataclass(frozen=True)
class Expectation:
    """A result that a run has to give: a `value` within `tolerance`, or at most `below`, or at least `above`. `source`
    says where the number comes from.

    `of` ("marker", .., "diagnostic") is the kind of the `item`. `quantity` is one of `mbproj.scene.blocks.observables`,
    in the SI unit `unit`; `component` is "x", "y", "z", "norm" or "" for all. `over` is the input of a ratio, `between`
    the markers of a transmission angle. `at` is a time in s, a passage, or one of `observables.MOMENTS`."""

    name: str
    of: str
    item: str
    quantity: str
    unit: str
    component: str
    at: float | str | Passage
    source: str
    value: tuple[float, ...] | None = None
    tolerance: float | None = None
    below: float | None = None
    above: float | None = None
    over: str = ""
    between: tuple[str, ...] = ()
