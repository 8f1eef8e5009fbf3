"""Bodies without mass or without a moment of inertia, and motions without mass, in words."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from mbproj.base.errors import InputError
from mbproj.base.registry import PROJECTIONS
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import massless_motions, mobility, refuse_unsolvable, swamped_motions
from tests.crossed import full, once
from tests.dynamics import linkages
from tests.dynamics.linkages import scaled
from tests.mechanisms.closed_forms import piston, time_to_reach
from tests.mechanisms.running import TIGHT, Run, assert_close, global_angular_velocity, run, run_text
from tests.support import ROOT, assembled

# Bodies without mass, or without a moment of inertia about an axis, where the joints let no motion be without mass (Eq.
# 20): against the same mechanism without the body, and closed forms.

FORMULATIONS = ("reduced", "full")


COUPLER = (ROOT / "mechanisms" / "massless_coupler.yaml").read_text(encoding="utf-8")
#: With revolutes alone, for the plane.
PINNED = COUPLER.replace("type: point_on_line", "type: revolute")
#: Without the rod: its ends a fixed distance apart.
ROD, PISTON = COUPLER.index("  rod:\n    mass"), COUPLER.index("  piston:\n    mass")
DISTANCE = (
    COUPLER[:ROD]
    + COUPLER[PISTON : COUPLER.index("  B: {")]
    + (
        "  B: {type: distance, bodies: [crank, piston], locations: [[crank * cos(start), 0, crank * sin(start)],"
        " [crank * cos(start) + rod * cos(lean), 0, 0]]}\n"
    )
    + COUPLER[COUPLER.index("  D: {") :].replace("  rod_centre: {body: rod, location: {rod: [0, 0, 0]}}\n", "")
)
SCENES = {"reduced": COUPLER, "planar": PINNED, "full": COUPLER}


@pytest.fixture(scope="module", params=SCENES)
def coupler(request) -> Run:
    settings = TIGHT if request.param != "full" else {"integrator": "dop853", "step": "10 ms"}
    return run_text(sized(SCENES[request.param], settings), formulation=request.param)


def sized(text: str, settings: dict, duration: str = "0.6 s", output_step: str = "20 ms") -> str:
    """The scene with other settings of its integration."""
    keys = {"duration": duration, "output_step": output_step, **settings}
    lines = [f"  {key}: {value}\n" for key, value in keys.items()]
    start, end = text.index("simulation:\n"), text.index("bodies:")
    return text[:start] + "simulation:\n" + "".join(lines) + text[end:]


def crank_angle(done: Run) -> np.ndarray:
    return done.parameters["start"] + done.column("joints/coordinate", "A.angle")


def test_the_piston_is_where_the_crank_has_it(coupler):
    θ, speed = crank_angle(coupler), coupler.column("joints/speed", "A.angle")
    s, slope, _ = piston(coupler, θ)
    assert θ[-1] > 2 * np.pi
    assert_close(coupler.column("bodies/position", "piston")[:, 0], s, 1e-12)
    assert_close(coupler.column("bodies/velocity", "piston")[:, 0], slope * speed, 1e-11)
    assert_close(coupler.column("bodies/position", "piston")[:, 1:], 0.0, 1e-12)


def test_the_crank_turns_as_its_energy_has_it(coupler):
    """½ (J + m s'²) θ'² + m_c g c sin θ = constant: no rod in it."""
    p, θ = coupler.parameters, crank_angle(coupler)
    moment = lambda at: p["flywheel"] + p["piston"] * float(piston(coupler, np.array(at))[1]) ** 2  # noqa: E731
    potential = lambda at: p["crank_mass"] * 9.81 * p["centre"] * np.sin(at)  # noqa: E731
    times = [time_to_reach(at, p["start"], p["speed"], moment, potential) for at in θ[5::5]]
    assert_close(times, coupler["time"][5::5], 1e-10)
    assert coupler.report.energy_drift_relative < 1e-10


def test_the_rod_bears_a_force_along_itself_alone(coupler):
    """m s'' / cos ψ, with sin ψ = r/l sin θ; in both of its pins, and no torque in the plane."""
    p, θ, speed = coupler.parameters, crank_angle(coupler), coupler.column("joints/speed", "A.angle")
    _, slope, bend = piston(coupler, θ)
    θ_acceleration = coupler.column("bodies/angular_acceleration", "crank")[:, 1] * -1.0
    along = np.sqrt(1 - (p["crank"] / p["rod"] * np.sin(θ)) ** 2)
    push = p["piston"] * (slope * θ_acceleration + bend * speed**2)
    exact = push[:, None] * np.stack([1 + 0 * θ, -p["crank"] / p["rod"] * np.sin(θ) / along], axis=1)
    assert_close(coupler.column("joints/reaction_force", "B")[:, [0, 2]], exact, 1e-8)
    sign = {"rod": 1.0, "piston": -1.0}[coupler.scene.joints[2].bodies[0]]
    assert_close(sign * coupler.column("joints/reaction_force", "C")[:, [0, 2]], exact, 1e-8)
    assert_close(coupler.column("joints/reaction_torque", "B")[:, 1], 0.0, 1e-9)


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_it_moves_as_with_a_distance_in_place_of_the_rod(formulation):
    with_rod = run_text(sized(SCENES[formulation], TIGHT), formulation=formulation)
    without = run_text(sized(DISTANCE, TIGHT))
    for name in ("crank", "piston"):
        assert_close(with_rod.column("bodies/position", name), without.column("bodies/position", name), 1e-10)
    assert_close(
        with_rod.column("joints/reaction_force", "A")[:, [0, 2]],
        without.column("joints/reaction_force", "A")[:, [0, 2]],
        1e-7,
    )


def test_a_light_rod_comes_to_it_in_proportion_to_its_mass():
    """The error of leaving the rod's mass out falls with the mass, tenfold for a tenth."""
    settings = {**TIGHT, "duration": "0.2 s", "output_step": "20 ms"}
    massless = run("massless_coupler", **settings, formulation="reduced")
    errors = [
        np.abs(crank_angle(run("massless_coupler", {"rod_mass": m}, **settings)) - crank_angle(massless)).max()
        for m in (1e-3, 1e-4, 1e-5)
    ]
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.05)


