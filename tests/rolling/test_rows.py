"""Rows at velocity level, and what rolls beside drives, dry friction, limits and other integrators."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbproj
from mbproj.base.errors import InputError
from tests.crossed import crossed
from tests.rolling import scenes
from tests.rolling.scenes import of_rattleback, rattleback, run

RADIUS, SPEED = 0.3, 1.5
#: Of the cart and its wheel, in kg; with the wheel's 0.04 kg m² the whole has 4 + 0.04/0.09 kg.
WHOLE = 4.0 + 0.04 / RADIUS**2
DRY = "forces:\n  dry: {type: friction, joint: hub, coulomb: {torque: 0.9}}\n"


def cart(rest: str = "", own: str = "", speed: float = SPEED, **simulation: object) -> str:
    """A cart of 3 kg on one wheel of 1 kg, kept upright, rolls along x."""
    moves = f"velocity: [{speed!r}, 0, 0]"
    bodies = (
        f"  cart: {{mass: 3, inertia: [0.1, 0.1, 0.1], position: [0.1, 0, 0.5], {moves}}}\n"
        f"  wheel: {{mass: 1, inertia: [0.02, 0.04, 0.02], position: [0, 0, {RADIUS}], {moves}, "
        f"angular_velocity: [0, {speed / RADIUS!r}, 0]}}"
    )
    joints = (
        f"  rail: {{type: prismatic, bodies: [ground, cart], location: [0, 0, {RADIUS}], axis: [1, 0, 0]}}\n"
        f"  hub: {{type: revolute, bodies: [cart, wheel], location: [0, 0, {RADIUS}], axis: [0, 1, 0]{own}}}\n"
        + scenes.wheel("wheel", f"[0, 0, {RADIUS}]", "[0, 1, 0]", RADIUS)
    )
    return scenes.scene(bodies, joints, rest, **simulation)


def way(r):
    return r["joints/coordinate"][:, r.names("coordinates").index("rail.displacement")]


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["reduced", "full"])
def test_a_wheel_that_a_motion_turns_drives_the_cart(formulation):
    """Its angle is 2 t²: the cart goes 0.6 t², and the drive has to give R times the force that the whole asks for."""
    few = {"duration": "0.2 s", "tolerance": 1e-8} if formulation == "full" else {}
    text = cart("motions:\n  drive: {joint: hub, angle: 2 * t**2}\n", speed=0.0, **few)
    r = run(text, formulation=formulation)
    np.testing.assert_allclose(way(r), 0.6 * r.time**2, atol=1e-13)
    np.testing.assert_allclose(r["motions/force"][:, 0], RADIUS * WHOLE * 1.2, rtol=1e-10)


def test_dry_friction_in_a_hub_brings_the_cart_to_rest_and_holds_it():
    """0.9 N m in the hub are 3 N: it slows down evenly, stands after v / a, and its friction has taken ½ m v²."""
    r = run(cart(DRY, duration="4 s"))
    slows = 0.9 / RADIUS / WHOLE
    t = np.minimum(r.time, SPEED / slows)
    np.testing.assert_allclose(way(r), SPEED * t - 0.5 * slows * t**2, atol=1e-9)
    assert r["bodies/velocity"][-1, 0, 0] == pytest.approx(0.0, abs=1e-12)
    assert r["friction/dissipation"][-1, 0] == pytest.approx(0.5 * WHOLE * SPEED**2, rel=1e-9)
    assert r["diagnostics/velocity_violation"].max() < 1e-13


def test_a_wheel_that_a_limit_stops_comes_back_rolling():
    """At 0.6 m it turns back with 0.5 of its speed, and its wheel with it: no row of slip opens at the impact."""
    limits = "limits: {displacement: {range: [null, 0.6], rigid: true, restitution: 0.5}}"
    text = cart().replace("axis: [1, 0, 0]}", f"axis: [1, 0, 0], {limits}}}")
    r = run(text)
    t = 0.6 / SPEED
    expected = np.where(r.time < t, SPEED * r.time, 0.6 - 0.5 * SPEED * (r.time - t))
    np.testing.assert_allclose(way(r), expected, atol=1e-9)
    spin = r["bodies/angular_velocity"][:, 1, 1]
    np.testing.assert_allclose(RADIUS * spin, r["bodies/velocity"][:, 1, 0], atol=1e-13)


@pytest.mark.parametrize(("integrator", "order"), [("esdirk4", 3.8), ("radau5", 4.8)])
def test_implicit_steps_roll_with_their_order(integrator, order):
    """A ball on a turntable, whose motion is known."""
    errors = []
    for step in (0.1, 0.05):
        r = run(scenes.turntable(tolerance=None, integrator=integrator, step=f"{step!r} s"), formulation="reduced")
        errors.append(np.abs(r["bodies/position"][-1, 1, :2] - scenes.on_turntable(r.time[-1:])[0]).max())
        assert r["diagnostics/position_violation"].max() < 1e-13
        assert r["diagnostics/velocity_violation"].max() < 1e-13
    assert np.log2(errors[0] / errors[1]) > order, errors


def end_of_table(**settings):
    r = run(scenes.turntable(**settings), formulation="reduced")
    return r["bodies/position"][-1, 1, :2] - scenes.on_turntable(r.time[-1:])[0]


def end_of_sleigh(**settings):
    r = run(scenes.sleigh(**settings), formulation="reduced")
    return r["joints/coordinate"][-1, 2] - scenes.of_sleigh(r.time[-1:])[1]


def end_of_celt(**settings):
    r = run(rattleback(-3.0, 0.1, **settings), formulation="reduced")
    return r["bodies/angular_velocity"][-1, 0] - of_rattleback(np.array([0.0, r.time[-1]]), -3.0, 0.1)[1][-1]


@crossed(
    "integrator, count, order, end",
    [pytest.param("rk4", 50, 3.8), pytest.param("dop853", 16, 7.5)],
    [end_of_table, end_of_sleigh, end_of_celt],
    together=1,
)
def test_orders_of_what_rolls(end, integrator, count, order):
    """Errors of so many steps and of twice as many; the celt rattles fast."""
    duration = 0.4 if end is end_of_celt else 2.0
    counts = [count, 2 * count] if end is not end_of_celt else [4 * count, 8 * count]
    errors = [
        np.abs(
            end(tolerance=None, integrator=integrator, duration=duration, output_step=duration, step=duration / each)
        ).max()
        for each in counts
    ]
    assert np.log2(errors[0] / errors[1]) > order, errors


@pytest.mark.parametrize(
    "text",
    [
        scenes.coin(duration="0.4 s", output_step="50 ms"),
        rattleback(-3.0, 0.1, duration="0.4 s", output_step="50 ms"),
        cart(DRY, duration="0.4 s", output_step="50 ms"),
    ],
    ids=["coin", "rattleback", "cart"],
)
def test_a_run_that_is_continued_has_the_bits_of_one(text, tmp_path):
    scene = mbproj.read_scene_text(text)
    whole = mbproj.run(scene, output=tmp_path / "whole.h5")
    part = mbproj.run(scene, duration="0.2 s", output=tmp_path / "part.h5")
    more = mbproj.continue_run(part, until=0.4)
    for name in ("bodies/position", "bodies/velocity", "joints/reaction_force"):
        np.testing.assert_array_equal(more[name][-1], whole[name][-1])


def test_a_tricycle_goes_where_its_front_wheel_leads_it():
    """Pedalled at 4 t rad/s and steered by δ: its rear axle goes v cos δ ahead and turns at v sin δ a metre."""
    bodies, joints = "  frame: {mass: 20, inertia: [1, 2, 2], position: [0.4, 0, 0.4]}\n", ""
    bodies += "  fork: {mass: 2, inertia: [0.05, 0.05, 0.02], position: [1, 0, 0.5]}\n"
    joints += "  head: {type: revolute, bodies: [frame, fork], location: [1, 0, 0.6], axis: [0, 0, 1]}\n"
    places = {"front": ("fork", "[1, 0, 0.25]"), "left": ("frame", "[0, 0.35, 0.25]")}
    places["right"] = ("frame", "[0, -0.35, 0.25]")
    for name, (holder, at) in places.items():
        bodies += f"  {name}: {{mass: 1, inertia: [0.015, 0.03, 0.015], position: {at}}}\n"
        joints += f"  {name}_hub: {{type: revolute, bodies: [{holder}, {name}], location: {at}, axis: [0, 1, 0]}}\n"
        joints += f"{scenes.wheel(name, at, '[0, 1, 0]', 0.25)}\n"
    motions = "motions:\n  turn: {joint: head, angle: 0.25 * (1 - cos(2 * t))}\n"
    motions += "  pedal: {joint: front_hub, angle: 2 * t**2}\n"
    motions += "markers:\n  tail: {body: frame, location: [0, 0, 0.25]}\n"
    r = run(scenes.scene(bodies, joints, motions, duration="2 s"))

    def rates(t, y):
        v, δ = 0.25 * 4.0 * t, 0.25 * (1.0 - np.cos(2.0 * t))
        return [v * np.cos(δ) * np.cos(y[2]), v * np.cos(δ) * np.sin(y[2]), v * np.sin(δ)]

    way = solve_ivp(rates, (0.0, 2.0), [0.0, 0.0, 0.0], "DOP853", r.time, rtol=1e-12, atol=1e-13).y
    np.testing.assert_allclose(r["markers/position"][:, 0, :2], way[:2].T, atol=1e-8)


# Rows at velocity level: how many there are, which depend on each other, which jam, and what is refused in words.

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
