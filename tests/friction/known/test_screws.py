"""A screw under a load: it holds it where tan of the lead angle is below the static coefficient, else it runs down."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction import closed_forms as exact
from tests.friction.mechanisms import screw
from tests.stops.runs import run

J, M, G, R = 0.02, 50.0, 9.81, 0.03
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
    text = screw(law(0.1, 0.2), m=M, J=J, h=h, duration=end, steps=steps, formulation=formulation)
    _, recorded = run(text)
    turned, speed = angle(recorded)
    if lead < 0.2:
        assert abs(turned) < 1e-14
        assert recorded["friction/force"][:, 0] == pytest.approx(h * M * G, rel=1e-9)
        assert (recorded["friction/state"] == 0).all()
    else:
        a = exact.screw_runs_down(J, M, h, 0.1 * R, G)
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
    text = screw(law(0.15, 0.2), m=M, J=J, h=h, torque=f"{sign * rate}*t")
    _, recorded = run(text)
    (slips,) = recorded.of("slip")
    assert slips.time == pytest.approx((raises if sign > 0 else lowers) / rate, abs=1e-9)
    if sign > 0:
        begins = slips.time
        slope = exact.screw_is_raised(J, M, h, 0.15 * R, G, 1.0) - exact.screw_is_raised(J, M, h, 0.15 * R, G, 0.0)
        first = exact.screw_is_raised(J, M, h, 0.15 * R, G, raises)
        on = 1.0 - begins
        assert angle(recorded)[1] == pytest.approx(first * on + 0.5 * slope * rate * on**2, rel=1e-9)


def test_a_spinning_screw_comes_to_rest_and_holds():
    """It starts upwards: friction and load slow it down; then it holds."""
    h = 0.1 * R
    text = screw(law(0.15, 0.2), m=M, J=J, h=h, speed=20.0)
    _, recorded = run(text)
    slows = -exact.screw_is_raised(J, M, h, 0.15 * R, G, 0.0)
    (sticks,) = recorded.of("stick")
    assert sticks.time == pytest.approx(20.0 / slows, abs=1e-9)
    assert angle(recorded) == (pytest.approx(200.0 / slows, abs=1e-8), pytest.approx(0.0, abs=1e-12))
    lost = recorded["friction/dissipation"][-1, 0]
    kinetic = 0.5 * (J + M * h**2) * 400.0
    assert lost == pytest.approx(kinetic - M * G * h * angle(recorded)[0], rel=1e-8)
    assert np.diff(recorded["diagnostics/total_energy"]).max() <= 1e-9


def test_a_constant_friction_on_both_coordinates():
    """A torque on the angle and a force on the displacement of one screw: together they hold what either cannot."""
    h = 0.1 * R
    load = M * G * h
    both = f"{{angle: {{torque: {0.6 * load}}}, displacement: {{force: {0.6 * load / h}}}}}"
    _, recorded = run(screw(both, m=M, J=J, h=h))
    assert abs(angle(recorded)[0]) < 1e-12
    on_angle, along = recorded["friction/force"].T
    assert on_angle + h * along == pytest.approx(load, rel=1e-9)
    less = both.replace(str(0.6 * load), str(0.3 * load), 1)
    _, recorded = run(screw(less, m=M, J=J, h=h))
    assert angle(recorded)[1] == pytest.approx(-0.1 * load / (J + M * h**2), rel=1e-9)
