"""Implicit steps with what names channels: a motor's current and its controller, oil in a cylinder, forces that go by
the motion of something else: orders, passes of Newton's method, and one motion in all formulations."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mbproj.integrate import simulate
from mbproj.registry import implicit_integrators, integrators
from tests.model.element_scenes import FORMULATIONS, RATES, driven
from tests.support import Recorder

both = pytest.mark.parametrize("integrator", implicit_integrators())
each = pytest.mark.parametrize("formulation", FORMULATIONS)
#: The controlled motor; forces on each body that go by the other one; and oil that is stiff beside the pendulum.
CONTROLLED = {}
UNSYMMETRIC = {
    "motor": "2*current*cos(turn) - 30*turn - 2*integral",
    "spring": "40*angle - 3*speed - 20*turn + 0.3*current",
    "rates": (RATES[0], "1 - angle*turn", RATES[2]),
}
OIL = {"motor": "2e3*current", "spring": "0*t", "rates": ("2e5*(sin(5*t) - speed)", "0*t", "-filtered")}


def run(case, **options):
    """(report, recorder)."""
    system, start, settings = driven(**case, **options)
    found = Recorder()
    return simulate(system, start, settings, found), found


@cache
def exact(name, duration):
    return run(globals()[name], formulation=FORMULATIONS[-1], duration=duration)[1]


def off(found, name, duration="0.2"):
    """Of angles and states at the end, beside what they range over."""
    own, worst = exact(name, duration), 0.0
    for path in ("joints/coordinate", "states/value"):
        size = 1.0 + np.abs(own[path]).max(axis=0)
        worst = max(worst, float(np.abs((found[path][-1] - own[path][-1]) / size).max()))
    return worst


@both
@each
def test_their_orders(formulation, integrator):
    steps, most, less = ("0.004", "0.002"), 1e-6, 0.3
    if formulation == "full":  # in NumPy: many seconds
        steps, most, less = ("0.01", "0.005"), 1e-5, 0.7
    errors = []
    for step in steps:
        _, found = run(UNSYMMETRIC, formulation=formulation, integrator=integrator, step=step, duration="0.2")
        errors.append(off(found, "UNSYMMETRIC"))
    assert errors[0] < most
    assert np.log2(errors[0] / errors[1]) > integrators()[integrator].order - less


@both
@each
@pytest.mark.parametrize("name", ["UNSYMMETRIC", "OIL"])
def test_newtons_method_knows_what_names_channels(name, formulation, integrator):
    """Its matrix is that of the equations, so that passes are few, down to round-off: 3 to 7 of each stage, and up to
    17 where coupled stages are solved one after another."""
    report, _ = run(globals()[name], formulation=formulation, integrator=integrator, step="0.01", duration="0.1")
    passes = report.counters["evaluations"] / report.counters["steps"] / {"esdirk4": 5, "radau5": 3}[integrator]
    assert passes < (17.5 if integrator == "radau5" else 7.5)


@both
@each
def test_error_control_sees_what_names_channels(formulation, integrator):
    until, most = ("0.05", 100) if formulation == "full" else ("0.2", 200)  # in NumPy: seconds
    report, found = run(CONTROLLED, formulation=formulation, integrator=integrator, tolerance="1e-7", duration=until)
    assert off(found, "CONTROLLED", until) < 1e-5
    assert report.counters["steps"] < most


@each
def test_stiff_oil_is_followed_in_steps_of_what_drives_it(formulation):
    """ω² = 2e3 · 2e5 / J: 47 000 rad/s, of which 10 ms do not see anything but that the rod follows sin 5t."""
    _, found = run(OIL, formulation=formulation, integrator="radau5", step="0.01", duration="0.5")
    np.testing.assert_allclose(found["joints/coordinate"][-1, 0], (1.0 - np.cos(2.5)) / 5.0, atol=1e-5)
