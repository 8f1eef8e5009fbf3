"""Dry friction on coordinates of joints, as frozen records in SI units and radians."""

from __future__ import annotations

import math

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program


@dataclass(frozen=True)
class Bearing:
    """The bearing of a joint: how the joint's reaction presses the surfaces that slide.

    On an angle `radius` and `axial_radius` are the arms, in m, of the friction by the radial and by the axial force
    (None: that force causes none); on a screw without `axial_radius` the `radius` is that of its thread. `length` in m:
    the distance of two supports that moments load; infinite where moments do not count. `preload` in N: a radial force
    that is always there.
    """

    radius: float | None = None
    axial_radius: float | None = None
    length: float = math.inf
    preload: float = 0.0

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
    sliding: float | Program
    static: float | Program
    stribeck_speed: float | None = None
    regularised: float | None = None
    bearing: Bearing | None = None

    @property
    def varies(self) -> bool:
        """Whether a function makes the friction change during a run."""
        return isinstance(self.sliding, Program) or isinstance(self.static, Program)
