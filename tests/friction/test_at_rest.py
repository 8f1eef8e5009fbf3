"""Equilibria and small motions with dry friction: what rests is held as it is, by no more than its static force."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.start import observed
from mbproj.linear.modes import modes, notes_on
from mbproj.linear.reference import held_at, reference_at
from mbproj.results.reader import open_results
from mbproj.studies.record import record_equilibrium
from tests.friction.scenes import BELT
from tests.support import ROOT, assembled

#: A double pendulum in a plane, its arms straight out, with brakes.
ARMS = """\
mbproj: 1
gravity: [0, 0, -10]
parameters: {shoulder: 40 N*m, speed: 0}
bodies:
  upper: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
  lower: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [3, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [0, 1, 0], speed: speed}
  B: {type: revolute, bodies: [upper, lower], location: [2, 0, 0], axis: [0, 1, 0]}
forces:
  brake: {type: friction, joint: A, coulomb: {torque: 1, static: shoulder}}
  BEARING
"""
#: The upper arm carries 20 N in all: 40 N m more at most.
BEARING = "bearing: {type: friction, joint: A, coulomb: {coefficient: 0.5, static: 2, radius: 1}}"


def started(text=ARMS, bearing="", **parameters):
    given = {name: str(value) for name, value in parameters.items()}
    return assembled(read_scene_text(text.replace("BEARING", bearing), parameters=given))


def test_a_brake_holds_while_the_rest_falls_into_place():
    """The lower arm hangs down, 2 m out; the weights of both turn the shoulder with 10 + 20 N m."""
    system, state = started()
    found = equilibrium(system, state)
    np.testing.assert_allclose(found.reference.motion.expected, [0.0, np.pi / 2.0], atol=1e-12)
    assert found.stable and found.frictions["brake"]["sticks"]
    assert found.frictions["brake"]["force"] == pytest.approx(-30.0, rel=1e-12)
    block = observed(found)
    assert block["friction/force"][0, 0] == pytest.approx(-30.0, rel=1e-12)
    assert block["friction/state"][0, 0] == 0.0
    assert block["joints/reaction_force"].shape == (1, 2, 3)
    np.testing.assert_allclose(block["joints/reaction_force"][0, :, 2], [20.0, 10.0], rtol=1e-12)
    np.testing.assert_allclose(block["joints/reaction_torque"][0, 0], 0.0, atol=1e-12)


#: A pendulum far above a rough floor.
ABOVE = """\
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 0.1, step: 1 ms}
bodies: {b: {mass: 1, inertia: [1, 1, 1], position: [0, 0, -1]}}
joints: {p: {type: revolute, bodies: [ground, b], location: [0, 0, 0], axis: [0, 1, 0]}}
forces:
  floor:
    {type: stop, plane: {body: ground, location: [0, 0, -8], normal: [0, 0, 1]}, point: {body: b, location: [0, 0, -2]},
     rigid: true, friction: 0.4}
"""


def test_a_friction_in_a_plane_has_a_force_in_each_direction_though_nothing_touches(tmp_path):
    scene = read_scene_text(ABOVE)
    found = equilibrium(*assembled(scene))
    record_equilibrium(scene, tmp_path / "equilibrium.h5", found, {})
    with open_results(tmp_path / "equilibrium.h5") as results:
        assert results["friction/force"].tolist() == [[0.0, 0.0]]
    assert not found.frictions["floor"]["sticks"]


def test_modes_leave_held_joints_where_they_are():
    """The lower arm swings alone: ω² = m g r / (I + m r²), the wall's joint does not move."""
    system, state = started()
    found = modes(equilibrium(system, state).reference)
    assert found.frequencies[0] == pytest.approx(np.sqrt(10.0 / 1.1) / (2.0 * np.pi), rel=1e-9)
    assert found.freedom == 1 and abs(found.coordinates[0][0]) < 1e-12
    assert notes_on(found) == ["dry friction holds its coordinates as they are: 'brake'"]


def test_a_brake_that_is_too_weak_is_refused_by_name():
    with pytest.raises(InputError, match=r"'brake' does not hold .*: 30 N m are needed, and it bears 29 at most"):
        equilibrium(*started(shoulder=29))


def test_two_frictions_hold_together_what_neither_does_alone():
    """15 N m and up to 2 · 1 m · 20 N from the reaction: each bears a part within its bound, together all."""
    found = equilibrium(*started(shoulder=15, bearing=BEARING)).frictions
    assert [entry["static"] for entry in found.values()] == pytest.approx([15.0, 40.0], rel=1e-9)
    assert all(abs(entry["force"]) <= entry["static"] * (1.0 + 1e-9) for entry in found.values())
    assert sum(entry["force"] for entry in found.values()) == pytest.approx(-30.0, rel=1e-9)


def test_a_friction_that_slides_is_a_law_of_small_motions():
    """Stribeck's fall of the force with the speed feeds the motion: 2 ζ ω = F' / m, here below zero."""
    text = BELT.replace("static: 3", "static: 3, stribeck_speed: 0.4 m/s")
    system, state = started(text)
    found = modes(reference_at(system, state, "start"))
    slope = -2.0 * 0.2 / 0.4**2 * np.exp(-((0.2 / 0.4) ** 2))  # of F_k + (F_s - F_k) exp(-(s'/v)²)
    assert found.eigenvalues[0].real == pytest.approx(-slope / 2.0, rel=1e-6)
    assert abs(found.eigenvalues[0]) == pytest.approx(np.sqrt(10.0), rel=1e-9)
    assert found.reference.held == ()


def test_friction_that_slides_by_its_load_is_refused_by_name():
    system, state = started(bearing=BEARING, speed=1)
    with pytest.raises(InputError, match="dry friction 'bearing' slides here, by the load of its bearing"):
        held_at(system, state)


def test_a_smooth_friction_by_its_load_has_no_linear_part_here():
    system, state = started(bearing=BEARING.replace("static: 2", "regularised: 0.1"))
    with pytest.raises(InputError, match="force 'bearing' depends on the load of its bearing: it has no linear part"):
        modes(reference_at(system, state, "start"))


def test_what_carries_nothing_and_is_pushed_by_nothing_rests():
    """The motor of the press does not pull yet, and its thread bears no load: that it could hold none is round-off."""
    found = equilibrium(*started((ROOT / "mechanisms" / "screw_press.yaml").read_text()))
    np.testing.assert_allclose(found.reference.motion.expected, 0.0, atol=1e-12)
    assert found.frictions["thread"]["static"] == pytest.approx(0.0, abs=1e-9)
