"""Brakes, bearings and screws against closed forms: they stop, hold, and are torn loose."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crossed import crossed
from tests.friction import closed_forms as exact
from tests.friction.mechanisms import FORMULATIONS, STEPS, rotor, screw
from tests.stops.runs import run

# Brakes and bearings of a rotor against closed forms: it stops at a time, holds, and is torn loose.

J_ROTOR, MASS, SPEED = 0.5, 2.0, 30.0


def ends(recorded):
    """The angle and the speed at the end."""
    return recorded["joints/coordinate"][-1, 0], recorded["joints/speed"][-1, 0]


@crossed("steps, formulation", STEPS, ["planar", "reduced"], together=1)
def test_a_constant_torque_stops_it(formulation, steps):
    """In space, rotation by 22.5 rad has its own error, of the method."""
    time, angle = exact.brake_stops(J_ROTOR, SPEED, 10.0)
    _, recorded = run(rotor("{torque: 10}", steps=steps, formulation=formulation))
    (sticks,) = recorded.of("stick")
    assert (sticks.name, sticks.time) == ("friction 'brake'", pytest.approx(time, abs=1e-9))
    turned, speed = ends(recorded)
    assert turned == pytest.approx(angle, abs=1e-9 if formulation == "planar" or steps.startswith("dop") else 1e-5)
    assert speed == pytest.approx(0.0, abs=1e-12)
    t = recorded["time"]
    apart = np.abs(t - time) > 1e-9
    slides = t[apart] < time
    assert (recorded["friction/state"][apart, 0] == np.where(slides, 1, 0)).all()
    assert recorded["friction/force"][apart, 0] == pytest.approx(np.where(slides, -10.0, 0.0), abs=1e-9)
    slides = np.minimum(t, time)
    lost = 10.0 * (SPEED * slides - 5.0 * slides**2 / J_ROTOR)
    assert recorded["friction/dissipation"][:, 0] == pytest.approx(lost, abs=1e-7)
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("speed", [12.0, -12.0])
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_it_grips_as_it_slows_down(formulation, speed):
    """With Stribeck's law, in either direction."""
    text = rotor("{torque: 8, static: 11, stribeck_speed: 3}", speed=speed, formulation=formulation)
    _, recorded = run(text)
    time, angle = exact.stribeck_stops(J_ROTOR, 12.0, 8.0, 11.0, 3.0)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(time, abs=1e-9)
    assert ends(recorded)[0] == pytest.approx(np.sign(speed) * angle, abs=1e-9)


@pytest.mark.parametrize("steps", ["dop853", "rk4", "radau5"])
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_load_that_grows_tears_it_loose_at_the_static_torque(formulation, steps):
    """A load of 4t N m: held until 5 N m at 1.25 s, then J ω' = 4 t - 4."""
    text = rotor("{torque: 4, static: 5}", speed=0.0, load="4*t", steps=steps, formulation=formulation)
    _, recorded = run(text)
    (slips,) = recorded.of("slip")
    assert (slips.name, slips.time) == ("friction 'brake'", pytest.approx(1.25, abs=1e-9))
    t = recorded["time"]
    apart = np.abs(t - 1.25) > 1e-9
    force = recorded["friction/force"][apart, 0]
    assert force == pytest.approx(np.where(t < 1.25, -4.0 * t, -4.0)[apart], abs=1e-9)
    assert np.abs(recorded["joints/coordinate"][t < 1.25]).max() < 1e-14
    away = 2.0 * ((t - 1.0) ** 2 - 0.25**2) / J_ROTOR
    assert recorded["joints/speed"][:, 0] == pytest.approx(np.where(t < 1.25, 0.0, away), abs=1e-9)
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_load_that_swings_is_held_and_let_go_in_turns(formulation):
    """6 sin t against 5 N m: J ω' = 6 sin t - 5 from asin(5/6) until ω = 0, then held until 6 sin t = -5."""
    from scipy.optimize import brentq

    text = rotor("{torque: 5}", speed=0.0, load="6*sin(t)", duration=6.0, formulation=formulation)
    _, recorded = run(text)
    slips = np.arcsin(5.0 / 6.0)

    def speed(t):
        return (6.0 * (np.cos(slips) - np.cos(t)) - 5.0 * (t - slips)) / J_ROTOR

    sticks = brentq(speed, np.pi / 2.0, np.pi, xtol=1e-15)
    assert [event.time for event in recorded.of("slip")] == pytest.approx([slips, np.pi + slips], abs=1e-9)
    assert [event.time for event in recorded.of("stick")] == pytest.approx([sticks, np.pi + sticks], abs=1e-9)
    assert ends(recorded)[0] == pytest.approx(0.0, abs=1e-8)


