"""Impacts and contact against closed forms, in every formulation, with fixed steps and with error control."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import SimulationError
from tests.crossed import full
from tests.stops.runs import DOP853, FIXED, run
from tests.stops.scenes import BALL, BETWEEN_WALLS, CRADLE, DRIVEN, PRESSED, ROD

IN_A_PLANE = ("planar", "reduced", "full")


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("formulation", "steps", "e"),
    [
        ("reduced", DOP853, 0.5),
        ("reduced", DOP853, 0.9),
        ("reduced", FIXED, 0.5),
        ("reduced", FIXED, 0.9),
        ("full", "integrator: rk4, step: 0.1", 0.5),
    ],
)
def test_bounces_are_a_geometric_series_that_comes_to_rest(formulation, steps, e):
    first = np.sqrt(0.2)
    rests = first * (1.0 + e) / (1.0 - e)
    _, recorded = run(BALL.format(duration=rests + 0.5, steps=steps, formulation=formulation, e=e))
    times = [event.time for event in recorded.of("impact")]
    expected = first + 2.0 * first * np.concatenate([[0.0], np.cumsum(e ** np.arange(1, len(times)))])
    assert len(times) > 10
    assert np.abs(times - expected).max() < 1e-9
    (rest,) = recorded.of("rest")
    assert abs(rest.time - rests) < 1e-9
    assert np.abs(recorded["stops/gap"][-1]).max() < 1e-12
    assert recorded["stops/force"][-1] == pytest.approx(20.0, rel=1e-9)
    assert recorded["bodies/position"][-1, 0, 0] == pytest.approx(rests + 0.5, abs=1e-9)
    lost = sum(event.energy for event in recorded.of("impact"))
    assert lost == pytest.approx(20.0, rel=1e-9)
    assert recorded.unbalanced < 1e-9


@pytest.mark.parametrize("steps", [DOP853, FIXED])
@pytest.mark.parametrize("formulation", IN_A_PLANE)
def test_a_rod_that_strikes_a_stop(formulation, steps):
    """Impulse (1 + e) I ω / lever, with I about the hinge, and the energy that Newton's law takes."""
    if formulation == "full" and steps == FIXED:
        steps = "integrator: rk4, step: 0.01"
    _, recorded = run(ROD.format(steps=steps, formulation=formulation))
    (struck,) = recorded.of("impact")
    angle, inertia = np.arcsin(0.5), 0.25 + 3.0 * 0.25
    assert struck.time == pytest.approx(angle / 2.0, abs=1e-9)
    assert struck.impulse == pytest.approx(1.5 * inertia * 2.0 / (0.8 * np.cos(angle)), rel=1e-10)
    assert struck.energy == pytest.approx(0.5 * inertia * 4.0 * (1.0 - 0.25), rel=1e-10)
    assert recorded["joints/speed"][-1, 0] == pytest.approx(1.0, rel=1e-9)
    assert recorded["joints/violation"].max() < 1e-13
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("formulation", ["reduced", "full"])
def test_a_cradle_in_sequence(formulation):
    steps = DOP853 if formulation == "reduced" else "integrator: rk4, step: 0.25"
    _, recorded = run(CRADLE.format(steps=steps, formulation=formulation, third=0.4, e=1))
    assert [event.name for event in recorded.of("impact")] == ["stop 'left'", "stop 'right'"]
    assert [event.time for event in recorded.of("impact")] == pytest.approx([0.25, 0.35], abs=1e-9)
    assert recorded["bodies/velocity"][-1, :, 0] == pytest.approx([0.0, 0.0, 2.0], abs=1e-9)
    assert recorded.unbalanced < 1e-9


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_balls_that_touch_are_struck_as_one(e):
    """Newton's law gives the two that touch one speed: with e = 1 the first comes back, as no cradle does."""
    _, recorded = run(CRADLE.format(steps=DOP853, formulation="reduced", third=0.2, e=e))
    together = 2.0 * (1.0 + e) / 3.0
    after = [together - 2.0 * e, together, together]
    assert recorded["bodies/velocity"][-1, :, 0] == pytest.approx(after, abs=1e-9)
    assert sum(recorded["bodies/velocity"][-1, :, 0]) == pytest.approx(2.0, abs=1e-9)


