"""Mass, centre of mass and inertia tensor of a solid that is composed of homogeneous shapes."""

from __future__ import annotations

from collections.abc import Iterable

from mbproj.dataclass import dataclass
from mbproj.scene.fields import inertia, rotations
from mbproj.scene.fields.checks import inertia_of
from mbproj.scene.fields.quantities import LARGEST
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import Matrix, Quaternion, Vector
from mbproj.scene.solids.shapes import Shape

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