TWO = "  second: {{type: friction, joint: hinge, coulomb: {{torque: 14}}}}"


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_two_brakes_hold_what_both_together_hold(formulation):
    """4 and 14 N m hold 15 N m, though half of it is more than the first bears."""
    more = TWO.format()
    text = rotor("{torque: 4}", speed=0.0, load="min(10*t, 15)", more=more, formulation=formulation)
    _, recorded = run(text)
    assert not recorded.of("slip")
    assert np.abs(recorded["joints/coordinate"]).max() < 1e-13
    forces = recorded["friction/force"]
    assert forces.sum(axis=1) == pytest.approx(-np.minimum(10.0 * recorded["time"], 15.0), abs=1e-9)
    assert (np.abs(forces) <= np.array([4.0, 14.0]) + 1e-9).all()


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_two_brakes_slip_together_at_what_both_together_hold(formulation):
    more = TWO.format()
    text = rotor("{torque: 4}", speed=0.0, load="10*t", more=more, formulation=formulation)
    _, recorded = run(text)
    slips = recorded.of("slip")
    assert {event.name for event in slips} == {"friction 'brake'", "friction 'second'"}
    assert [event.time for event in slips] == pytest.approx([1.8] * len(slips), abs=1e-9)
    assert ends(recorded)[1] == pytest.approx(5.0 * 0.2**2 / J_ROTOR, abs=1e-9)


GEARED = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 2, {steps}, formulation: {formulation}}}
bodies:
  first: {{mass: 1, inertia: [1, 1, 0.2], position: [0, 0, 0]}}
  second: {{mass: 1, inertia: [1, 1, 0.3], position: [1, 0, 0]}}
joints:
  A: {{type: revolute, bodies: [ground, first], location: [0, 0, 0], axis: [0, 0, 1]}}
  B: {{type: revolute, bodies: [ground, second], location: [1, 0, 0], axis: [0, 0, 1]}}
  mesh: {{type: gear, joints: [A, B], teeth: [20, 40]}}
forces:
  load: {{type: torque, body: first, torque: [0, 0, "6*t"]}}
  slow: {{type: friction, joint: B, coulomb: {{torque: 6}}}}
  fast: {{type: friction, joint: A, coulomb: {{torque: 4}}}}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_brakes_on_both_shafts_of_a_gear(formulation):
    """The second shaft turns half as fast, so that its brake counts half: 4 + 6/2 N m hold the first shaft."""
    _, recorded = run(GEARED.format(steps=STEPS["dop853"], formulation=formulation))
    slips = recorded.of("slip")
    assert len(slips) == 2
    assert [event.time for event in slips] == pytest.approx([7.0 / 6.0] * 2, abs=1e-9)
    after = 2.0 - 7.0 / 6.0
    assert recorded["joints/speed"][-1, 0] == pytest.approx(3.0 * after**2 / (0.2 + 0.3 / 4.0), rel=1e-9)
    assert recorded["joints/speed"][-1, 1] == pytest.approx(-0.5 * recorded["joints/speed"][-1, 0], rel=1e-12)


