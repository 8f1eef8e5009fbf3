"""Linkages by Dymola: reference results of the Modelica Standard Library."""

from __future__ import annotations

from .case import Case

MODELS = "Modelica Standard Library"
SPHERICAL = {
    f"boxBody{4 + k}.body.{there}": f"b{k}.{here}"
    for k in (1, 2)
    for there, here in (
        *((f"Q[{n}]", f"orientation.e{n % 4}") for n in (1, 2, 3, 4)),
        *((f"w_a[{n}]", f"angular_velocity.{axis}") for n, axis in ((1, "x"), (2, "y"), (3, "z"))),
    )
}


def origin(model: str) -> str:
    """Where the reference results of a model stand."""
    return f"Dymola 2020x, DASSL at 1e-6: {model}, MAP-LIB_ReferenceResults v4.0.0"


DYMOLA = (
    Case(
        name="dymola_rssp",
        title="Spatial four-bar RSSP (Dymola)",
        source="dymola/Fourbar_analytic_RSSP",
        origin=origin("MultiBody.Examples.Loops.Fourbar_analytic"),
        notes=(
            f"The spatial four-bar of the {MODELS} (Fourbar_analytic): a crank on a revolute joint drives a slider "
            "through a massless rod with balls at its ends, which is one constraint of distance. Compared over 5 s: "
            "the crank's angle, over six and a half turns, and its speed."
        ),
        columns={"j1.phi": "A.angle", "j1.w": "A.speed"},
        simulation={"duration": "5 s", "tolerance": "1.0e-9", "integrator": "dop853", "output_step": "50 ms"},
        tolerances={"angle": 9e-4},
        relative={"speed": 1e-3},
        every=5,
        short=0.3,
    ),
    Case(
        name="dymola_spherical_double_pendulum",
        title="Double pendulum on balls (Dymola)",
        source="dymola/SphericalDoublePendulum",
        origin=origin("ModelicaTest.MultiBody.SphericalDoublePendulum"),
        notes=(
            f"Two boxes on balls (ModelicaTest SphericalDoublePendulum of the {MODELS}), started with a slow turn. "
            "Compared over 3 s: Euler parameters and angular velocities of both."
        ),
        columns=SPHERICAL,
        simulation={"duration": "3 s", "tolerance": "1.0e-9", "integrator": "dop853", "output_step": "0.6 ms"},
        tolerances={"orientation": 1e-4, "angular_velocity": 1e-3},
        grid=0.0006,
        every=5,
        short=0.3,
        quick={"output_step": "6 ms"},
    ),
    Case(
        name="dymola_universal_torque",
        title="A shaft on a universal joint under a torque (Dymola)",
        source="dymola/UniversalTorque",
        origin=origin("ModelicaTest.MultiBody.Joints.CheckConstaintTorqueUniversalJoint"),
        notes=(
            "A cylinder on a universal joint, turned by a constant torque in global axes (ModelicaTest "
            f"CheckConstaintTorqueUniversalJoint of the {MODELS}). Compared over 1 s: the joint's angles and speeds."
        ),
        columns={
            "universal.phi_a": "A.angle_1",
            "universal.phi_b": "A.angle_2",
            "universal.w_a": "A.speed_1",
            "universal.w_b": "A.speed_2",
        },
        simulation={"duration": "1 s", "tolerance": "1.0e-9", "integrator": "dop853", "output_step": "10 ms"},
        tolerances={"angle_1": 2e-5, "angle_2": 2e-5},
        relative={"speed_1": 1e-3, "speed_2": 1e-3},
        every=5,
        short=0.3,
    ),
    Case(
        name="dymola_pendulum",
        title="Damped pendulum (Dymola)",
        source="dymola/Pendulum_damped",
        origin=origin("MultiBody.Examples.Elementary.Pendulum"),
        notes=(
            f"A pendulum with a damper in its joint (MultiBody.Examples.Elementary.Pendulum of the {MODELS}). "
            "Compared over 5 s: the joint's angle and speed."
        ),
        columns={"rev.phi": "A.angle", "rev.w": "A.speed"},
        simulation={"duration": "5 s", "tolerance": "1.0e-9", "integrator": "dop853", "output_step": "50 ms"},
        tolerances={"angle": 5e-6},
        relative={"speed": 1e-3},
        every=5,
    ),
    Case(
        name="dymola_planar_four_bar",
        title="Planar four-bar of four revolutes, damped (Dymola)",
        source="dymola/PlanarFourbar_damped",
        origin=origin("MultiBody.Examples.Loops.PlanarFourbar"),
        notes=(
            "A planar loop of four revolutes with a damper in the first (MultiBody.Examples.Loops.PlanarFourbar of "
            f"the {MODELS}): in space three of its 20 joint rows are redundant, so that it takes planar coordinates. "
            "Where joint D is a point_on_line along z the motion is the same, and no row is redundant. Compared "
            "over 5 s: the damped joint's angle and speed."
        ),
        columns={"revolute1.phi": "A.angle", "revolute1.w": "A.speed"},
        simulation={"duration": "5 s", "tolerance": "1.0e-9", "integrator": "dop853", "output_step": "50 ms"},
        tolerances={"angle": 7e-4},
        relative={"speed": 1e-3},
        every=5,
        short=0.3,
        loops=("D",),
    ),
)
