"""What a constraint primitive is: a scalar or vector function of a few points and vectors fixed in two bodies."""

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
    number of `slots`. How x depends on the coordinates is not known here, so full, reduced and planar coordinates
    share this one definition. What a primitive needs beside x are the fields of its class; numbers among them are its
    `parameters`, each in an SI unit, and a joint gives them by these names. Differentiated twice along a motion x(t),

        C' = rate(x, x') = gradient(x)·x',    C'' = rate(x, x'') + curvature(x, x').

    A primitive that is not `integrable` has a gradient which is that of no function, as rolling without slip: ∂g/∂x is
    not symmetric, and the curvature does not tell it.
    """

    rows: ClassVar[int]
    integrable: ClassVar[bool] = True
    parameters: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @property
    @abstractmethod
    def slots(self) -> tuple[SlotKind, ...]:
        """What each point or vector is; most primitives have it as a constant."""

    @property
    @abstractmethod
    def unit(self) -> Literal["m", "rad"]:
        """The unit of the rows, likewise."""

    @abstractmethod
    def value(self, x: Numbers) -> Numbers:
        """C of shape (..., k, rows), in `unit`."""

    @abstractmethod
    def gradient(self, x: Numbers) -> Numbers:
        """∂C/∂x of shape (..., k, rows, s, 3)."""

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """gradient(x)·x' of shape (..., k, rows)."""
        terms: Numbers = self.gradient(x) * x_dot[..., None, :, :]
        return terms.sum(axis=(-2, -1))

    def forces(self, x: Numbers, multipliers: Numbers) -> Numbers:
        """gradient(x)ᵀλ of shape (..., k, s, 3), of multipliers (..., k, rows)."""
        terms: Numbers = self.gradient(x) * multipliers[..., None, None]
        return terms.sum(axis=-3)

    @abstractmethod
    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """x'ᵀ (∂²C/∂x²) x' of shape (..., k, rows)."""
