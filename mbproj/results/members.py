"""What the results say of one body, marker, joint or coordinate: the columns of the layout in its order, by name."""

from __future__ import annotations

from collections.abc import Mapping

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass

#: The kinds of what acts along a coordinate.
ACTING = ("forces", "motions", "stops", "frictions")


@dataclass(frozen=True)
class View:
    """Which samples and, by symbol of the layout, which columns of the file a Results shows."""

    samples: slice
    columns: Mapping[str, Integers]


@dataclass(frozen=True)
class Body:
    """Arrays (T, 3), orientation (T, 4); units and frames as in the layout."""

    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array


@dataclass(frozen=True)
class Marker:
    """Arrays (T, 3) in global axes: m, m/s, m/s²."""

    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class Joint:
    """Violations (T) in m or rad, in m, in rad; reactions on body 2 (T, 3) in N and N m, global axes."""

    violation: Array
    violation_length: Array
    violation_angle: Array
    reaction_force: Array
    reaction_torque: Array


@dataclass(frozen=True)
class Force:
    """What a force acts along (T) in m or rad, its rate, and the force in N or torque in N m along it."""

    coordinate: Array
    rate: Array
    force: Array


@dataclass(frozen=True)
class Motion:
    """A joint coordinate as prescribed (T) in m or rad, its rate, and the driving force in N or torque in N m."""

    value: Array
    rate: Array
    force: Array


@dataclass(frozen=True)
class Stop:
    """How far a mechanism is from a stop (T) in m or rad, its rate, and how hard the stop pushes in N or N m."""

    gap: Array
    rate: Array
    force: Array


@dataclass(frozen=True)
class Friction:
    """The rate of what a dry friction resists (T) in m/s or rad/s, and its force in N or torque in N m along it. Its
    state is 1 or -1 where it slides up or down, 0 where it sticks. Last comes the energy that it has lost in J."""

    rate: Array
    force: Array
    state: Array
    dissipation: Array


@dataclass(frozen=True)
class Coordinate:
    """Value (T) in rad or m as `unit` says, and its rate."""

    value: Array
    speed: Array
    unit: str


@dataclass(frozen=True)
class Over:
    """What results are shown over in place of time: a joint coordinate, its unit rad or m, and its values (T) as an
    axis shows them: angles in degrees, `modulo` a turn where that is asked for; its rate (T) in rad/s or m/s."""

    name: str
    unit: str
    values: Array
    rate: Array
    modulo: bool
