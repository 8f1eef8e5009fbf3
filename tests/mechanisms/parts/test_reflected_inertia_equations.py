"""Reflected inertias in loops and in the equations: formulations agree, checks hold, mistakes are named."""

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
from tests.dynamics.linkages import assembled
from tests.kernel.scenes import needs_kernel, opened, tree
from tests.mechanisms.parts.flywheels import FLOATING, HEAD, PENDULUM
from tests.mechanisms.running import BRIEF, TIGHT, Run, assert_close, run_text
from tests.support import with_flywheels

#: A four-bar with flywheels on all its pins, of spatial revolutes or regular in space.
LOOP = (
    HEAD
    + """
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.05, 0, 0.15]}
  rod: {mass: 2, inertia: [0.02, 0.1, 0.1], position: [0.4, 0, 0.4]}
  rocker: {mass: 1.5, inertia: [0.03, 0.03, 0.03], position: [0.65, 0, 0.2]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0], reflected_inertia: 0.3, speed: 4}
  B: {type: KIND, bodies: [crank, rod], location: [0.1, 0, 0.3], AXIS}
  C: {type: revolute, bodies: [rod, rocker], location: [0.7, 0, 0.5], axis: [0, 1, 0], reflected_inertia: 0.02}
  D: {type: revolute, bodies: [ground, rocker], location: [0.6, 0, -0.1], axis: [0, 1, 0], reflected_inertia: 5}
"""
)
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
