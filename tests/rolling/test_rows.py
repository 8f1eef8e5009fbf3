"""Rows at velocity level: how many there are, which depend on each other, which jam, and what is refused in words."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.base.errors import InputError
from tests.rolling import scenes

#: Front wheels whose axles meet the rear one 2 m beside the car.
ACKERMANN = float(np.arctan(1.0 / 1.5)), float(np.arctan(1.0 / 2.5))
FEW = {"tolerance": None, "step": "0.05 s", "integrator": "rk4", "duration": "1 s", "output_step": "0.5 s"}


def checked(text):
    return mbproj.check(mbproj.read_scene_text(text))


def test_a_coin_has_three_speeds_and_five_positions():
    facts = checked(scenes.coin()).facts
    assert (facts["degrees_of_freedom"], facts["positions"], facts["rank"]) == (3, 5, 4)


@pytest.mark.parametrize(("angles", "redundant"), [((0.0, 0.0), 3), (ACKERMANN, 3)])
def test_wheels_that_roll_together_are_redundant_and_their_shares_not_unique(angles, redundant):
    found = checked(scenes.car(*angles))
    assert found.can_run
    assert (found.degrees_of_freedom, found.mobility.positions) == (1, 7)
    sets = found.diagnosis.redundancy.sets
    assert [entry.permanent for entry in sets] == [True] * redundant
    assert not any(entry.contradictory for entry in sets)
    assert "Fy" in found.diagnosis.not_unique["W_rl"]
    assert not found.notes


def test_a_car_with_ackermann_steering_turns_about_one_point():
    r = mbproj.run(mbproj.read_scene_text(scenes.car(*ACKERMANN, **FEW, formulation="full")))
    p = r["bodies/position"][:, 0]
    np.testing.assert_allclose(np.hypot(p[:, 0], p[:, 1] - 2.0), np.hypot(0.5, 2.0), atol=1e-13)
    np.testing.assert_allclose(r["bodies/position"][:, 1:, 2], 0.3, atol=1e-13)
    np.testing.assert_allclose(r["joints/reaction_force"][:, 1::2, 2].sum(axis=1), 140.0 * 9.81, rtol=1e-10)
    assert r["diagnostics/velocity_violation"].max() < 1e-13


def test_wheels_that_are_steered_alike_jam_and_are_named():
    found = checked(scenes.car(0.45, 0.45))
    assert (found.degrees_of_freedom, found.mobility.positions) == (0, 7)
    (note,) = found.notes
    assert "joints 'W_rl', 'W_rr', 'W_fl', 'W_fr' jam" in note.message
    assert not found.choice.kinematic


def test_a_wheel_with_a_hub_without_mass_keeps_the_energy():
    r = mbproj.run(mbproj.read_scene_text(scenes.trailer(**FEW, formulation="full")))
    v, ω = r["bodies/velocity"][:, 0], r["bodies/angular_velocity"][:, 0]
    energy = 10.0 * np.sum(v**2, axis=1) + 0.5 * ω[:, 2] ** 2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)
    assert r["diagnostics/position_violation"].max() < 2e-13


def test_a_row_at_velocity_level_gives_way_to_one_at_position_level():
    """An edge along a slider says what the slider says already: the edge is left out, and the slider stays closed."""
    body = "  block: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0], velocity: [1, 0, 0]}"
    joints = (
        "  edge: {type: knife_edge, bodies: [ground, block], location: [0, 0, 0], axis: [0, 1, 0]}\n"
        "  slides: {type: prismatic, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0]}"
    )
    text = scenes.scene(body, joints, formulation="full")
    found = checked(text)
    (entry,) = found.diagnosis.redundancy.sets
    assert entry.held[0].name == "edge"
    assert found.degrees_of_freedom == found.mobility.positions == 1
    r = mbproj.run(mbproj.read_scene_text(text))
    np.testing.assert_allclose(r["bodies/position"][-1, 0], [1.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (", normal: [0, 0, 1]", "", "missing key 'normal'"),
        ("radius: 0.3", "radius: -0.3", "'radius'"),
        ("normal: [0, 0, 1]", "normal: {coin: [0, 0, 1]}", "unexpected 'coin' in 'plane'"),
        ("normal: [0, 0, 1]", "normal: {ground: [0, 0, 1]}", "mixes global and local: its 'plane'"),
        ("plane:", "plain:", "unknown key 'plain'"),
        ("rolling_wheel", "rolling_weel", "did you mean 'rolling_wheel'"),
    ],
)
def test_mistakes_are_told_at_their_line(old, new, message):
    text = scenes.coin().replace(old, new)
    assert text != scenes.coin()
    with pytest.raises(InputError, match=message) as error:
        mbproj.read_scene_text(text, "f.yaml")
    assert "f.yaml:7:" in str(error.value)
