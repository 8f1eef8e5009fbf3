"""Reflected inertias ½ I s'²: exact motions, the geared flywheel that they stand for, loops and equations."""

from __future__ import annotations

import re

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.energy import kinetic_energy
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.equations.of_motion import mass_matrix, tangent_mass_matrix
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.formulations.reduced import space_acceleration
from mbproj.scene.scene import read_scene_text
from mbproj.studies.verify.checks import verify
from tests.crossed import where
from tests.kernel.scenes import needs_kernel, opened, tree
from tests.mechanisms.closed_forms import swinging
from tests.mechanisms.running import BRIEF, TIGHT, Run, assert_close, run_text
from tests.support import assembled, with_flywheels

# Scenes with reflected inertias that several tests share.

HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {inertia: 0.7, start: 40 deg, arm: 0.5, mass: 2, own: 0.3}
simulation: {duration: 1.2, step: 2 ms, output_step: 40 ms}
"""


def under_gravity(text: str) -> str:
    """The scene with these bodies and joints."""
    return HEAD + text


PENDULUM = under_gravity("""
bodies:
  bar: {mass: mass, inertia: [0.1, own, 0.3], position: [arm * sin(start), 0, -arm * cos(start)],
        orientation: {axis: [0, 1, 0], angle: -start}}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0], angle: 0,
        reflected_inertia: inertia}
""")
#: A floating tree with everything that has a coordinate.
FLOATING = (
    HEAD.replace("-9.81", "0")
    + """
bodies:
  a: {mass: 2, inertia: [0.2, 0.3, 0.4], position: [0, 0, 0], angular_velocity: [0.3, -0.2, 0.5]}
  b: {mass: 1, inertia: [0.1, 0.1, 0.05], position: [0.6, 0.1, 0]}
  c: {mass: 1.5, inertia: [0.2, 0.1, 0.15], position: [0, 0.7, 0.2]}
  d: {mass: 0.5, inertia: [0.02, 0.03, 0.02], position: [0.9, 0.3, 0.4]}
joints:
  hand: {type: universal, bodies: [a, b], location: [0.3, 0, 0], axes: [[0, 1, 0], [0, 0, 1]],
         reflected_inertia: {angle_1: 0.4, angle_2: 0.1}, speed: {angle_1: 2, angle_2: -1}}
  rod: {type: cylindrical, bodies: [a, c], location: [0, 0.3, 0.1], axis: [0.2, 1, 0],
        reflected_inertia: {angle: 0.05, displacement: 3}, speed: {angle: 3, displacement: 0.4}}
  desk: {type: planar, bodies: [b, d], location: [0.8, 0.2, 0.2], axis: [1, 0, 1],
         reflected_inertia: {displacement_x: 0.7, displacement_y: 0.7, angle: 0.02},
        speed: {displacement_y: 0.3, angle: 2}}
"""
)


# Reflected inertias ½ I s'² against exact motions, and against the geared flywheel that they stand for.

#: Per formulation: the full one takes some milliseconds a step.
FORMULATIONS = list(BRIEF)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_flywheel_pendulum_swings_as_one_with_so_much_more_inertia(formulation):
    """(J + m a² + I) θ'' = -m g a sin θ, and the torque on the pin's coordinate is -I θ''."""
    done = run_text(PENDULUM, **BRIEF[formulation], formulation=formulation)
    p = done.parameters
    weight = p["mass"] * 9.81 * p["arm"]
    whole = p["own"] + p["mass"] * p["arm"] ** 2 + p["inertia"]
    angle, speed = swinging(p["start"], np.sqrt(weight / whole), done["time"])
    assert_close(p["start"] + done.column("joints/coordinate", "pin.angle"), angle, 1e-10)
    assert_close(done.column("joints/speed", "pin.angle"), speed, 1e-10)
    torque = done.column("forces/force", "pin.angle.inertia")
    assert_close(torque, p["inertia"] * weight / whole * np.sin(angle), 1e-9)
    shown = done.column("forces/coordinate", "pin.angle.inertia")
    assert_close(shown, done.column("joints/coordinate", "pin.angle"), 0.0)
    kinetic = 0.5 * whole * speed**2
    assert_close(done["diagnostics/kinetic_energy"], kinetic, 1e-9)
    assert_close(done["diagnostics/energy_balance"], 0.0, 1e-10)


