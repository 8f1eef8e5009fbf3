"""The scene as frozen records, in SI units and radians. There are no arrays here: the compiled System has them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import field
from types import MappingProxyType
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from mbproj.base.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.joints.table import COORDINATE_UNITS, JOINTS

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix = tuple[Vector, Vector, Vector]
#: The path of a value in the scene file, e.g. ("joints", "A", "axis").
KeyPath = tuple[str | int, ...]

GROUND = "ground"


class Quantity(NamedTuple):
    """What the numbers of an annotated field are; several quantities are those of the members of a tuple.

    `unit` is of SI, "" for none. In it `coordinate` stands for the unit of the coordinate that the field is about: m
    where the record names none. {0.name} stands for a field of the record.

    `moves`: whether the numbers are a point, a direction or an orientation. They move with the scene, unless the flag
    `local` of the record says that they are in the axes of a body. Vectors that do not move are always in such axes. A
    record that declares no quantities has those of the field that holds it.
    """

    unit: str = ""
    moves: Literal["", "point", "direction", "orientation"] = ""
    local: str = "local"


#: The unit of each value of a mapping is that under its key in `units` of the record.
BY_KEY = Quantity("units")
LENGTH, POINT = Quantity("m"), Quantity("m", "point")
DIRECTION, ORIENTATION = Quantity("", "direction"), Quantity("", "orientation")
COORDINATE, RATE = Quantity("coordinate"), Quantity("coordinate/s")


@dataclass(frozen=True)
class Body:
    """A rigid body: mass in kg, inertia tensor in kg m² about the centre of mass in body axes, and its pose at start.

    `position` is the centre of mass in m, `orientation` the unit Euler parameters (scalar first, body to global),
    `velocity` global in m/s, `angular_velocity` in body axes in rad/s. Assembly starts from them, or from the pose
    `start`. The body is drawn by its `appearance`, or the `shapes` that give its mass."""

    name: str
    mass: Annotated[float, Quantity("kg")]
    inertia: Annotated[Matrix, Quantity("kg*m^2")]
    position: Annotated[Vector, POINT]
    orientation: Annotated[Quaternion, ORIENTATION] = (1.0, 0.0, 0.0, 0.0)
    velocity: Annotated[Vector, Quantity("m/s", "direction")] = (0.0, 0.0, 0.0)
    angular_velocity: Annotated[Vector, Quantity("rad/s")] = (0.0, 0.0, 0.0)
    start: Annotated[tuple[Vector, Quaternion] | None, POINT, ORIENTATION] = None
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
    """A joint of type `type` (a name in `mbproj.joints.table.JOINTS`) from bodies[0] to bodies[1].

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
    points: Annotated[Pair, POINT]
    axes: Annotated[Pair | None, DIRECTION] = None
    start: Annotated[Mapping[str, float], COORDINATE] = field(default_factory=dict)
    speed: Annotated[Mapping[str, float], RATE] = field(default_factory=dict)
    parameters: Annotated[Mapping[str, Any], BY_KEY] = field(default_factory=dict)
    reaction: bool = False
    couples: Coupled | None = None
    reflected_inertia: Annotated[Mapping[str, float], Quantity("J*s^2/coordinate^2")] = field(default_factory=dict)
    limits: Mapping[str, Limit] = field(default_factory=dict)
    frames: Annotated[Orientations | None, ORIENTATION] = None
    x_axis: Annotated[Pair | None, DIRECTION] = None

    @property
    def units(self) -> Mapping[str, str]:
        """The SI units of its coordinates and parameters by name, "" for none."""
        kind = JOINTS[self.type]
        coordinates = {name: COORDINATE_UNITS[row[0]] for name, row in kind.coordinates.items()}
        return coordinates | {name: each.unit for name, each in kind.parameters.items()}


