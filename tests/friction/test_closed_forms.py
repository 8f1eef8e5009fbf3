"""The closed forms of dry friction against SciPy: equations of one coordinate, event by event, and statics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.friction import closed_forms as exact

SOLVER = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}


def at_rest(derivative, start, end):
    """The state where its last component first falls to zero."""

    def stops(t, y):
        return y[-1]

    stops.terminal, stops.direction = True, -1
    solved = solve_ivp(derivative, (0.0, end), start, events=stops, **SOLVER)
    return solved.t_events[0][0], solved.y_events[0][0]


def test_a_brake_stops_a_rotor():
    time, (angle, _) = at_rest(lambda t, y: [y[1], -4.0 / 0.5], [0.0, 30.0], 5.0)
    assert exact.brake_stops(0.5, 30.0, 4.0) == pytest.approx((time, angle), rel=1e-11)


def test_a_brake_that_grips_as_it_slows_down():
    def slows(t, y):
        return [y[1], -(4.0 + 1.5 * np.exp(-((y[1] / 0.7) ** 2))) / 0.5]

    time, (angle, _) = at_rest(slows, [0.0, 10.0], 5.0)
    assert exact.stribeck_stops(0.5, 10.0, 4.0, 5.5, 0.7) == pytest.approx((time, angle), rel=1e-10)


@pytest.mark.parametrize("width", [1.0, 0.25])
def test_a_regularised_brake(width):
    def slows(t, y):
        return [y[1], -8.0 * np.tanh(y[1] / width)]

    stop = exact.brake_stops(0.5, 10.0, 4.0)[0]
    solved = solve_ivp(slows, (0.0, stop + 40.0 * width), [0.0, 10.0], dense_output=True, **SOLVER)
    for t in (0.3, stop, stop + 0.1):
        assert exact.regularised_speed(0.5, 10.0, 4.0, width, t) == pytest.approx(solved.sol(t)[1], abs=1e-10)
    golden = width * np.log((1.0 + np.sqrt(5.0)) / 2.0)
    assert exact.regularised_speed(0.5, 10.0, 4.0, width, stop) == pytest.approx(golden, rel=1e-8)
    assert exact.regularised_angle(0.5, 10.0, 4.0, width) == pytest.approx(solved.y[0, -1], rel=1e-8)


def test_an_eccentric_rotor_coasts():
    """The acceleration by a root of J ω' + c √(ω⁴ + ω'²) = 0 at every speed."""
    J, m, e, arm, ω = 0.3, 5.0, 0.1, 0.4, 20.0

    def slows(t, y):
        at = brentq(
            lambda a: (J + m * e**2) * a + arm * m * e * np.hypot(y[1] ** 2, a), -2.0 * y[1] ** 2, 0.0, xtol=1e-13
        )
        return [y[1], at]

    solved = solve_ivp(slows, (0.0, 0.3), [0.0, ω], **SOLVER)
    assert exact.eccentric_coasts(J, m, e, arm, ω, 0.3) == pytest.approx(tuple(solved.y[:, -1]), rel=1e-10)
    with pytest.raises(AssertionError, match="no sliding motion"):
        exact.eccentric_coasts(J, m, e, 0.71, ω, 0.3)


def test_a_block_up_and_down_an_incline():
    angle, μ, g = 0.5, 0.3, 9.81
    slows = -g * np.sin(angle) - μ * g * np.cos(angle)
    time, (way, _) = at_rest(lambda t, y: [y[1], slows], [0.0, 2.0], 5.0)
    assert exact.up_an_incline(angle, μ, 2.0, g) == pytest.approx((time, way), rel=1e-11)
    assert exact.down_an_incline(np.arctan(μ), μ, g) == pytest.approx(0.0, abs=1e-14)
    assert exact.held_by(np.arctan(0.4)) == pytest.approx(0.4)


def test_a_point_that_is_thrown_across_an_incline():
    """In Cartesian components, to a speed of 1e-7 m/s."""
    down, across = 10.0 * np.sin(0.3), 10.0 * np.cos(0.3)

    def slides(t, y):
        return [y[2], y[3], *([down, 0.0] - 0.4 * across * y[2:4] / np.hypot(y[2], y[3]))]

    def slow(t, y):
        return np.hypot(y[2], y[3]) - 1e-7

    slow.terminal = True
    solved = solve_ivp(slides, (0.0, 2.0), [0.0, 0.0, 0.0, 2.0], events=slow, **SOLVER)
    found = (solved.t[-1], *solved.y[:2, -1])
    assert exact.thrown_across(0.3, 0.4, 2.0, 10.0) == pytest.approx(found, abs=2e-7)


def test_a_block_on_an_incline_that_tilts():
    """In the axes of the ground, as a mass on a straight line that turns: N from the acceleration across the line."""
    tilting = exact.Tilting(ω=0.5, sliding=0.3, static=0.4, g=9.81)

    def slides(t, y):
        s, rate = y
        φ = 0.5 * t
        normal = 9.81 * np.cos(φ) + 2.0 * rate * 0.5
        assert normal > 0.0
        return [rate, 0.25 * s - 9.81 * np.sin(φ) + 0.3 * normal]

    end = tilting.release + 0.6
    solved = solve_ivp(slides, (tilting.release, end), [0.0, 0.0], **SOLVER)
    assert tilting(end) == pytest.approx(tuple(solved.y[:, -1]), rel=1e-10)
    held = 9.81 * np.sin(0.5 * tilting.release) / (9.81 * np.cos(0.5 * tilting.release))
    assert held == pytest.approx(0.4, rel=1e-14)


def test_stick_slip_on_a_belt():
    """Event by event: sticks until the spring has the static force, slips until it has the belt's speed again."""
    belt = exact.Belt(m=2.0, k=300.0, v=0.1, sliding=6.0, static=9.0)

    def caught(t, y):
        return y[1] - belt.v

    caught.terminal, caught.direction = True, 1
    start = [9.0 / 300.0, 0.1 - 1e-15]
    solved = solve_ivp(
        lambda t, y: [y[1], 3.0 - 150.0 * y[0]], (0.0, 2.0), start, events=caught, dense_output=True, **SOLVER
    )
    assert belt.slips == pytest.approx(solved.t_events[0][-1], rel=1e-10)
    back = solved.y_events[0][-1][0]
    assert belt.sticks == pytest.approx((9.0 / 300.0 - back) / 0.1, rel=1e-9)
    turns = belt(belt.first_slip + np.linspace(0.0, 1.0, 20001) * belt.period)
    assert belt.amplitude == pytest.approx(np.ptp(turns) / 2.0, rel=1e-7)
    for t in (0.1, 0.3):
        assert belt(belt.first_slip + t) == pytest.approx(solved.sol(t)[0], rel=1e-10)