#: A motor on the ground whose gear of 5 : 1 turns a flywheel, and drives an arm out of balance.
GEARED = under_gravity("""
bodies:
  bar: {mass: mass, inertia: [0.1, own, 0.3], position: [arm * sin(start), 0, -arm * cos(start)],
        orientation: {axis: [0, 1, 0], angle: -start}}
FLYWHEEL
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0], INERTIA}
JOINTS
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: "3 * sin(4*t) - 0.2 * angle_dot"}
""")
EXPLICIT = (
    GEARED.replace("INERTIA", "angle: 0")
    .replace("FLYWHEEL", "  wheel: {mass: 4, inertia: [0.015, 0.028, 0.015], position: [2, 0, 1]}")
    .replace(
        "JOINTS",
        """
  shaft: {type: revolute, bodies: [ground, wheel], location: [2, 0, 1], axis: [0, -1, 0], angle: 0}
  gear: {type: gear, joints: [pin, shaft], teeth: [100, 20]}""",
    )
)
REFLECTED = GEARED.replace("INERTIA", "reflected_inertia: 0.028 * 5**2").replace("FLYWHEEL", "").replace("JOINTS", "")


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS))
def test_a_geared_flywheel_is_its_inertia_times_the_square_of_the_ratio(formulation):
    """The same motion as with the wheel and its gear as bodies; the gear's torque is the flywheel's times the ratio."""
    one, other = (run_text(text, **BRIEF[formulation], formulation=formulation) for text in (REFLECTED, EXPLICIT))
    for path in ("bodies/position", "bodies/velocity", "bodies/acceleration"):
        assert_close(one.column(path, "bar"), other.column(path, "bar"), 1e-9)
    assert_close(one["diagnostics/kinetic_energy"], other["diagnostics/kinetic_energy"], 1e-9)
    assert_close(one["diagnostics/work"], other["diagnostics/work"], 1e-9)
    assert_close(one["diagnostics/dissipation"], other["diagnostics/dissipation"], 1e-9)
    spin_up = other.column("bodies/angular_acceleration", "wheel")[:, 1]
    assert_close(np.abs(one.column("forces/force", "pin.angle.inertia")), 5.0 * 0.028 * np.abs(spin_up), 1e-8)
    assert_close(one.column("joints/reaction_force", "pin"), other.column("joints/reaction_force", "pin"), 1e-8)


#: A joint between two bodies that move: a carriage that slides, and an arm on it, which turns a flywheel there.
CARRIAGE = under_gravity("""
bodies:
  carriage: {mass: CARRIAGE_MASS, inertia: [1, 1, 1], position: [0, 0, 0]}
  bar: {mass: mass, inertia: [0.1, own, 0.3], position: [arm * sin(start), 0, -arm * cos(start)],
        orientation: {axis: [0, 1, 0], angle: -start}}
FLYWHEEL
joints:
  rail: {type: prismatic, bodies: [ground, carriage], location: [0, 0, 0], axis: [1, 0, 0]}
  pin: {type: revolute, bodies: [carriage, bar], location: [0, 0, 0], axis: [0, -1, 0], INERTIA}
JOINTS
""")
ON_BOARD = (
    CARRIAGE.replace("CARRIAGE_MASS", "3")
    .replace("INERTIA", "angle: 0")
    .replace("FLYWHEEL", "  wheel: {mass: 4, inertia: [0.015, 0.028, 0.015], position: [0.3, 0, 0.2]}")
    .replace(
        "JOINTS",
        """
  shaft: {type: revolute, bodies: [carriage, wheel], location: [0.3, 0, 0.2], axis: [0, -1, 0], angle: 0}
  gear: {type: gear, joints: [pin, shaft], teeth: [100, -20]}""",
    )
)


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS))
def test_a_flywheel_between_two_moving_bodies_is_one_on_board(formulation):
    """Its mass is then the carriage's."""
    reflected = CARRIAGE.replace("CARRIAGE_MASS", "7").replace("INERTIA", "reflected_inertia: 0.7")
    reflected = reflected.replace("FLYWHEEL", "").replace("JOINTS", "")
    one, other = (run_text(text, **BRIEF[formulation], formulation=formulation) for text in (reflected, ON_BOARD))
    for body in ("carriage", "bar"):
        assert_close(one.column("bodies/position", body), other.column("bodies/position", body), 1e-9)
        assert_close(one.column("bodies/acceleration", body), other.column("bodies/acceleration", body), 1e-8)