@pytest.mark.parametrize(
    ("formulation", "method"),
    [
        pytest.param(formulation, name, marks=[pytest.mark.full] * (formulation == "full" and name != "gpopm"))
        for formulation in FORMULATIONS
        for name, entry in PROJECTIONS.items()
        if entry.corrects and name != "popm" and (entry.compiled or formulation != "reduced")
    ],
)
def test_every_method_closes_the_massless_rod(formulation, method):
    settings = {"integrator": "rk4", "step": "1 ms"}
    done = run_text(sized(COUPLER, settings, "60 ms", "10 ms"), projection=method, formulation=formulation)
    assert_close(done.column("bodies/position", "piston")[:, 0], piston(done, crank_angle(done))[0], 1e-12)
    assert done.report.energy_drift_relative < 1e-7


def test_popm_refuses_a_singular_mass_matrix():
    with pytest.raises(InputError, match="popm"):
        run_text(COUPLER, projection="popm", duration="10 ms")


#: A bar on a universal joint, which is a joint or a massless cross on two pins.
CROSS = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 1 ms, output_step: 50 ms}
bodies:
  cross: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 0]}
  bar: {mass: 1, inertia: [0.08, 0.09, 0.01], position: [0, 0, -0.5]}
joints:
  first: {type: revolute, bodies: [ground, cross], location: [0, 0, 0], axis: [1, 0, 0], speed: 1}
  second: {type: revolute, bodies: [cross, bar], location: [0, 0, 0], axis: [0, 1, 0], speed: 2}
