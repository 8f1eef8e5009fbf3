"""States of elements that are stiff for the steps of a run: what is told, and what `auto` makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj.api.check.fast_forces import facts, lines
from mbproj.cli.simulate.step_limits import remark
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.stiff.fast_forces import fastest_at, stable_steps, steps_for_stability
from mbproj.integrate.stiff.step_limits import step_limit
from mbproj.scene import Settings, read_scene
from tests.crossed import full
from tests.kernel.scenes import assembled, needs_kernel
from tests.model.element_scenes import FORMULATIONS, case, run
from tests.support import ROOT

seldom_full = pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS[1:]])
each = pytest.mark.parametrize("formulation", FORMULATIONS)
#: λ = -5000 1/s, and a pair that vibrates with 400 rad/s and damping 0.1.
LAG = ("-5000*(x - cos(t))", "x - z")
VIBRATES = ("z", "-1.6e5*x - 80*z")


def options(formulation, **keys):
    return {"formulation": formulation, "integrator": "rk4"} | keys


@seldom_full
def test_fixed_steps_beyond_stability_name_the_state_and_its_rate(formulation):
    """|λ| h = 5000 · 1 ms = 5 and R(-5) = 13.7; up to 2.785 rk4 is stable."""
    with pytest.raises(SimulationError) as stopped:
        run(options(formulation, step="0.001"), texts=LAG, start=(0.0, 0.0))
    assert stopped.value.where == "state 'lag.x'"
    assert "|λ| h = 5 at 5e+03 1/s, and rk4 is stable up to 2.79" in stopped.value.cause
    assert "errors grow 13.7-fold" in stopped.value.cause
    assert stopped.value.hint.startswith("take steps of 0.0005 s or less, ")
    assert "slower states; esdirk4 or radau5 is not held up by it" in stopped.value.hint


@seldom_full
def test_steps_held_for_stability_name_the_states(formulation):
    report, _, _ = run(options(formulation, integrator="dopri5", tolerance="1e-5"), texts=VIBRATES)
    assert report.stiffness.startswith("states 'lag.x', 'lag.z' are stiff and hold the step at 0.00")
    assert "at 400 1/s, and dopri5 is stable up to 2.7)" in report.stiffness


@each
def test_auto_takes_an_implicit_method(formulation):
    lags = ("-1e5*(x - cos(t))", "x - z")
    report, found, _ = run(options(formulation, integrator="auto", tolerance="1e-6"), texts=lags)
    assert any("state 'lag.x'" in line and "esdirk4" in line for line in report.methods)
    np.testing.assert_allclose(found["states/value"][1:, 0], np.cos(found["time"][1:] - 1e-5), atol=1e-5)
    assert report.counters["steps"] < 1000


def test_a_vibration_that_is_damped_is_told_in_words_of_states():
    report, _, _ = run(options("full", integrator="radau5", step="0.05"), texts=("z", "-1e6*x"))
    assert report.stiffness.startswith("states 'lag.")
    assert "vibrate with 159 Hz; radau5 damps that by" in report.stiffness
    assert "masses" not in report.stiffness


def test_the_fastest_modes_at_the_start():
    """Both roots of λ² + 80 λ + 1.6e5 by their states; of RK4 the step is √8 / 400 s, or nearly."""
    _, system, state, settings = case(options("full", step="0.001"), texts=VIBRATES)
    found = fastest_at(choose(system, state, settings), system, state)
    assert found[0].eigenvalue == pytest.approx(-40.0 + 1j * np.sqrt(1.6e5 - 1600.0))
    assert set(found[0].states) == {"lag.x", "lag.z"}
    assert found[0].forces == found[0].bodies == ()
    assert found[1].forces == ("damper",)
    steps = stable_steps(found)
    assert steps["rk4"] == pytest.approx(np.sqrt(8.0) / 400.0, rel=0.1)
    assert facts(found, steps)["fast_modes"][0]["states"] == list(found[0].states)
    told = lines(found, steps)
    assert "forces and states" in told[0]
    assert "'lag." in told[1] and "vibrates with 63.3 Hz" in told[1]
    assert steps_for_stability(system, state, settings) > 50.0


def test_a_step_is_limited_by_a_state():
    _, system, state, settings = case(options("full", integrator="dopri5", tolerance="1e-6"), texts=LAG)
    limit = step_limit(system, state, settings, 6e-4)
    assert limit.shares[0][0] == "state lag.x"
    assert limit.reason.startswith("state 'lag.x': |λ| h = 3")
    assert remark([replace(limit, reason="")]).startswith("steps limited by state lag.x at 0 s")


@needs_kernel
@pytest.mark.parametrize("integrator", ["esdirk4", "radau5"])
def test_the_error_of_an_implicit_step_falls_with_its_order(integrator):
    """Both estimates are of order 3: the error of a step is of order 4."""
    system, state = assembled(read_scene(ROOT / "mechanisms" / "quarter_car.yaml"))
    settings = Settings(tolerance=1e-8, integrator=integrator)
    long, short = (step_limit(system, state, settings, h) for h in (5e-3, 2.5e-3))
    assert long.error / short.error == pytest.approx(16.0, rel=0.1)
    assert [name for name, _ in short.shares[:2]] == ["upper_arm", "tie_rod"]
    assert sum(share for _, share in short.shares) == pytest.approx(1.0)
