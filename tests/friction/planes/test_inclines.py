"""A block on an incline that stands, and on one that tilts, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from tests.friction import closed_forms as exact
from tests.friction.mechanisms import STEPS, incline
from tests.stops.runs import run

G = 9.81
#: The block's coordinate along the plane is the second one, after the angle of the hinge.
SLIDES = 1


def along(recorded):
    """Where the block is at the end, and its speed."""
    return recorded["joints/coordinate"][-1, SLIDES], recorded["joints/speed"][-1, SLIDES]


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("formulation", "steps"), [("full", "dop853"), *(("reduced", steps) for steps in STEPS)])
def test_it_is_released_when_the_angle_is_that_of_static_friction(formulation, steps):
    """Released to 1e-9 s, then on its way as the linear equation has it."""
    tilting = exact.Tilting(ω=0.5, sliding=0.3, static=0.4, g=G)
    text = incline("0.5*t", "{coefficient: 0.3, static: 0.4}", duration=1.4, steps=steps, formulation=formulation)
    _, recorded = run(text)
    (slips,) = recorded.of("slip")
    assert (slips.name, slips.time) == ("friction 'friction'", pytest.approx(tilting.release, abs=1e-9))
    assert along(recorded) == pytest.approx(tilting(1.4), abs=1e-8)
    t = recorded["time"]
    still = t < tilting.release
    assert np.abs(recorded["joints/coordinate"][still, SLIDES]).max() < 1e-13
    assert recorded["friction/force"][still, 0] == pytest.approx(3.0 * G * np.sin(0.5 * t[still]), abs=1e-8)
    assert (recorded["friction/state"][:, 0] == np.where(still, 0, -1)).all()
    assert recorded.unbalanced < 1e-7


@pytest.mark.parametrize("steps", ["dop853", "rk4", "radau5"])
@pytest.mark.parametrize("static", [0.45, 0.6])
def test_it_is_thrown_up_and_comes_back_or_stays(steps, static):
    """At 0.5 rad, tan is 0.546: it comes back with g (sin - μ cos) where the static coefficient is below that."""
    text = incline("0.5", f"{{coefficient: 0.3, static: {static}}}", speed=4.0, steps=steps)
    _, recorded = run(text)
    time, way = exact.up_an_incline(0.5, 0.3, 4.0, G)
    s, rate = along(recorded)
    if static > exact.held_by(0.5):
        (sticks,) = recorded.of("stick")
        assert sticks.time == pytest.approx(time, abs=1e-9)
        assert (s, rate) == (pytest.approx(way, abs=1e-9), pytest.approx(0.0, abs=1e-12))
        assert recorded["friction/force"][-1, 0] == pytest.approx(3.0 * G * np.sin(0.5), rel=1e-9)
    else:
        down = exact.down_an_incline(0.5, 0.3, G)
        assert (s, rate) == pytest.approx((way - 0.5 * down * (2.0 - time) ** 2, -down * (2.0 - time)), abs=1e-8)
        turns = recorded["friction/state"][:, 0]
        assert (turns == np.where(recorded["time"] < time, 1, -1)).all()


def test_energy_is_lost_by_the_way_alone():
    """The plane stands still: what friction took is what potential energy has lost and kinetic energy has not."""
    text = incline("0.9", "{coefficient: 0.3}", speed=3.0, duration=1.5)
    _, recorded = run(text)
    lost = recorded["friction/dissipation"][:, 0]
    assert (np.diff(lost) >= -1e-12).all()
    up = exact.up_an_incline(0.9, 0.3, 3.0, G)[1]
    way = 2.0 * up - along(recorded)[0]
    assert lost[-1] == pytest.approx(0.3 * 3.0 * G * np.cos(0.9) * way, rel=1e-9)
    assert (np.diff(recorded["diagnostics/total_energy"]) <= 1e-9).all()
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("steps", ["radau5", "esdirk4"])
def test_regularised_by_the_force_across_it_creeps(steps):
    """tan 0.3 is 0.62 of the coefficient: it creeps down with the width times artanh of that, and never sticks."""
    text = incline("0.3", "{coefficient: 0.5, regularised: 1.0e-3}", duration=0.5, steps=steps)
    _, recorded = run(text)
    creeps = 1.0e-3 * np.arctanh(np.tan(0.3) / 0.5)
    assert recorded["joints/speed"][-1, SLIDES] == pytest.approx(-creeps, rel=1e-6)
    assert not recorded.of("stick", "slip")
