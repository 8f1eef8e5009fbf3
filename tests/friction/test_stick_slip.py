"""A mass on a belt and a pendulum: they stick and slip, against piecewise solutions and SciPy."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from tests.crossed import crossed
from tests.friction import closed_forms as exact
from tests.friction import mechanisms
from tests.friction.mechanisms import STEPS, on_a_belt
from tests.stops.runs import run

# A mass on a belt sticks and slips: the piecewise solution over 100 cycles, and Stribeck's law by SciPy.

BELT = exact.Belt(m=2.0, k=300.0, v=0.1, sliding=6.0, static=9.0)


def place(recorded):
    """Where the mass is over the ground: the belt's way and its own on the belt."""
    return recorded["joints/coordinate"].sum(axis=1)


def times(recorded, kind):
    return np.array([event.time for event in recorded.of(kind)])


def test_a_hundred_cycles():
    """Period and amplitude to 1e-6 of them over 100 cycles: each stick forgets the errors before it."""
    duration = BELT.first_slip + 100.5 * BELT.period
    _, recorded = run(on_a_belt(BELT, "{force: 6, static: 9}", duration=duration))
    slips, sticks = times(recorded, "slip"), times(recorded, "stick")
    assert len(slips) == 101
    assert slips == pytest.approx(BELT.first_slip + BELT.period * np.arange(101), abs=1e-6 * BELT.period)
    assert sticks - slips[: len(sticks)] == pytest.approx(BELT.slips, abs=1e-7)
    assert place(recorded) == pytest.approx(
        np.where(recorded["time"] < BELT.first_slip, BELT.v * recorded["time"], BELT(recorded["time"])),
        abs=1e-6 * BELT.amplitude,
    )
    assert recorded.unbalanced < 1e-6


@pytest.mark.parametrize(
    ("formulation", "steps"),
    [("planar", "rk4"), ("planar", "dopri5"), ("planar", "radau5"), ("planar", "esdirk4"), ("reduced", "dop853")],
)
def test_a_few_cycles(formulation, steps):
    duration = BELT.first_slip + 5.5 * BELT.period
    text = on_a_belt(BELT, "{force: 6, static: 9}", duration=duration, steps=steps, formulation=formulation)
    _, recorded = run(text)
    slips = times(recorded, "slip")
    assert slips == pytest.approx(BELT.first_slip + BELT.period * np.arange(6), abs=1e-6 * BELT.period)
    drawn = place(recorded)[recorded["time"] > BELT.first_slip]
    assert drawn == pytest.approx(BELT(recorded["time"][recorded["time"] > BELT.first_slip]), abs=1e-7)


def test_a_run_of_fixed_steps_may_end_at_a_slip():
    """The last slip falls short of the end by round-off, and there is no whole step any more."""
    duration = BELT.first_slip + 10.0 * BELT.period
    steps = f"integrator: dopri5, step: {duration / 1000}, output_step: {duration / 1000}"
    _, recorded = run(on_a_belt(BELT, "{force: 6, static: 9}", duration=duration, steps=steps))
    assert place(recorded)[-1] == pytest.approx(BELT.static / BELT.k, abs=1e-9)
    assert len(recorded["time"]) == 1001


def test_the_belt_pays_what_friction_takes():
    """Over whole cycles: the work of the motion is the friction's loss, sliding force times the way that slips."""
    duration = BELT.first_slip + 10.0 * BELT.period
    steps = f"integrator: dop853, tolerance: 1.0e-11, output_step: {duration / 500}"
    _, recorded = run(on_a_belt(BELT, "{force: 6, static: 9}", duration=duration, steps=steps))
    slipped = 10.0 * (BELT.v * BELT.slips + 2.0 * BELT.drop)
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(BELT.sliding * slipped, rel=1e-8)
    stored = 0.5 * BELT.static**2 / BELT.k + 0.5 * BELT.m * BELT.v**2
    start = 0.5 * BELT.m * BELT.v**2
    assert recorded["diagnostics/work"][-1] == pytest.approx(BELT.sliding * slipped + stored - start, rel=1e-8)


def cycle_with_stribeck(belt, speed):
    """The lengths of slip and stick of the limit cycle with Stribeck's law, by SciPy."""
    from scipy.integrate import solve_ivp

    def force(slip):
        return belt.sliding + (belt.static - belt.sliding) * np.exp(-((slip / speed) ** 2))

    def caught(t, y):
        return y[1] - belt.v

    caught.terminal, caught.direction = True, 1
    solved = solve_ivp(
        lambda t, y: [y[1], (force(belt.v - y[1]) - belt.k * y[0]) / belt.m],
        (0.0, 10.0),
        [belt.static / belt.k, belt.v],
        method="DOP853",
        events=caught,
        rtol=1e-12,
        atol=1e-14,
    )
    return solved.t_events[0][-1], (belt.static / belt.k - solved.y_events[0][-1][0]) / belt.v


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_with_stribecks_law(formulation):
    """The force falls from the static one as the slip grows, and at its start more slowly than the spring pulls."""
    stribeck = 0.03
    slips, sticks = cycle_with_stribeck(BELT, stribeck)
    coulomb = f"{{force: 6, static: 9, stribeck_speed: {stribeck}}}"
    _, recorded = run(on_a_belt(BELT, coulomb, duration=2.0, formulation=formulation))
    let_go, caught = times(recorded, "slip"), times(recorded, "stick")
    held = let_go[1:] - caught[: len(let_go) - 1]
    assert held == pytest.approx(sticks, abs=1e-7)
    assert caught - let_go[: len(caught)] == pytest.approx(slips, abs=1e-7)
    assert recorded.unbalanced < 1e-7