@dataclass(frozen=True)
class Law:
    """A generalised force on a coordinate s, positive where it drives s up:

        F = -stiffness (s - free) - damping s' + function(t, s, s')

    SI units and radians. `free` None: the free length of a spring between two points is that at the scene's pose.
    """

    stiffness: Annotated[float, Quantity("J/coordinate^2")] = 0.0
    damping: Annotated[float, Quantity("J*s/coordinate^2")] = 0.0
    free: Annotated[float | None, COORDINATE] = None
    function: Annotated[Program | None, Quantity("J/coordinate")] = None


@dataclass(frozen=True)
class Kind:
    """The element that replaces the law of a force: its type, a name in `ELEMENTS` of `mbproj.scene.blocks.elements`,
    and the values of the type's own keys in SI units. `units` are those of the keys."""

    type: str
    values: Annotated[Mapping[str, Any], BY_KEY]
    units: Mapping[str, str]


@dataclass(frozen=True)
class PointForce:
    """A force along the line between a point of bodies[0] and one of bodies[1]; the law's coordinate is its length."""

    name: str
    bodies: tuple[str, str]
    points: Annotated[Pair, POINT]
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

    @property
    def coordinate(self) -> str:
        """The first of its coordinates."""
        return next(iter(self.coordinates), "")

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
    components: Annotated[tuple[Program, Program, Program], Quantity("{0.unit}", "direction", "body_axes")]
    torque: bool
    body_axes: bool = False
    location: Annotated[Vector | None, POINT] = None
    local: bool = False

    @property
    def unit(self) -> str:
        """The SI unit of the components."""
        return "N*m" if self.torque else "N"


NO_MATRIX: Matrix = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Bushing:
    """An elastic element between a frame of bodies[0] and one of bodies[1], with their origins at `points`.

    It acts with preload - stiffness s - damping s' on the relative translation and on the rotation vector s. Each of
    the three is a pair (for the translation, for the rotation).
    """

    name: str
    bodies: tuple[str, str]
    points: Annotated[Pair, POINT]
    axes: Annotated[Orientations, ORIENTATION]
    stiffness: Annotated[tuple[Matrix, Matrix], Quantity("N/m"), Quantity("N*m/rad")] = (NO_MATRIX, NO_MATRIX)
    damping: Annotated[tuple[Matrix, Matrix], Quantity("N*s/m"), Quantity("N*m*s/rad")] = (NO_MATRIX, NO_MATRIX)
    preload: Annotated[tuple[Vector, Vector], Quantity("N"), Quantity("N*m")] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


Force: TypeAlias = "PointForce | JointForce | BodyForce | Bushing | DistanceStop | PlaneStop"


@dataclass(frozen=True)
class Motion:
    """A coordinate of a joint as a function of t, in m or rad. `from_start`: the function is added to the value that
    the joint's own condition gives at t = 0; else it is the value."""

    name: str
    joint: str
    coordinate: str
    function: Annotated[Program, COORDINATE]
    from_start: bool = False


@dataclass(frozen=True)
class Marker:
    """A point of a body whose path is recorded: `location` global at the scene's pose, or from the body's centre of
    mass in its own axes where `local`."""

    name: str
    body: str
    location: Annotated[Vector, POINT]
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


# --- Stops ------------------------------------------------------------------------------------------------------------
# Stops, which limit joint coordinates, distances and points, as frozen records in SI units and radians.


@dataclass(frozen=True)
class StopLaw:
    """The law of a stop: rigid where `stiffness` is infinite, else a push of stiffness δ^exponent (1 + c δ').

    Either `restitution` is given, the ratio of the speed after a free impact to the speed of approach, or `damping`,
    c in s/m or s/rad; the other is None.
    """

    stiffness: Annotated[float, Quantity("J/coordinate/coordinate^{0.exponent:.12g}")] = math.inf
    exponent: float = 1.0
    restitution: float | None = None
    damping: Annotated[float | None, Quantity("s/coordinate")] = None