"""
UNIVERSAL = (
    CROSS[: CROSS.index("  cross:")]
    + CROSS[CROSS.index("  bar:") : CROSS.index("  first:")]
    + (
        "  both:\n    {type: universal, bodies: [ground, bar], location: [0, 0, 0], axes: [[1, 0, 0], [0, 1, 0]],"
        " speed: {angle_1: 1, angle_2: 2}}\n"
    )
)


@pytest.mark.parametrize("formulation", ["reduced", full("full")])
def test_a_massless_cross_is_a_universal_joint(formulation):
    """In a tree, which the kernel eliminates from its leaves."""
    duration = 1.0 if formulation == "reduced" else 0.2
    cross, joint = (run_text(text, formulation=formulation, duration=duration) for text in (CROSS, UNIVERSAL))
    assert cross.report.degrees_of_freedom == joint.report.degrees_of_freedom == 2
    assert_close(cross.column("bodies/position", "bar"), joint.column("bodies/position", "bar"), 1e-9)
    assert_close(cross.rotation("bar"), joint.rotation("bar"), 1e-9)
    angles = [cross.column("joints/coordinate", f"{name}.angle") for name in ("first", "second")]
    assert_close(angles, [joint.column("joints/coordinate", f"both.angle_{k}") for k in (1, 2)], 1e-9)
    assert_close(cross.column("joints/reaction_force", "second"), joint.column("joints/reaction_force", "both"), 1e-7)


HOOKE = (ROOT / "mechanisms" / "hooke_shaft.yaml").read_text(encoding="utf-8").partition("expect:")[0]
#: Hooke's joint as engineers build it: a cross between two forks, here without mass.
FORKS = HOOKE.replace("  block:\n", "  cross: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 0]}\n  block:\n").replace(
    "  hooke: {type: universal, bodies: [driving, driven], location: [0, 0, 0], axes: [[0, 1, 0], [0, 0, 1]]}\n",
    "  fork1: {type: revolute, bodies: [driving, cross], location: [0, 0, 0], axis: [0, 1, 0]}\n"
    "  fork2: {type: revolute, bodies: [cross, driven], location: [0, 0, 0], axis: [0, 0, 1]}\n",
)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_massless_cross_in_a_loop_transmits_as_hookes_formula_has_it(formulation):
    """ω2 = ω1 cos β / (1 - sin² β cos² φ1), and the times of the mechanism with a universal joint."""
    settings = TIGHT if formulation == "reduced" else {"integrator": "rk4", "step": "2 ms"}
    duration = "0.7 s" if formulation == "reduced" else "0.1 s"
    done = run_text(sized(FORKS, settings, duration, "20 ms"), formulation=formulation)
    φ, speed = (done.column(f"joints/{what}", "bearing.angle") for what in ("coordinate", "speed"))
    β = done.parameters["bend"]
    ω2 = global_angular_velocity(done, "driven") @ [np.cos(β), np.sin(β), 0.0]
    assert_close(ω2, speed * np.cos(β) / (1 - (np.sin(β) * np.cos(φ)) ** 2), 1e-11)
    joint = run_text(sized(HOOKE, settings, duration, "20 ms"), formulation=formulation)
    assert_close(φ, joint.column("joints/coordinate", "bearing.angle"), 1e-10)


#: A point mass on a string: no moment of inertia at all.
SIMPLE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 5, tolerance: 1.0e-12, integrator: dop853, output_step: 0.1}
bodies: {bob: {mass: 2, shape: {point: {}}, position: [1, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["reduced", "planar", "full"])
def test_a_point_mass_swings_as_the_simple_pendulum(formulation):
    """ψ = 2 asin(k sn(K - ω t)), k = sin 45°, from the horizontal; problem A01 of the IFToMM library has this body."""
    duration = 5 if formulation != "full" else 0.5
    done = run_text(SIMPLE, formulation=formulation, duration=duration)
    sn = ellipj(ellipk(0.5) - np.sqrt(9.81) * done["time"], 0.5)[0]
    ψ = 2 * np.arcsin(np.sqrt(0.5) * sn)
    assert_close(done.column("bodies/position", "bob")[:, [0, 2]], np.stack([np.sin(ψ), -np.cos(ψ)], axis=1), 1e-9)
    assert_close(done.column("joints/reaction_force", "pin")[:, 1], 0.0, 1e-9)
    tension = np.linalg.norm(done.column("joints/reaction_force", "pin"), axis=1)
    assert_close(tension, 3 * 2 * 9.81 * np.cos(ψ), 1e-7)


#: Where Eq. 20 fails, and whose motion it is that moves no mass.
FREE = {
    "a link beyond the last mass": (
        "bodies:\n  bar: {mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0]}\n"
        "  feather: {mass: 0, inertia: [0, 0, 0], position: [1.5, 0, 0]}\n"
        "joints:\n  A: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}\n"
        "  B: {type: revolute, bodies: [bar, feather], location: [1, 0, 0], axis: [0, 1, 0]}\n",
        "feather",
    ),
    "the spin of a rod between two balls": (
        "bodies:\n  bar: {mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0]}\n"
        "  rod: {mass: 0, inertia: [0, 0, 0], position: [1, 0, -0.5]}\n"
        "  slider: {mass: 1, inertia: [1, 1, 1], position: [1, 0, -1]}\n"
        "joints:\n  A: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}\n"
        "  B: {type: spherical, bodies: [bar, rod], location: [1, 0, 0]}\n"
        "  C: {type: spherical, bodies: [rod, slider], location: [1, 0, -1]}\n"
        "  D: {type: prismatic, bodies: [ground, slider], location: [1, 0, -1], axis: [0, 0, 1]}\n",
        "rod",
    ),
    "the turning of a point mass on a ball": (
        "bodies:\n  bob: {mass: 1, inertia: [0, 0, 0], position: [0, 0, -1]}\n"
        "joints:\n  A: {type: spherical, bodies: [ground, bob], location: [0, 0, 0]}\n",
        "bob",
    ),
    "a plate between two springs in a row": (
        "bodies:\n  plate: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 1]}\n"
        "  block: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 2]}\n"
        "joints:\n  A: {type: prismatic, bodies: [ground, plate], location: [0, 0, 1], axis: [0, 0, 1]}\n"
        "  B: {type: prismatic, bodies: [ground, block], location: [0, 0, 2], axis: [0, 0, 1]}\n"
        "forces:\n  low: {type: linear_spring_damper, joint: A, stiffness: 100, damping: 0}\n"
        "  high: {type: spring_damper, points: {plate: [0, 0, 1], block: [0, 0, 2]}, stiffness: 100, damping: 0}\n",
        "plate",
    ),
}


@pytest.mark.parametrize(("name", "formulation"), once([*FREE], ["auto", *FORMULATIONS]))
def test_a_motion_without_mass_is_refused_with_its_body(name, formulation):
    text, body = FREE[name]
    header = "mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {duration: 1, step: 0.01}\n"
    with pytest.raises(InputError, match=rf"moves no mass.*Eq\. 20.*'{body}'") as caught:
        run_text(header + text, formulation=formulation)
    others = {"bar", "feather", "rod", "slider", "bob", "plate", "block"} - {body}
    assert not any(f"'{other}'" in caught.value.problems[0].message for other in others)


def test_corrections_that_leave_a_massless_body_at_rest_are_no_singular_pose():
    """With steps this small the velocities are open by round-off, in the slider's rows alone at t = 0.128 s."""
    done = run_text(sized(COUPLER, {"step": "0.125 ms"}, "0.15 s", "10 ms"), formulation="planar")
    assert done.report.velocity_violation.value < 1e-13


