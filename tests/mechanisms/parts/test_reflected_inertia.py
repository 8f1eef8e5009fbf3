"""Reflected inertias ½ I s'² against exact motions, and against the geared flywheel that they stand for."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.errors import InputError
from tests.crossed import where
from tests.mechanisms.closed_forms import swinging
from tests.mechanisms.parts.flywheels import FLOATING, HEAD, PENDULUM
from tests.mechanisms.running import BRIEF, TIGHT, assert_close, run_text

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
GEARED = (
    HEAD
    + """
bodies:
  bar: {mass: mass, inertia: [0.1, own, 0.3], position: [arm * sin(start), 0, -arm * cos(start)],
        orientation: {axis: [0, 1, 0], angle: -start}}
FLYWHEEL
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0], INERTIA}
JOINTS
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: "3 * sin(4*t) - 0.2 * angle_dot"}
"""
)
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
CARRIAGE = (
    HEAD
    + """
bodies:
  carriage: {mass: CARRIAGE_MASS, inertia: [1, 1, 1], position: [0, 0, 0]}
  bar: {mass: mass, inertia: [0.1, own, 0.3], position: [arm * sin(start), 0, -arm * cos(start)],
        orientation: {axis: [0, 1, 0], angle: -start}}
FLYWHEEL
joints:
  rail: {type: prismatic, bodies: [ground, carriage], location: [0, 0, 0], axis: [1, 0, 0]}
  pin: {type: revolute, bodies: [carriage, bar], location: [0, 0, 0], axis: [0, -1, 0], INERTIA}
JOINTS
"""
)
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


MASS_ON_RAIL = (
    HEAD
    + """
bodies:
  block: {mass: mass, inertia: [1, 1, 1], position: [0.3, 0, 0]}
joints:
  rail: {type: JOINT, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0], INERTIA}
forces:
  spring: {type: linear_spring_damper, joint: rail, stiffness: 50, free_displacement: -0.3}
"""
)


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


MASSLESS = (
    HEAD
    + """
bodies:
  lever: {mass: 0, inertia: [0, 0, 0], position: [0.2, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, lever], location: [0, 0, 0], axis: [0, -1, 0], angle: 0.4,
        reflected_inertia: inertia}
forces:
  spring: {type: torsion_spring_damper, joint: pin, stiffness: 12}
"""
)


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


DOOR = (
    HEAD
    + """
bodies:
  door: {mass: 30, inertia: [10, 10, 1.6], position: [0.4 * cos(start), 0.4 * sin(start), 1],
         orientation: {axis: [0, 0, 1], angle: start}}
joints:
  low: {type: revolute, bodies: [ground, door], location: [0, 0, 0.2], axis: [0, 0, 1], speed: 1,
        reflected_inertia: 0.5}
  high: {type: revolute, bodies: [ground, door], location: [0, 0, 1.8], axis: [0, 0, 1], reflected_inertia: 0.2}
forces:
  closer: {type: torsion_spring_damper, joint: low, stiffness: 20}
"""
)


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