MASS_ON_RAIL = under_gravity("""
bodies:
  block: {mass: mass, inertia: [1, 1, 1], position: [0.3, 0, 0]}
joints:
  rail: {type: JOINT, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0], INERTIA}
forces:
  spring: {type: linear_spring_damper, joint: rail, stiffness: 50, free_displacement: -0.3}
""")


#: A body in a cylindrical joint turns out of every plane.
ON_RAILS = [(name, "prismatic", "6") for name in FORMULATIONS]
ON_RAILS += [(name, "cylindrical", "{displacement: 6}") for name in FORMULATIONS if name != "planar"]


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("formulation", "joint", "inertia"), ON_RAILS)
def test_a_displacement_has_a_reflected_mass(formulation, joint, inertia):
    """(m + I) x'' = -k x."""
    text = MASS_ON_RAIL.replace("JOINT", joint).replace("INERTIA", f"reflected_inertia: {inertia}")
    done = run_text(text, **BRIEF[formulation], formulation=formulation)
    exact = 0.3 * np.cos(np.sqrt(50 / (2 + 6)) * done["time"])
    assert_close(done.column("bodies/position", "block")[:, 0], exact, 1e-10)


MASSLESS = under_gravity("""
bodies:
  lever: {mass: 0, inertia: [0, 0, 0], position: [0.2, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, lever], location: [0, 0, 0], axis: [0, -1, 0], angle: 0.4,
        reflected_inertia: inertia}
forces:
  spring: {type: torsion_spring_damper, joint: pin, stiffness: 12}
""")


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS))
def test_a_body_without_mass_is_carried_by_a_reflected_inertia_alone(formulation):
    """I θ'' = -k θ; without the inertia nothing that moves has mass, and the scene is refused (Eq. 20)."""
    done = run_text(MASSLESS, **BRIEF[formulation], formulation=formulation)
    exact = 0.4 * np.cos(np.sqrt(12 / 0.7) * done["time"])
    assert_close(done.column("joints/coordinate", "pin.angle"), exact, 1e-9)
    with pytest.raises(InputError, match="moves no mass"):
        run_text(MASSLESS, {"inertia": 0}, **BRIEF[formulation], formulation=formulation)


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS))
def test_a_motion_takes_the_torque_of_the_flywheel_too(formulation):
    """With θ = start + 0.5 sin 3t prescribed: J θ'' + m g a sin θ, and I θ'' more."""
    driven = PENDULUM + "motions:\n  drive: {joint: pin, angle: 0.5 * sin(3*t)}\n"
    how = {**BRIEF[formulation], "formulation": formulation, "kinematic": str(formulation != "full").lower()}
    with_it, without = (run_text(driven, {"inertia": inertia}, **how) for inertia in (0.7, 0.0))
    t = with_it["time"]
    torque = [done.column("motions/force", "drive") for done in (with_it, without)]
    assert_close(torque[0] - torque[1], 0.7 * -4.5 * np.sin(3 * t), 1e-9)
    assert_close(with_it["diagnostics/energy_balance"], 0.0, 1e-9)
    assert not without.system.reflected.size


