"""The solid of a body that is given by homogeneous shapes: its mass, centre of mass and inertia tensor.

`SHAPE` and `SOLID` are the fields of the keys `shape` and `shapes`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.scene.appearance import PlacedShape
from mbproj.scene.fields import inertia, rotations
from mbproj.scene.fields.checks import inertia_of
from mbproj.scene.fields.containers import Complaint, OneOf, Record, Rule
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.orientation import ORIENTATION
from mbproj.scene.fields.quantities import LARGEST, POINT, Number
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import Matrix, Quaternion, Vector
from mbproj.scene.solids.shapes import A_SHAPE, SHAPE_FIELDS, Shape

_ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


@dataclass(frozen=True)
class SolidPart:
    """A shape of mass `mass` in kg with its centre of mass at `position` in m, its axes turned by `orientation`."""

    shape: Shape
    mass: float
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SolidBody:
    """A solid: mass in kg, centre of mass in m, the inertia tensor about it in kg m², in the common axes of `parts`."""

    mass: float
    centre: Vector
    inertia: Matrix
    parts: tuple[SolidPart, ...] = ()


def mass_of(shape: Shape, mass: float | None, density: float | None) -> float:
    """The mass as given, or the density times the volume of the shape. Raises Unfit where the product is no mass."""
    if mass is not None:
        return mass
    assert density is not None and shape.volume is not None
    return _possible(density * shape.volume)


def _possible(mass: float) -> float:
    if not 0.0 < mass <= LARGEST:
        raise Unfit(f"has a mass of {mass:g} kg", "look at the units of its dimensions and density")
    return mass


def alone(part: SolidPart) -> SolidBody:
    """The solid of one part, whose mass may be 0."""
    return SolidBody(part.mass, part.position, _tensor([part], part.position), (part,))


def together(parts: Iterable[SolidPart]) -> SolidBody:
    """The solid of several parts, each of which has a mass; where they overlap the masses add.

    Raises Unfit where its mass or its moments are no finite numbers.
    """
    parts = tuple(parts)
    mass = _possible(sum(part.mass for part in parts))
    x, y, z = (sum(part.mass * part.position[i] for part in parts) / mass for i in range(3))
    return SolidBody(mass, (x, y, z), _tensor(parts, (x, y, z)), parts)


def _tensor(parts: Iterable[SolidPart], centre: Vector) -> Matrix:
    """The inertia tensor about `centre`: J = tr(S) I - S, S = ∫ x xᵀ dm, from each part's own by Steiner's theorem."""
    second = dict.fromkeys(_ELEMENTS, 0.0)
    for part in parts:
        axes = rotations.to_matrix(part.orientation)
        arm = [at - middle for at, middle in zip(part.position, centre, strict=True)]
        for i, j in _ELEMENTS:
            own = sum(axes[i][k] * axes[j][k] * part.shape.spread[k] for k in range(3))
            second[i, j] += part.mass * (own + arm[i] * arm[j])
    xx, yy, zz, xy, xz, yz = second.values()
    if not all(abs(moment) <= LARGEST for moment in (*centre, *second.values(), xx + yy + zz)):
        raise Unfit("has moments of inertia that are too large", "look at the units of its dimensions")
    products = [0.0 - product for product in (xy, xz, yz)]  # never -0.0
    return inertia_of(inertia.from_elements([yy + zz, xx + zz, xx + yy, *products]))


DENSITY = Number("kg/m^3", above=0.0)


def has_volume(shape: Shape, density: float) -> Iterator[Complaint]:
    """A check that a shape with a density has a volume."""
    if shape.volume is None:
        yield Complaint(("density",), f"a {shape.kind} has no volume, so no density", "give its mass")


SHAPE: Record[Shape] = Record("a shape", SHAPE_FIELDS, lambda **given: next(iter(given.values())), choices=(A_SHAPE,))


def _part(given: dict[str, Any]) -> SolidPart:
    shape = next(given[kind] for kind in SHAPE_FIELDS if kind in given)
    place = {key: given[key] for key in ("position", "orientation") if key in given}
    return SolidPart(shape, mass_of(shape, given.get("mass"), given.get("density")), **place)


PART: Field[SolidPart] = Converted(
    Record(
        "a shape",
        {
            **SHAPE_FIELDS,
            "mass": Number("kg", above=0.0),
            "density": DENSITY,
            "position": POINT,
            "orientation": ORIENTATION,
        },
        dict,
        checks=tuple(Rule((kind, "density"), has_volume) for kind in SHAPE_FIELDS),
        choices=(A_SHAPE, OneOf(("mass", "density"), needed=True)),
    ),
    _part,
)

SOLID: Field[SolidBody] = Converted(List(PART, None, "shapes"), together)


def solid_of(given: Mapping[str, Any]) -> SolidBody:
    """The solid of a body's keys `shapes`, or `shape` with a mass or a density."""
    if "shapes" in given:
        solid: SolidBody = given["shapes"]
        return solid
    return alone(SolidPart(given["shape"], mass_of(given["shape"], given.get("mass"), given.get("density"))))


def drawn_shapes(solid: SolidBody) -> tuple[PlacedShape, ...]:
    """The shapes that are drawn for the parts of a solid, placed from its centre of mass."""
    shapes = []
    for part in solid.parts:
        x, y, z = (at - middle for at, middle in zip(part.position, solid.centre, strict=True))
        shapes.append(PlacedShape(part.shape.kind, part.shape.sizes, part.shape.axis, (x, y, z), part.orientation))
    return tuple(shapes)
