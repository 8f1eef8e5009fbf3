"""The base of constraint primitives: a scalar or vector function of a few points and vectors fixed in two bodies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, Literal

from mbproj.arrays import Numbers

SlotKind = Literal["point", "vector"]


class Primitive(ABC):
    """C(x) of the points and vectors x that it binds, its gradient, and its curvature along a motion.

    The arguments are the global points and vectors of k instances at once, `x` of shape (..., k, s, 3), where s is the
    number of `slots`. How x depends on the coordinates is not known here, so full, reduced and planar coordinates share
    this one definition. Data of a primitive beside x are the fields of its class. Fields that are numbers are its
    `parameters`, each in an SI unit; a joint's parameters have the same names. Differentiated twice along a motion
    x(t),

        C' = rate(x, x') = gradient(x)·x',    C'' = rate(x, x'') + curvature(x, x').


    The gradient g of a primitive that is not `integrable`, as in rolling without slip, is not the gradient of a
    function: ∂g/∂x is not symmetric, and does not follow from the curvature.
    """

    rows: ClassVar[int]
    #: The things beside points and vectors on which the primitive depends: a plane curve, two of them, a space curve, a
    #: rope, or coordinates.
    follows: ClassVar[Literal["", "curve", "two curves", "space curve", "rope", "coordinates"]] = ""
    integrable: ClassVar[bool] = True
    parameters: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @property
    @abstractmethod
    def slots(self) -> tuple[SlotKind, ...]:
        """The kind of each slot, point or vector; for most primitives a constant."""

    @property
    @abstractmethod
    def unit(self) -> Literal["m", "rad"]:
        """The unit of the rows; for most primitives a constant."""

    @abstractmethod
    def value(self, x: Numbers) -> Numbers:
        """Return C, shape (..., k, rows), in `unit`."""

    @abstractmethod
    def gradient(self, x: Numbers) -> Numbers:
        """Return ∂C/∂x, shape (..., k, rows, s, 3)."""

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return gradient(x)·x', shape (..., k, rows)."""
        terms: Numbers = self.gradient(x) * x_dot[..., None, :, :]
        return terms.sum(axis=(-2, -1))

    def forces(self, x: Numbers, multipliers: Numbers) -> Numbers:
        """Return gradient(x)ᵀλ, shape (..., k, s, 3), for multipliers (..., k, rows)."""
        terms: Numbers = self.gradient(x) * multipliers[..., None, None]
        return terms.sum(axis=-3)

    @abstractmethod
    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return x'ᵀ (∂²C/∂x²) x', shape (..., k, rows)."""