@crossed("steps, formulation", ["radau5", "esdirk4"], ["planar", "reduced"], together=1)
def test_a_regularised_brake_creeps_by_its_width(formulation, steps):
    """Of order 1 in the width when the exact one has stopped it, of order 2 in the angle to rest."""
    time, angle = exact.brake_stops(J_ROTOR, 10.0, 10.0)
    errors = []
    for width in (0.2, 0.1, 0.05):
        text = rotor(f"{{torque: 10, regularised: {width}}}", speed=10.0, duration=time, steps=steps)
        _, recorded = run(text.replace("formulation: planar", f"formulation: {formulation}"))
        speed = ends(recorded)[1]
        assert speed == pytest.approx(exact.regularised_speed(J_ROTOR, 10.0, 10.0, width, time), abs=1e-7)
        assert not recorded.of("stick", "slip")
        _, recorded = run(text.replace(f"duration: {time}", f"duration: {time + 3.0}"))
        assert ends(recorded)[0] == pytest.approx(exact.regularised_angle(J_ROTOR, 10.0, 10.0, width), abs=1e-6)
        errors.append((speed, ends(recorded)[0] - angle))
    orders = np.diff(np.log2(errors), axis=0)
    assert orders[:, 0] == pytest.approx(-1.0, abs=1e-3)
    assert orders[:, 1] == pytest.approx(-2.0, abs=1e-2)


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_bearing_under_its_weight(formulation):
    """μ r |F| with |F| = m g, and with a preload beside it."""
    g = 9.81
    for coulomb, torque in (
        ("{coefficient: 0.2, radius: 2}", 0.2 * 2.0 * MASS * g),
        ("{coefficient: 0.2, radius: 2, preload: 11}", 0.2 * 2.0 * (MASS * g + 11.0)),
    ):
        time, angle = exact.brake_stops(J_ROTOR, SPEED, torque)
        text = rotor(coulomb, gravity=[0, -g, 0], duration=3.0, formulation=formulation)
        _, recorded = run(text)
        (sticks,) = recorded.of("stick")
        assert sticks.time == pytest.approx(time, abs=1e-9)
        assert ends(recorded)[0] == pytest.approx(angle, abs=1e-8)


@pytest.mark.parametrize(("length", "factor"), [(0.5, 2.0 * 0.6 / 0.5), (2.0, 1.0)])
def test_an_overhung_bearing(length, factor):
    """The weight acts 0.6 m beside the middle of two supports: they bear m g (a/L ± 1/2), which is 2 m g a/L together
    where one of them is lifted, and m g where none is."""
    torque = 0.3 * 0.5 * MASS * 9.81 * factor
    coulomb = f"{{coefficient: 0.3, radius: 0.5, bearing_length: {length}}}"
    text = rotor(coulomb, gravity=[0, -9.81, 0], centre=[0, 0, 0.6], duration=6.0, formulation="reduced")
    _, recorded = run(text)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(exact.brake_stops(J_ROTOR, SPEED, torque)[0], abs=1e-8)


def test_a_thrust_bearing():
    """A vertical axis: the axial force m g at its own radius, with the radial arm given beside it for nothing."""
    text = rotor(
        "{coefficient: 0.2, radius: 1, axial_radius: 1.5}", gravity=[0, 0, -9.81], duration=3.0, formulation="reduced"
    )
    _, recorded = run(text)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(exact.brake_stops(J_ROTOR, SPEED, 0.2 * 1.5 * MASS * 9.81)[0], abs=1e-9)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_an_eccentric_rotor_is_slowed_by_its_own_centrifugal_force(formulation):
    """Friction depends on the acceleration that it makes: it is solved together with the reaction."""
    coulomb = "{coefficient: 0.5, radius: 1.2}"
    duration = 0.1 if formulation == "full" else 1.0
    text = rotor(coulomb, centre=[0.1, 0, 0], duration=duration, formulation=formulation)
    _, recorded = run(text)
    angle, speed = exact.eccentric_coasts(J_ROTOR, MASS, 0.1, 0.6, SPEED, duration)
    assert ends(recorded) == (pytest.approx(angle, abs=1e-9), pytest.approx(speed, abs=1e-8))
    assert recorded.unbalanced < 1e-7


# A screw under a load: it holds it where tan of the lead angle is below the static coefficient, else it runs down.

J_SCREW, M, G, R = 0.02, 50.0, 9.81, 0.03
#: The screw's angle is the first coordinate of its joint.


def law(sliding, static):
    """A friction on the thread of radius R."""
    return f"{{angle: {{coefficient: {sliding}, static: {static}, radius: {R}}}}}"


