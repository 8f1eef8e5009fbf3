"""The results of one body, marker, joint or other item: the columns of the layout, in its order, by name."""

from __future__ import annotations

from collections.abc import Mapping

from mbproj.arrays import Array, Integers
from mbproj.dataclass import brief, dataclass

#: The kinds of items that act along a coordinate.
ACTING = ("forces", "motions", "stops", "frictions")


@dataclass(frozen=True)
class ShownPart:
    """The part of a file that a `Results` shows: its samples, and its columns by symbol of the layout."""

    samples: slice
    columns: Mapping[str, Integers]


@dataclass(frozen=True)
class BodyResults:
    """The motion of a body: arrays (T, 3), orientation (T, 4); units and frames as in the layout."""

    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array

    __repr__ = brief


@dataclass(frozen=True)
class MarkerResults:
    """The motion of a marker: arrays (T, 3) in global axes, in m, m/s, m/s²."""

    position: Array
    velocity: Array
    acceleration: Array

    __repr__ = brief


@dataclass(frozen=True)
class JointResults:
    """A joint: its violations (T), of all rows in m or rad, of rows in m, of rows in rad. Its reactions act on body 2,
    (T, 3) in N and N m, in global axes."""

    violation: Array
    violation_length: Array
    violation_angle: Array
    reaction_force: Array
    reaction_torque: Array

    __repr__ = brief


@dataclass(frozen=True)
class ForceResults:
    """A force: the coordinate (T) in m or rad along which it acts, its rate, and the force in N or torque in N m."""

    coordinate: Array
    rate: Array
    force: Array

    __repr__ = brief


@dataclass(frozen=True)
class MotionResults:
    """A motion: the joint coordinate as prescribed (T) in m or rad, its rate, and the driving force in N or torque in
    N m."""

    value: Array
    rate: Array
    force: Array

    __repr__ = brief


@dataclass(frozen=True)
class Stop:
    """A stop: the distance (T) of the mechanism from it in m or rad, its rate, and the push of the stop in N or N m."""

    gap: Array
    rate: Array
    force: Array

    __repr__ = brief


@dataclass(frozen=True)
class Friction:
    """A dry friction: the rate (T) of the coordinate that it resists in m/s or rad/s, and its force in N or torque in
    N m. Its state is 1 or -1 where it slides up or down, 0 where it sticks. Last comes its lost energy in J."""

    rate: Array
    force: Array
    state: Array
    dissipation: Array

    __repr__ = brief


@dataclass(frozen=True)
class Coordinate:
    """A joint coordinate: its value (T) in the `unit` rad or m, and its rate."""

    value: Array
    speed: Array
    unit: str

    __repr__ = brief


@dataclass(frozen=True)
class Over:
    """The abscissa of pictures in place of time: a joint coordinate with its unit, rad or m. `values` (T) are those of
    the axis: angles in degrees, `modulo` a turn if asked for; `rate` (T) is in rad/s or m/s."""

    name: str
    unit: str
    values: Array
    rate: Array
    modulo: bool

    __repr__ = brief