# Motions without mass, in words.


def light_coupler(*kinds: str):
    """The four-bar with a coupler without mass, and these joints at its ends."""
    scene = linkages.four_bar()
    light = dataclasses.replace(scene.bodies[1], mass=0.0, inertia=((0.0,) * 3,) * 3)
    ends = [
        dataclasses.replace(joint, type=kind, axes=joint.axes if kind == "revolute" else None)
        for joint, kind in zip(scene.joints[1:3], kinds, strict=True)
    ]
    joints = (scene.joints[0], *ends, scene.joints[3])
    return dataclasses.replace(scene, bodies=(scene.bodies[0], light, scene.bodies[2]), joints=joints)


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("mass", [1e-6, 1e6])
def test_a_massless_coupler_on_two_balls_spins_about_their_line(length, mass):
    system, state = assembled(scaled(light_coupler("spherical", "spherical"), length, mass))
    (motion,) = massless_motions(system, pose_of(state.q))
    assert str(motion) == "'link2' turns about [0.949, 0, 0.316] through its centre of mass"
    with pytest.raises(InputError, match=r"a motion that moves no mass \(Eq. 20 does not hold\): 'link2' turns about"):
        refuse_unsolvable(system, mobility(system, pose_of(state.q)))


def test_on_a_revolute_joint_and_a_ball_it_is_legal():
    system, state = assembled(light_coupler("revolute", "spherical"))
    assert massless_motions(system, pose_of(state.q)) == ()