@pytest.mark.parametrize("steps", [DOP853, FIXED])
@pytest.mark.parametrize("formulation", [full(each) if each == "full" else each for each in IN_A_PLANE])
def test_contact_ends_where_its_force_does(formulation, steps):
    """The block is lifted from when 40 sin 2t is its weight, 20 N; it lands, and is lifted a period later."""
    if formulation == "full":
        steps = "integrator: rk4, step: 0.02" if steps == FIXED else DOP853
    _, recorded = run(PRESSED.format(steps=steps, formulation=formulation))
    lifted = [event.time for event in recorded.of("release")]
    first = 0.5 * np.arcsin(0.5)
    assert lifted == pytest.approx([first, first + np.pi], abs=1e-9 if steps == DOP853 else 1e-7)
    push, time = recorded["stops/force"][:, 0], recorded["time"]
    resting = time < first
    assert push[resting] == pytest.approx(20.0 - 40.0 * np.sin(2.0 * time[resting]), abs=1e-9)
    assert push.min() >= 0.0
    assert recorded["stops/gap"].min() > -1e-12


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_pendulum_between_two_walls(formulation):
    """From wall to wall by the pendulum's equation alone; each wall takes 1 - e² of the energy there."""
    from scipy.integrate import quad

    _, recorded = run(BETWEEN_WALLS.format(steps=DOP853, formulation=formulation, e=1))
    inertia, weight = 1.01, 10.0

    def speed(angle):
        return np.sqrt(1.0 - 2.0 * weight * (1.0 - np.cos(angle)) / inertia)

    half = quad(lambda angle: 1.0 / speed(angle), 0.0, 0.1, epsabs=1e-13)[0]
    times = [event.time for event in recorded.of("impact")]
    assert times == pytest.approx(half * (1.0 + 2.0 * np.arange(len(times))), abs=1e-8)
    _, recorded = run(BETWEEN_WALLS.format(steps=DOP853, formulation=formulation, e=0.8))
    first = recorded.of("impact")[0]
    assert first.energy == pytest.approx(0.5 * inertia * speed(0.1) ** 2 * (1.0 - 0.64), rel=1e-8)
    assert recorded.unbalanced < 1e-8


def test_balls_of_unequal_restitution_lose_energy():
    """The two that touch part with what the second stop asks for; none of it is new."""
    text = CRADLE.format(steps=DOP853, formulation="reduced", third=0.2, e=1)
    _, recorded = run(text.replace("restitution: 1\n  right", "restitution: 0.1\n  right"))
    assert sum(recorded["bodies/velocity"][-1, :, 0]) == pytest.approx(2.0, abs=1e-9)
    assert recorded["diagnostics/kinetic_energy"][-1] < 2.0
    assert recorded.unbalanced < 1e-9


def test_a_motion_pushes_and_pays():
    """The pusher strikes the block at 0.5 s, keeps its speed of 1 m/s, and works twice what the block gets."""
    _, recorded = run(DRIVEN.format(steps=DOP853, wall="rigid: true").replace("duration: 1", "duration: 0.7"))
    (struck,) = recorded.of("impact")
    assert (struck.time, struck.impulse, struck.energy) == pytest.approx((0.5, 2.0, 1.0), rel=1e-9)
    assert recorded["bodies/velocity"][-1, :, 0] == pytest.approx([1.0, 1.0], abs=1e-10)
    assert recorded["diagnostics/work"][-1] == pytest.approx(2.0, rel=1e-9)
    assert recorded.unbalanced < 1e-9


def test_a_motion_against_a_rigid_stop_ends_the_run_there():
    with pytest.raises(SimulationError, match=r"t = 0.8 s.*driven into") as failed:
        run(DRIVEN.format(steps=DOP853, wall="rigid: true"))
    assert "touch" in str(failed.value) or "guide" in str(failed.value)


def test_a_motion_against_a_compliant_stop_tells_the_force():
    _, recorded = run(DRIVEN.format(steps=DOP853, wall="stiffness: 1.0e4"))
    assert recorded["stops/force"][-1] == pytest.approx([2.0e3, 2.0e3], rel=1e-6)


TOUCHING = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  slider: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints:
  guide:
    type: prismatic
    bodies: [ground, slider]
    location: [0, 0, 0]
    axis: [1, 0, 0]
    limits: {{displacement: {{range: [0, 1], rigid: true}}}}
forces:
  push: {{type: force, body: slider, location: [0, 0, 0], axes: global, force: ["{push}", 0, 0]}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_what_touches_is_held_from_when_it_is_pressed_on(formulation):
    """The push grows from nothing at 0.5 s, and is nothing again at 0.9 s: from there it is pulled off."""
    push = "-30*max(0, t - 0.5)*(0.9 - t)"
    text = TOUCHING.format(duration=1.0, steps=DOP853, formulation=formulation, push=push)
    _, recorded = run(text)
    assert [event.kind for event in recorded.happened if "stop" in event.name] == ["contact", "release"]
    assert [event.time for event in recorded.of("contact", "release")] == pytest.approx([0.5, 0.9], abs=1e-9)
    x = recorded["bodies/position"][:, 0, 0]
    assert np.abs(x[:-1]).max() < 1e-15
    assert x[-1] == pytest.approx(15.0 * (0.4 * 0.1**3 / 6.0 + 0.1**4 / 12.0), rel=1e-8)