@dataclass(frozen=True)
class Limit:
    """The lower and the upper bound of a scalar coordinate, in m or rad; None for no bound."""

    low: Annotated[float | None, COORDINATE]
    high: Annotated[float | None, COORDINATE]
    law: StopLaw

    def sides(self) -> Iterator[tuple[int, float]]:
        """The sides that have a bound, as (side, bound): 0 is the lower side, 1 the upper one."""
        return ((at, bound) for at, bound in enumerate((self.low, self.high)) if bound is not None)

    def names(self, joint: str, coordinate: str) -> list[str]:
        """The names in results of the sides of a joint's limit."""
        return [f"{joint}.{coordinate}.{('low', 'high')[at]}" for at, _ in self.sides()]


@dataclass(frozen=True)
class OfBody:
    """A point or a direction of a body: global at the scene's pose, or in the body's own axes (a point from its centre
    of mass) where `local`."""

    body: str
    vector: Vector
    local: bool = False


@dataclass(frozen=True)
class DistanceStop:
    """A stop that keeps the distance of a point of one body from a point of another within `limit`."""

    name: str
    first: Annotated[OfBody, POINT]
    second: Annotated[OfBody, POINT]
    limit: Limit

    @property
    def stops(self) -> list[str]:
        """The names in results of the stop's sides: its own name where it has one side."""
        words = [("shortest", "longest")[at] for at, _ in self.limit.sides()]
        return [self.name] if len(words) == 1 else [f"{self.name}.{word}" for word in words]


@dataclass(frozen=True)
class PlaneFriction:
    """Dry friction of a point, ball or wheel on a plane: coefficients of the push while it slides and while it sticks.
    `stribeck_speed` in m/s is the speed over which the static one falls to the sliding one; None: it falls at once."""

    sliding: float
    static: float
    stribeck_speed: Annotated[float | None, RATE] = None


@dataclass(frozen=True)
class PlaneStop:
    """A stop that keeps a ball of `radius` in m (0: a point) around `point` on the side of a plane to which `normal`
    points.

    With an `axis`, a direction of the point's body, it is a wheel: a thin disk about that axis."""

    name: str
    location: Annotated[OfBody, POINT]
    normal: Annotated[OfBody, DIRECTION]
    point: Annotated[OfBody, POINT]
    radius: Annotated[float, LENGTH]
    law: StopLaw
    friction: PlaneFriction | None = None
    axis: Annotated[OfBody | None, DIRECTION] = None

    @property
    def stops(self) -> list[str]:
        """The name in results of the stop, as a list of one."""
        return [self.name]

    @property
    def frictions(self) -> list[str]:
        """The names in results of its friction along each of the two tangents of the plane."""
        return [] if self.friction is None else [f"{self.name}.{tangent}" for tangent in (1, 2)]


# --- Dry friction on coordinates of joints, as frozen records in SI units and radians ---------------------------------


@dataclass(frozen=True)
class Bearing:
    """The bearing of a joint: how the joint's reaction presses the surfaces that slide.

    On an angle `radius` and `axial_radius` are the arms, in m, of the friction by the radial and by the axial force
    (None: that force causes none); on a screw without `axial_radius` the `radius` is that of its thread. `length` in m:
    the distance of two supports that moments load; infinite where moments do not count. `preload` in N: a radial force
    that is always there.
    """

    radius: Annotated[float | None, LENGTH] = None
    axial_radius: Annotated[float | None, LENGTH] = None
    length: Annotated[float, LENGTH] = math.inf
    preload: Annotated[float, Quantity("N")] = 0.0

    @property
    def has_arm(self) -> bool:
        """Whether the bearing has an arm, by which a force causes a torque of friction."""
        return self.radius is not None or self.axial_radius is not None


@dataclass(frozen=True)
class DryFriction:
    """Friction that resists sliding along a coordinate s in `unit`, "rad" or "m", with

        sliding + (static - sliding) exp(-(s'/stribeck_speed)²)

    or with `sliding` alone where there is no `stribeck_speed`. It sticks while a force of at most `static` keeps s at
    rest. Both are in N m or N, or coefficients of the load of the `bearing`; functions where they change in a run. With
    `regularised`, in rad/s or m/s, this force is multiplied by tanh(s'/regularised) and never sticks.
    """

    unit: str
    sliding: Annotated[float | Program, Quantity("{0.size_unit}")]
    static: Annotated[float | Program, Quantity("{0.size_unit}")]
    stribeck_speed: Annotated[float | None, RATE] = None
    regularised: Annotated[float | None, RATE] = None
    bearing: Bearing | None = None

    @property
    def size_unit(self) -> str:
        """The unit of `sliding` and `static`."""
        return "" if self.bearing else "J/coordinate"

    @property
    def varies(self) -> bool:
        """Whether a function makes the friction change during a run."""
        return isinstance(self.sliding, Program) or isinstance(self.static, Program)