DOOR = under_gravity("""
bodies:
  door: {mass: 30, inertia: [10, 10, 1.6], position: [0.4 * cos(start), 0.4 * sin(start), 1],
         orientation: {axis: [0, 0, 1], angle: start}}
joints:
  low: {type: revolute, bodies: [ground, door], location: [0, 0, 0.2], axis: [0, 0, 1], speed: 1,
        reflected_inertia: 0.5}
  high: {type: revolute, bodies: [ground, door], location: [0, 0, 1.8], axis: [0, 0, 1], reflected_inertia: 0.2}
forces:
  closer: {type: torsion_spring_damper, joint: low, stiffness: 20}
""")


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", FORMULATIONS))
def test_redundant_joints_add_their_inertias(formulation):
    """Both hinges turn alike: (J + m a² + 0.5 + 0.2) θ'' = -k θ; what the hinges bear does not depend on them."""
    done = run_text(DOOR, **BRIEF[formulation], formulation=formulation)
    assert done.report.redundant_rows > 0
    rate = np.sqrt(20 / (1.6 + 30 * 0.4**2 + 0.7))
    assert_close(done.column("joints/coordinate", "low.angle"), np.sin(rate * done["time"]) / rate, 1e-9)
    force = sum(done.column("joints/reaction_force", hinge) for hinge in ("low", "high"))
    weight = 30 * np.array([0, 0, -9.81])
    assert_close(force, 30 * done.column("bodies/acceleration", "door") - weight, 1e-8)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_energy_and_momentum_of_a_floating_tree_are_kept(formulation):
    """What the flywheels do to one body, they do to the other the other way round."""
    done = run_text(
        FLOATING, **(TIGHT | {"duration": 1} if formulation == "reduced" else BRIEF["full"]), formulation=formulation
    )
    assert_close(done["diagnostics/energy_balance"], 0.0, 1e-9 * done["diagnostics/kinetic_energy"][0])
    mass = np.array([body.mass for body in done.scene.bodies])
    push = np.einsum("b,tbi->ti", mass, done["bodies/velocity"])
    turn = np.einsum("b,tbi->ti", mass, np.cross(done["bodies/position"], done["bodies/velocity"]))
    for body in done.scene.bodies:
        spin = done.column("bodies/angular_velocity", body.name) @ np.array(body.inertia)
        turn = turn + np.einsum("tij,tj->ti", done.rotation(body.name), spin)
    assert_close(push, push[0], 1e-10)
    assert_close(turn, turn[0], 1e-9)
    assert len(done.system.names.forces) == 7


# Reflected inertias in loops and in the equations: formulations agree, checks hold, mistakes are named.

#: A four-bar with flywheels on all its pins, of spatial revolutes or regular in space.
LOOP = under_gravity("""
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.05, 0, 0.15]}
  rod: {mass: 2, inertia: [0.02, 0.1, 0.1], position: [0.4, 0, 0.4]}
  rocker: {mass: 1.5, inertia: [0.03, 0.03, 0.03], position: [0.65, 0, 0.2]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0], reflected_inertia: 0.3, speed: 4}
  B: {type: KIND, bodies: [crank, rod], location: [0.1, 0, 0.3], AXIS}
  C: {type: revolute, bodies: [rod, rocker], location: [0.7, 0, 0.5], axis: [0, 1, 0], reflected_inertia: 0.02}
  D: {type: revolute, bodies: [ground, rocker], location: [0.6, 0, -0.1], axis: [0, 1, 0], reflected_inertia: 5}
""")
PLANAR_LOOP = LOOP.replace("KIND", "revolute").replace("AXIS", "axis: [0, 1, 0], reflected_inertia: 0.1")
ON_A_BALL = LOOP.replace("KIND", "spherical").replace(", AXIS", "")


def one_formulation(text: str, formulation: str) -> Run:
    return run_text(text, formulation=formulation, step="5 ms", duration=0.05, output_step="5 ms")


@needs_kernel
@pytest.mark.parametrize("text", [PLANAR_LOOP, ON_A_BALL], ids=["redundant", "regular"])
def test_a_loop_moves_alike_in_every_formulation_and_keeps_its_energy(text):
    """At the start to round-off: accelerations, reactions and the torques of the flywheels."""
    full, *others = (one_formulation(text, name) for name in list(BRIEF)[::-1])
    for other in others:
        for path in ("bodies/acceleration", "joints/reaction_force", "joints/reaction_torque", "forces/force"):
            assert_close(other[path][0], full[path][0], 1e-11 * max(1.0, np.abs(full[path][0]).max()))
        assert_close(other["bodies/position"], full["bodies/position"], 1e-7)
    tight = run_text(text, **TIGHT)
    assert_close(tight["diagnostics/energy_balance"], 0.0, 1e-9)