@pytest.mark.parametrize("output_step", [1.0, 0.5, 0.3, 0.05])
def test_a_box_pushed_to_and_fro_slips_twice_a_cycle_whatever_is_recorded(output_step):
    """At rest nothing limits a step: the push, 14 sin 6t N, swings to and fro within one. It overcomes 0.4 m g = 12 N
    first at 6 t = arcsin(12 / 14)."""
    scene = f"""
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: {10 * np.pi / 3}, integrator: dop853, tolerance: 1.0e-9, output_step: {output_step}}}
bodies:
  box: {{mass: 3, inertia: [0.1, 0.15, 0.12], position: [0, 0, 0]}}
forces:
  foot:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: box, location: [0, 0, 0]}}
    rigid: true
    friction: {{coefficient: 0.3, static: 0.4}}
  push: {{type: force, body: box, location: [0, 0, 0], axes: global, force: ["14*sin(6*t)", 0, 0]}}
"""
    with mbproj.run(scene) as results:
        slips = [event.time for event in results.events if event.kind == "slip"]
    each = (np.arcsin(12.0 / 14.0) + np.pi * np.arange(20)) / 6.0
    np.testing.assert_allclose(slips, each, atol=1e-8)


# A pendulum with friction in its pivot: amplitudes by energy, states by SciPy, and the orders of methods from turn to
# turn.

START, TORQUE, ARM = 1.2, 0.8, 0.08


def ends(recorded):
    return np.array([recorded["joints/coordinate"][-1, 0], recorded["joints/speed"][-1, 0]])


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_it_swings_lower_each_time_and_stays_where_it_is_held(formulation):
    """Each swing loses torque × way; it rests where m g l sin θ is below the torque."""
    amplitudes = [START]
    held = np.arcsin(TORQUE / (mechanisms.MASS * mechanisms.G * mechanisms.LENGTH))
    while amplitudes[-1] > held:
        amplitudes.append(mechanisms.next_amplitude(amplitudes[-1], TORQUE))
    text = mechanisms.pendulum(f"{{torque: {TORQUE}}}", duration=8.0, formulation=formulation)
    _, recorded = run(text)
    side = (-1) ** (len(amplitudes) - 1)
    assert len(amplitudes) > 4
    assert ends(recorded) == pytest.approx([side * amplitudes[-1], 0.0], abs=1e-9)
    hanging = mechanisms.MASS * mechanisms.G * mechanisms.LENGTH * np.sin(side * amplitudes[-1])
    assert recorded["friction/force"][-1, 0] == pytest.approx(hanging, rel=1e-8)
    way = amplitudes[0] + 2.0 * sum(amplitudes[1:-1]) + amplitudes[-1]
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(TORQUE * way, rel=1e-8)
    assert np.diff(recorded["diagnostics/total_energy"]).max() < 1e-9
    assert recorded.unbalanced < 1e-7


@crossed("formulation, steps", ["planar", "reduced"], STEPS, together=1)
def test_the_force_in_the_pivot_makes_the_friction(formulation, steps):
    """Friction arm |F|, where F has the acceleration in it that friction changes: through two turns."""
    state, turns = mechanisms.swing(mechanisms.by_the_force(ARM), START, 0.0, 2.2)
    assert len(turns) == 2
    text = mechanisms.pendulum(
        f"{{coefficient: {ARM / 0.2}, radius: 0.2}}", duration=2.2, steps=steps, formulation=formulation
    )
    _, recorded = run(text)
    assert ends(recorded) == pytest.approx(state, abs=1e-8 if steps != "rk4" else 1e-7)


@crossed(
    "integrator, order, step, law",
    [pytest.param("rk4", 4, 0.04), pytest.param("dopri5", 5, 0.055), pytest.param("dop853", 8, 0.11)],
    ["constant", "by the force"],
    together=1,
)
def test_methods_keep_their_order_from_turn_to_turn(integrator, order, step, law):
    """Fixed steps that end at the turns: half the step, 2^-order of the error."""
    coulomb = f"{{torque: {TORQUE}}}" if law == "constant" else f"{{coefficient: {ARM / 0.2}, radius: 0.2}}"
    acceleration = mechanisms.constant(TORQUE) if law == "constant" else mechanisms.by_the_force(ARM)
    state, turns = mechanisms.swing(acceleration, START, 0.0, 2.2)
    assert len(turns) == 2
    errors = []
    for size in (step, 0.5 * step, 0.25 * step):
        steps = f"integrator: {integrator}, step: {size}, output_step: 2.2"
        _, recorded = run(mechanisms.pendulum(coulomb, duration=2.2, steps=steps))
        errors.append(np.abs(ends(recorded) - state).max())
    orders = -np.diff(np.log2(errors))
    assert orders.max() < order + 1.5
    assert orders.mean() > order - 0.5