def angle(recorded):
    """The angle at the end, and its speed."""
    return recorded["joints/coordinate"][-1, 0], recorded["joints/speed"][-1, 0]


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("formulation", "steps"), [("reduced", "dop853"), ("reduced", "rk4"), ("reduced", "radau5"), ("full", "dop853")]
)
@pytest.mark.parametrize("lead", [0.1999, 0.2001])
def test_it_holds_its_load_or_runs_down(formulation, steps, lead):
    """A static coefficient of 0.2 beside leads a ten-thousandth below and above; sliding at 0.1."""
    h, end = lead * R, 0.2 if formulation == "full" else 1.0
    text = screw(law(0.1, 0.2), m=M, J=J_SCREW, h=h, duration=end, steps=steps, formulation=formulation)
    _, recorded = run(text)
    turned, speed = angle(recorded)
    if lead < 0.2:
        assert abs(turned) < 1e-14
        assert recorded["friction/force"][:, 0] == pytest.approx(h * M * G, rel=1e-9)
        assert (recorded["friction/state"] == 0).all()
    else:
        a = exact.screw_runs_down(J_SCREW, M, h, 0.1 * R, G)
        assert speed == pytest.approx(a * end, rel=1e-9)
        assert turned == pytest.approx(0.5 * a * end**2, rel=1e-9 if steps == "dop853" else 1e-6)
        thread = M * (G + h * a)
        assert recorded["friction/force"][:, 0] == pytest.approx(0.1 * R * thread, rel=1e-9)
    assert recorded.unbalanced < (1e-7 if steps == "dop853" else 1e-4)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_torque_that_grows_raises_or_lowers_the_load(sign):
    """It takes (h + μ_s r) m g to raise and (μ_s r - h) m g to lower it; raised, it goes on with the sliding one."""
    h, rate = 0.1 * R, 10.0
    raises, lowers = exact.screw_needs(M, h, 0.2 * R, G)
    text = screw(law(0.15, 0.2), m=M, J=J_SCREW, h=h, torque=f"{sign * rate}*t")
    _, recorded = run(text)
    (slips,) = recorded.of("slip")
    assert slips.time == pytest.approx((raises if sign > 0 else lowers) / rate, abs=1e-9)
    if sign > 0:
        begins = slips.time
        slope = exact.screw_is_raised(J_SCREW, M, h, 0.15 * R, G, 1.0) - exact.screw_is_raised(
            J_SCREW, M, h, 0.15 * R, G, 0.0
        )
        first = exact.screw_is_raised(J_SCREW, M, h, 0.15 * R, G, raises)
        on = 1.0 - begins
        assert angle(recorded)[1] == pytest.approx(first * on + 0.5 * slope * rate * on**2, rel=1e-9)


def test_a_spinning_screw_comes_to_rest_and_holds():
    """It starts upwards: friction and load slow it down; then it holds."""
    h = 0.1 * R
    text = screw(law(0.15, 0.2), m=M, J=J_SCREW, h=h, speed=20.0)
    _, recorded = run(text)
    slows = -exact.screw_is_raised(J_SCREW, M, h, 0.15 * R, G, 0.0)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(20.0 / slows, abs=1e-9)
    assert angle(recorded) == (pytest.approx(200.0 / slows, abs=1e-8), pytest.approx(0.0, abs=1e-12))
    lost = recorded["friction/dissipation"][-1, 0]
    kinetic = 0.5 * (J_SCREW + M * h**2) * 400.0
    assert lost == pytest.approx(kinetic - M * G * h * angle(recorded)[0], rel=1e-8)
    assert np.diff(recorded["diagnostics/total_energy"]).max() <= 1e-9


def test_a_constant_friction_on_both_coordinates():
    """A torque on the angle and a force on the displacement of one screw: together they hold what either cannot."""
    h = 0.1 * R
    load = M * G * h
    both = f"{{angle: {{torque: {0.6 * load}}}, displacement: {{force: {0.6 * load / h}}}}}"
    _, recorded = run(screw(both, m=M, J=J_SCREW, h=h))
    assert abs(angle(recorded)[0]) < 1e-12
    on_angle, along = recorded["friction/force"].T
    assert on_angle + h * along == pytest.approx(load, rel=1e-9)
    less = both.replace(str(0.6 * load), str(0.3 * load), 1)
    _, recorded = run(screw(less, m=M, J=J_SCREW, h=h))
    assert angle(recorded)[1] == pytest.approx(-0.1 * load / (J_SCREW + M * h**2), rel=1e-9)