def test_a_screw():
    """The thread's force from the equation along the axis, the acceleration from the one about it."""
    J, m, h, arm, g = 0.02, 50.0, 4e-3, 3e-3, 9.81
    a, thread = np.linalg.solve([[J, h - arm], [-m * h, 1.0]], [0.0, m * g])
    assert exact.screw_runs_down(J, m, h, arm, g) == pytest.approx(a, rel=1e-13)
    assert thread > 0.0
    a, thread = np.linalg.solve([[J, h + arm], [-m * h, 1.0]], [9.0, m * g])
    assert exact.screw_is_raised(J, m, h, arm, g, 9.0) == pytest.approx(a, rel=1e-12)
    raises, lowers = exact.screw_needs(m, h, arm, g)
    assert exact.screw_is_raised(J, m, h, arm, g, raises) == pytest.approx(0.0, abs=1e-13)
    assert (lowers > 0.0) == (h < arm)


@pytest.mark.parametrize(("off", "count"), [(0.1, {5.0: 1, -5.0: 1}), (0.3, {5.0: 2, -5.0: 0})])
def test_a_guide_with_a_mass_beside_it(off, count):
    """κ below 1 and above: every solution of m a + κ m |a| = force by a scan for changes of sign."""
    m, μ, length = 2.0, 0.5, 0.2
    κ = 2.0 * μ * off / length
    for force, expected in count.items():
        scan = np.linspace(-50.0, 50.0, 20000)
        missing = m * scan - force + κ * m * np.abs(scan)
        roots = scan[:-1][np.diff(np.sign(missing)) != 0]
        found = exact.mass_off_axis(force, m, μ, off, length)
        assert len(found) == len(roots) == expected
        assert sorted(found) == pytest.approx(sorted(roots), abs=1e-2)
    assert exact.pushed_off_axis(5.0, m, μ, length / (2.0 * μ), length) == 0.0


def test_a_rocking_block():
    """The impact by the impulse in the new corner, which stops that corner; the period by the linear equation."""
    α, R, m, g = 0.2, 1.3, 4.0, 9.81
    about_centre = m * R**2 / 3.0
    old, new = R * np.array([np.sin(α), -np.cos(α)]), R * np.array([-np.sin(α), -np.cos(α)])
    across = np.array([[0.0, -1.0], [1.0, 0.0]])
    before = -across @ old  # the centre's velocity for ω = 1 about the old corner
    free = np.block(
        [
            [m * np.eye(2), np.zeros((2, 1)), -np.eye(2)],
            [np.zeros((1, 2)), about_centre, -(across @ new)[None]],
            [np.eye(2), (across @ new)[:, None], np.zeros((2, 2))],
        ]
    )
    after = np.linalg.solve(free, [*(m * before), about_centre, 0.0, 0.0])[2]
    assert exact.rocking_block_keeps(α) == pytest.approx(after, rel=1e-12)
    p = np.sqrt(0.75 * g / R)
    quarter = exact.rocking_block_period(α, 0.1, R, g) / 4.0
    solved = solve_ivp(lambda t, y: [y[1], -(p**2) * (α - y[0])], (0.0, quarter), [0.1, 0.0], **SOLVER)
    assert solved.y[0, -1] == pytest.approx(0.0, abs=1e-11)