# --- The row that couples coordinates of joints -----------------------------------------------------------------------
# Of gears, racks, belts, differentials, and weighted sums.


#: The key of the function's unit in `units`, beside those of the coordinates.
FUNCTION = "f(s)"


@dataclass(frozen=True)
class Coupled:
    """The row Σ kᵢ sᵢ - function(s₀) = constant. `of` has the weights kᵢ by the names of the coordinates sᵢ, as
    "A.angle"; s₀ is the first.

    SI units and radians; the row is in its `unit`: m where a coordinate is a length, else rad. Without a constant the
    sum keeps its value at the scene's pose, or is 0 where there is a function. Whole turns of the angles may change the
    sum by multiples of `period`; None: it follows from the weights and the function. `units` are those in which the
    scene gives the weights, by coordinate, the constant, by "", and the function, by `FUNCTION`; "" for none."""

    of: Annotated[Mapping[str, float], Quantity("{0.unit}/coordinate")]
    function: Annotated[Program | None, Quantity("{0.unit}")] = None
    constant: Annotated[float | None, Quantity("{0.unit}")] = None
    period: Annotated[float | None, Quantity("{0.unit}")] = None
    unit: str = "rad"
    units: Mapping[str, str] = field(default_factory=dict, repr=False, compare=False)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joint of each coordinate."""
        return tuple(name.partition(".")[0] for name in self.of)

    @property
    def coordinate(self) -> str:
        """The name of s₀."""
        return next(iter(self.of))


# --- The appearance of bodies, as frozen records ----------------------------------------------------------------------
# It has no effect on the motion.


#: Colours by name: those of the figures (Okabe & Ito, 2008: told apart by colour-blind readers too), and metals.
COLOURS: Mapping[str, str] = MappingProxyType(
    {
        "blue": "#0072b2",
        "orange": "#e69f00",
        "green": "#009e73",
        "vermilion": "#d55e00",
        "sky": "#56b4e9",
        "purple": "#cc79a7",
        "yellow": "#f0e442",
        "black": "#222222",
        "grey": "#8a8f98",
        "steel": "#9aa5b1",
        "brass": "#b8963e",
        "red": "#c23b22",
        "white": "#f4f4f4",
    }
)
#: Meshes that can be read, by the ending of the file.
MESH_FORMATS = ("stl", "obj")


@dataclass(frozen=True)
class PlacedShape:
    """A shape of `mbproj.scene.blocks.solids`, with its dimensions by name in m. A shape with a length has it along its
    own `axis`. `position` in m is that of its middle from the body's centre of mass. It is turned against the body axes
    by `orientation` (Euler parameters)."""

    kind: str
    sizes: Annotated[Mapping[str, float], LENGTH]
    axis: str = "z"
    position: Annotated[Vector, LENGTH] = (0.0, 0.0, 0.0)
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class MeshFile:
    """A mesh in a file, by its path from the scene's folder. Its numbers times `scale` are metres. `position` and
    `orientation` are those of a `PlacedShape`."""

    file: str
    scale: Annotated[float, LENGTH] = 1.0
    position: Annotated[Vector, LENGTH] = (0.0, 0.0, 0.0)
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Appearance:
    """How a body is drawn: `colour` #rrggbb (None: the figure chooses one), `opacity` up to 1. `shapes` or a `mesh` are
    drawn in place of the shapes that give its mass."""

    colour: str | None = None
    opacity: float = 1.0
    shapes: tuple[PlacedShape, ...] = ()
    mesh: MeshFile | None = None
