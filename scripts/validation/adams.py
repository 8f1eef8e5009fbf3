"""One joint each between a pendulum and the ground, by MSC Adams: Project Chrono's tests of joints."""

from __future__ import annotations

from collections.abc import Mapping

from .case import Case

COLUMNS: Mapping[str, str] = {
    **{axis: f"pendulum.position.{axis}" for axis in "xyz"},
    **{f"v{axis}": f"pendulum.velocity.{axis}" for axis in "xyz"},
    **{f"a{axis}": f"pendulum.acceleration.{axis}" for axis in "xyz"},
    **{f"e{k}": f"pendulum.orientation.e{k}" for k in range(4)},
    **{f"w{axis}": f"pendulum.global_angular_velocity.{axis}" for axis in "xyz"},
    **{f"al{axis}": f"pendulum.global_angular_acceleration.{axis}" for axis in "xyz"},
    **{f"F{axis}": f"A.force_on_first.{axis}" for axis in "xyz"},
    **{f"T{axis}": f"A.torque_on_first.{axis}" for axis in "xyz"},
}
RELATIVE = {
    "position": 1e-3,
    "velocity": 1e-3,
    "orientation": 1e-3,
    "global_angular_velocity": 1e-3,
    "acceleration": 1e-2,
    "global_angular_acceleration": 1e-2,
    "force_on_first": 1e-2,
    "torque_on_first": 1e-2,
}
NOTES = (
    "Compared over 5 s: place, velocity and acceleration of the centre of mass, Euler parameters, angular velocity and "
    "acceleration, and the reaction on the ground."
)
#: By name of the scene: number of the source's case, what it is, and the tolerances that its table deserves.
JOINTS: Mapping[str, tuple[str, str, Mapping[str, float]]] = {
    "adams_revolute": ("Revolute_Case01", "A pendulum on a revolute joint", {}),
    "adams_spherical": ("Spherical_Case02", "A pendulum on a spherical joint", {}),
    "adams_prismatic": ("Prismatic_Case02", "A body sliding down at 45 degrees on a prismatic joint", {}),
    "adams_cylindrical": ("Cylindrical_Case03", "A pendulum sliding on a cylindrical joint at 45 degrees", {}),
    "adams_distance": ("Distance_Case01", "A body on a massless rod (distance joint)", {"position": 2e-5}),
    "adams_universal": (
        "Universal_Case01",
        "A pendulum on a universal joint",
        {"position": 8.5e-4, "velocity": 3e-3, "force_on_first": 1.4e-2, "torque_on_first": 1e-2},
    ),
    "adams_universal_tilted": (
        "Universal_Case03",
        "A pendulum on a universal joint, released in a general position",
        {"position": 8.5e-4, "velocity": 3e-3, "force_on_first": 1.4e-2, "torque_on_first": 1e-2},
    ),
}
SIMULATION = {"duration": "5 s", "tolerance": "1.0e-9", "integrator": "dop853", "output_step": "50 ms"}
#: Baumgarte's feedback lets round-off grow up to the tolerance. What does not turn is compared to 1e-8 rad/s², the
#: tolerance times the square of its gains.
OF_OTHER_METHODS: Mapping[str, Mapping[str, str]] = {"adams_prismatic": {"tolerance": "1e-11"}}

ADAMS = tuple(
    Case(
        name=name,
        title=f"{title} (MSC Adams)",
        source=f"adams/{source}",
        origin=f"MSC Adams: {source} of Project Chrono's tests of joints (BSD-3-Clause)",
        notes=f"{title}, computed with MSC Adams for Project Chrono's tests of joints ({source}). {NOTES}",
        columns=COLUMNS,
        simulation=SIMULATION,
        tolerances=tolerances,
        relative=RELATIVE,
        every=5,
        quick=OF_OTHER_METHODS.get(name, {}),
    )
    for name, (source, title, tolerances) in JOINTS.items()
)