def test_a_rod_without_inertia_about_its_axis_spins_between_two_balls():
    scene = light_coupler("spherical", "spherical")
    axis = np.array([0.6, 0.0, 0.2]) / np.hypot(0.6, 0.2)
    inertia = 0.01 * (np.eye(3) - np.outer(axis, axis))
    rod = dataclasses.replace(scene.bodies[1], mass=1.0, inertia=tuple(tuple(row) for row in inertia.tolist()))
    system, state = assembled(dataclasses.replace(scene, bodies=(scene.bodies[0], rod, scene.bodies[2])))
    (motion,) = massless_motions(system, pose_of(state.q))
    assert str(motion) == "'link2' turns about [0.949, 0, 0.316] through its centre of mass"


def test_a_massless_body_on_a_ball_turns_about_three_axes_through_it():
    scene = linkages.door()
    leaf = dataclasses.replace(scene.bodies[0], mass=0.0, inertia=((0.0,) * 3,) * 3)
    ball = dataclasses.replace(scene.joints[0], type="spherical", axes=None)
    system, state = assembled(dataclasses.replace(scene, bodies=(leaf,), joints=(ball,)))
    motions = massless_motions(system, pose_of(state.q))
    assert sorted(str(motion) for motion in motions) == [
        "'door' turns about x through [0.5, 0, 0.2] m",
        "'door' turns about y through [0, 0, 0.2] m",
        "'door' turns about z through [0, 0, 1] m",
    ]


def test_a_massless_slide_shifts():
    scene = linkages.slider_crank(0.5, 0.7)
    slider = dataclasses.replace(scene.bodies[2], mass=0.0, inertia=((0.0,) * 3,) * 3)
    system, state = assembled(dataclasses.replace(scene, bodies=(slider,), joints=(scene.joints[3],)))
    assert [str(motion) for motion in massless_motions(system, pose_of(state.q))] == ["'slider' shifts along x"]


@pytest.mark.parametrize(("part", "swamped"), [(1e-12, 1), (1e-6, 0)])
def test_a_body_that_hardly_weighs_anything_is_ruled_by_round_off_where_it_moves_by_itself(part, swamped):
    """A coupler spins between two balls; held by a revolute joint it does what the others do, whatever it weighs;
    at the end of a tree no force but its own acts on it."""

    def motions(kinds, keep):
        scene = light_coupler(*kinds)
        inertia = tuple(tuple(part * float(i == k) for k in range(3)) for i in range(3))
        coupler = dataclasses.replace(scene.bodies[1], mass=part, inertia=inertia)
        bodies = (scene.bodies[0], coupler, scene.bodies[2])[: keep or 3]
        system, state = assembled(dataclasses.replace(scene, bodies=bodies, joints=scene.joints[: keep or 4]))
        return swamped_motions(system, pose_of(state.q))

    assert len(motions(("spherical", "spherical"), 0)) == swamped
    assert motions(("revolute", "spherical"), 0) == ()
    assert motions(("spherical", "spherical"), 2) == ()
