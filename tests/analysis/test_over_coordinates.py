"""Quantities over a coordinate in place of time: passages, ratios and transmission angles against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text, run
from mbproj.results.analysis.expectations import curves_at, outcomes, passed
from mbproj.scene.records import Passage
from tests.analysis.turning_crank import SCENE, SPEED, L, R, place


def expected(*lines):
    return SCENE + "".join(f"  e{k}: {{{line}, source: closed form}}\n" for k, line in enumerate(lines))


def test_quantities_where_the_crank_is_at_an_angle_are_those_of_the_closed_form():
    """100 samples on 1.1 turns: the polynomial of six points is right to 1e-9."""
    at_90, slope_90 = place(np.pi / 2)
    _, slope_200 = place(np.radians(200.0))
    μ = float(np.pi / 2 - np.arcsin(R / L))
    text = expected(
        f"joint: bore, quantity: displacement, at: {{main.angle: 90 deg}}, value: {at_90!r}, absolute: 1e-9",
        f"joint: bore, quantity: displacement_speed, at: {{main.angle: 90 deg}}, value: {slope_90 * SPEED!r},"
        " absolute: 1e-7",
        f"joint: bore, quantity: displacement_velocity_ratio, over: main.angle, at: {{main.angle: 200 deg}},"
        f" value: {slope_200!r}, absolute: 1e-8",
        f"joint: bore, quantity: displacement_mechanical_advantage, over: main.angle, at: {{main.angle: 200 deg}},"
        f" value: {1.0 / slope_200!r}, relative: 1e-6",
        f"marker: wrist, quantity: transmission_angle, between: [pin, across], at: {{main.angle: 90 deg}},"
        f" value: {μ!r} rad, absolute: 1e-8",
        f"marker: wrist, quantity: transmission_angle, between: [pin, across], at: minimum, above: {μ - 1e-3!r}",
        "diagnostic: total_energy, at: {bore.displacement: -0.1 m}, above: 0",
    )
    for outcome in outcomes(read_scene_text(text, "crank").expectations, run(text)):
        assert outcome.holds, (outcome.expectation, outcome.measured)
        assert outcome.checked


def test_a_place_that_is_never_passed_is_not_checked():
    text = expected("joint: bore, quantity: displacement, at: {bore.displacement: 1 m}, above: 0")
    (outcome,) = outcomes(read_scene_text(text, "crank").expectations, run(text))
    assert not outcome.checked


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("joint: bore, quantity: displacement, at: {main.angel: 1}, above: 0", "unknown joint coordinate 'main.angel'"),
        ("joint: bore, quantity: displacement, at: {main.angle: 1 m}, above: 0", "'main.angle' is in rad"),
        ("joint: bore, quantity: displacement, at: {a: 1, b: 2}, above: 0", "a place {A.angle: 90 deg}"),
        ("joint: bore, quantity: displacement_velocity_ratio, at: end, above: 0", "add  over: JOINT.COORDINATE"),
        ("joint: bore, quantity: displacement, over: main.angle, at: end, above: 0", "'displacement' has no input"),
        ("joint: bore, quantity: angle_velocity_ratio, over: main.angle, at: end, above: 0", "prismatic and has no"),
        ("joint: bore, quantity: displacement_velocity_ratio, over: x.y, at: end, above: 0", "joint coordinate 'x.y'"),
        ("marker: pin, quantity: transmission_angle, at: end, above: 0", "add  between: [FIRST, SECOND]"),
        ("marker: pin, quantity: transmission_angle, between: [pin, wrist], at: end, above: 0", "the corner itself"),
        ("marker: pin, quantity: transmission_angle, between: [a, wrist], at: end, above: 0", "unknown marker 'a'"),
        ("joint: bore, quantity: displacement, between: [pin, wrist], at: end, above: 0", "only a transmission angle"),
        (
            "joint: bore, quantity: displacement_velocity_ratio, over: main.angle, at: end, below: 3 rad",
            "'displacement_velocity_ratio' is in m",
        ),
    ],
)
def test_what_is_wrong_is_said_at_its_key(line, said):
    with pytest.raises(InputError) as raised:
        read_scene_text(expected(line), "crank")
    assert any(said in str(problem) for problem in raised.value.problems), raised.value


def test_the_first_passage_counts_modulo_a_turn_and_no_polynomial_crosses_an_event():
    t = np.linspace(0.0, 1.0, 51)
    angle = 0.3 - 9.0 * t
    found = passed(Passage("A.angle", 6.0, "rad"), t, angle, np.zeros(0))
    assert found == pytest.approx((0.3 - 6.0 + 2.0 * np.pi) / 9.0, abs=1e-12)
    length = passed(Passage("A.displacement", -6.0, "m"), t, angle, np.zeros(0))
    assert length == pytest.approx(0.7, abs=1e-12)
    kinked = np.abs(t - 0.41)
    assert curves_at(t, kinked[:, None], 0.43, np.array([0.41]))[0] == pytest.approx(0.02, abs=1e-12)
    assert passed(Passage("A.angle", 0.3, "rad"), t, angle, np.zeros(0)) == 0.0
