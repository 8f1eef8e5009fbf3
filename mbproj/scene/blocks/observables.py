"""The quantities that a run records and an expectation may be about, by name. Vectors are in the frames that
`mbproj.results.layout` gives."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.passages import RATIOS, TRANSMISSION_ANGLE


class Observable(NamedTuple):
    """The SI unit of a quantity and the number of its components. "A or B" is the unit A on an angle, and B on a
    length."""

    unit: str
    components: int = 1

    def unit_with(self, coordinate: str) -> str:
        """The unit of the quantity on a coordinate in "rad" or "m"."""
        angle, _, length = self.unit.partition(" or ")
        return length if length and coordinate == "m" else angle


#: The most wheels that a rope may turn: the room in the kernel's arrays.
MOST_WHEELS = 5
#: The tension of a portion of a rope; the number of the portion, from 1, follows.
TENSION = "tension_"
#: The point where a joint touches its curve.
CONTACT = "contact"
_OF_JOINT_COORDINATES = {
    **{name: Observable(unit) for name, unit in COORDINATES.items()},
    **{f"{name}_speed": Observable(f"{unit}/s") for name, unit in COORDINATES.items()},
    **{f"{name}{ratio}": Observable("") for ratio in RATIOS for name in COORDINATES},
}
#: The quantities by the kind of item. A joint has those of its own coordinates only.
OBSERVABLES: Mapping[str, Mapping[str, Observable]] = MappingProxyType(
    {
        "marker": {
            "position": Observable("m", 3),
            "velocity": Observable("m/s", 3),
            "acceleration": Observable("m/s^2", 3),
            TRANSMISSION_ANGLE: Observable("rad"),
        },
        "body": {
            "position": Observable("m", 3),
            "orientation": Observable("", 4),
            "velocity": Observable("m/s", 3),
            "angular_velocity": Observable("rad/s", 3),
            "acceleration": Observable("m/s^2", 3),
            "angular_acceleration": Observable("rad/s^2", 3),
        },
        "joint": {
            **_OF_JOINT_COORDINATES,
            **{f"{TENSION}{number}": Observable("N") for number in range(1, MOST_WHEELS + 2)},
            CONTACT: Observable("m", 3),
            "reaction_force": Observable("N", 3),
            "reaction_torque": Observable("N*m", 3),
            "violation": Observable(""),
            "violation_length": Observable("m"),
            "violation_angle": Observable("rad"),
        },
        "force": {
            "coordinate": Observable("rad or m"),
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
        },
        "motion": {
            "value": Observable("rad or m"),
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
        },
        "stop": {
            "gap": Observable("rad or m"),
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
        },
        "friction": {
            "rate": Observable("rad/s or m/s"),
            "force": Observable("N*m or N"),
            "state": Observable(""),
            "dissipation": Observable("J"),
        },
        "state": {"value": Observable("")},
        "signal": {"value": Observable("")},
        "diagnostic": {
            "position_violation": Observable(""),
            "velocity_violation": Observable(""),
            "acceleration_violation": Observable(""),
            "kinetic_energy": Observable("J"),
            "potential_energy": Observable("J"),
            "total_energy": Observable("J"),
            "work": Observable("J"),
            "dissipation": Observable("J"),
            "energy_balance": Observable("J"),
            "energy_drift": Observable("J"),
            "energy_drift_relative": Observable(""),
            "step_size": Observable("s"),
            "steps": Observable(""),
            "rejected_steps": Observable(""),
            "evaluations": Observable(""),
            "projections": Observable(""),
            "projection_iterations": Observable(""),
            "velocity_iterations": Observable(""),
            "projection_failures": Observable(""),
            "projection_fallbacks": Observable(""),
            "factorisations": Observable(""),
        },
    }
)
#: The quantities of bushings, in the axes of the frame midway between their two frames.
OF_BUSHINGS: Mapping[str, Observable] = MappingProxyType(
    {
        "translation": Observable("m", 3),
        "rotation": Observable("rad", 3),
        "translation_rate": Observable("m/s", 3),
        "rotation_rate": Observable("rad/s", 3),
        "force": Observable("N", 3),
        "torque": Observable("N*m", 3),
    }
)
#: The ways to make one number of a vector of three.
COMPONENTS = ("x", "y", "z", "norm")
#: Moments that are no time: where the quantity is largest, smallest, largest in magnitude; the last sample.
EXTREMES = ("maximum", "minimum", "largest", "range")
MOMENTS = ("end", *EXTREMES)