def test_a_body_made_of_two_turns_its_flywheel():
    """Bodies that a fixed joint has made one: the pendulum with its bob as a body of its own, J and m a² as before."""
    bob = """
  bob: {mass: 0.5 * mass, inertia: [0.05, 0.5 * own, 0.15], position: [arm * sin(start), 0, -arm * cos(start)],
        orientation: {axis: [0, 1, 0], angle: -start}}
joints:
  weld: {type: fixed, bodies: [bar, bob], location: [0, 0, 0]}"""
    own = ("{mass: mass, inertia: [0.1, own, 0.3]", "{mass: 0.5 * mass, inertia: [0.05, 0.5 * own, 0.15]")
    halves = PENDULUM.replace(*own)
    whole, welded = (run_text(text, **TIGHT) for text in (PENDULUM, halves.replace("joints:", bob.strip("\n"), 1)))
    for path in ("joints/coordinate", "forces/force", "diagnostics/kinetic_energy"):
        assert_close(welded[path], whole[path], 1e-12)


@pytest.mark.parametrize("size", [1e-8, 1e6, 1e12])
@needs_kernel
def test_the_formulations_agree_on_inertias_far_from_the_bodies(size):
    """On a tree, where leaves turn them, with open joints: accelerations and multipliers."""
    case = opened(with_flywheels(tree(0), size))
    still = np.zeros(case.system.coordinates.size)
    state = State.of(case.system, 0.0, positions=case.q, velocities=case.v)
    equations = FullFormulation.of(case.system, state, Settings(duration=1.0, step=1.0, formulation="full"))
    y = equations.layout.vector_of({"positions": case.q, "velocities": case.v})
    full = equations.accelerations(0.0, y, still)
    acceleration, multipliers = case.reduced.equations().accelerations(case.y)
    assert case.reduced.equations().topology["core_bodies"] == 0
    found = space_acceleration(case.y[None], acceleration[None])[0]
    assert_close(found, full.acceleration, 1e-12 * np.abs(found).max())
    assert_close(multipliers, full.multipliers[case.system.bodies :], 1e-11 * np.abs(multipliers).max())


@pytest.mark.full
def test_everything_that_is_verified_holds_with_flywheels():
    """Among it units, order of the parts, balance of power and momentum, and the paper's identities for M with them."""
    for text in (FLOATING, ON_A_BALL):
        found = verify(read_scene_text(text))
        assert [(check.name, check.measured, check.allowed) for check in found.of("failed")] == []
        assert len(found.of("passed")) >= 13


def test_no_inertia_is_no_flywheel():
    """Bit for bit the scene without the key."""
    plain = PENDULUM.replace(",\n        reflected_inertia: inertia", "")
    assert plain != PENDULUM
    runs = [run_text(text, {"inertia": 0}, duration=0.1) for text in (plain, PENDULUM)]
    assert all(not done.system.reflected.size for done in runs)
    assert runs[0]["bodies/position"].tobytes() == runs[1]["bodies/position"].tobytes()


@pytest.mark.parametrize(
    "wrong, message",
    [
        ("reflected_inertia: -1", "'reflected_inertia' must be at least 0, found -1"),
        ("reflected_inertia: 1 kg", "'reflected_inertia' is in kg*m^2, this is a mass, in kg"),
        ("reflected_inertia: {displacement: 1}", "needs a number in kg*m^2, found a mapping"),
    ],
)
def test_what_is_no_inertia_is_an_error_at_its_place(wrong, message):
    with pytest.raises(InputError, match=re.escape(message)):
        read_scene_text(PENDULUM.replace("reflected_inertia: inertia", wrong))


def test_a_joint_without_coordinates_takes_none():
    with pytest.raises(InputError, match="a spherical joint has no 'reflected_inertia'"):
        read_scene_text(ON_A_BALL.replace("[0.1, 0, 0.3]", "[0.1, 0, 0.3], reflected_inertia: 1"))


def test_the_mass_matrix_is_that_of_the_kinetic_energy():
    """½ vᵀM v = T, at a state with |Λ| = 1."""
    system, state = assembled(read_scene_text(FLOATING))
    pose = pose_of(state.q)
    twist = twist_of(pose, state.v)
    energy = kinetic_energy(system, pose, twist)
    u = np.concatenate([twist.velocity, body_rates(pose, twist)], axis=1)[:-1].ravel()
    assert 0.5 * state.v @ mass_matrix(system, pose) @ state.v == pytest.approx(energy, rel=1e-13)
    assert 0.5 * u @ tangent_mass_matrix(system, pose) @ u == pytest.approx(energy, rel=1e-13)
