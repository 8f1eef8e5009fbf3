"""What a constraint primitive is: a scalar or vector function of a few points and vectors fixed in two bodies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Literal

from mbproj.arrays import Numbers

SlotKind = Literal["point", "vector"]


class Primitive(ABC):
    """C(x) of the points and vectors x that it binds, its gradient, and its curvature along a motion.

    The arguments are the global points and vectors of k instances at once, `x` of shape (..., k, s, 3), where s is the
    number of `slots`. How x depends on the coordinates is not known here, so full, reduced and planar coordinates
    share this one definition. `parameters` names what a primitive needs beside x (a pitch, numbers of teeth): the
    fields of its class. Differentiated twice along a motion x(t),

        C' = rate(x, x') = gradient(x)·x',    C'' = rate(x, x'') + curvature(x, x').
    """

    slots: ClassVar[tuple[SlotKind, ...]]
    rows: ClassVar[int]
    unit: ClassVar[Literal["m", "rad"]]
    parameters: ClassVar[tuple[str, ...]] = ()

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
