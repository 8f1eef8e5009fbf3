"""Implicit steps with channels and states of elements, which each stage eliminates: orders, errors, stiff states."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mbproj.base.errors import SimulationError
from mbproj.base.registry import implicit_integrators, integrators
from mbproj.base.settings import Settings
from mbproj.commands.report.scene import facts, lines
from mbproj.commands.report.step_limits import remark
from mbproj.motion.formulations.choice import choose
from mbproj.motion.simulate import simulate
from mbproj.motion.stiffness import fastest_at, stable_steps, step_limit, steps_for_stability
from mbproj.scene.scene import read_scene
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.model.element_scenes import FORMULATIONS, PENDULUM, RATES, case, driven, run
from tests.support import ROOT, Recorder, assembled

# Implicit steps with states of elements, which are eliminated in each stage: stiff ones at the step of the mechanism,
# their orders, their errors, and who is blamed where a stage is not solved.

both = pytest.mark.parametrize("integrator", implicit_integrators())
each = pytest.mark.parametrize("formulation", FORMULATIONS)
#: How fast a state follows the cosine that it is led by, 1/s.
FAST = 1e6
FOLLOWS = f"-{FAST}*(x - cos(t))"
#: Van der Pol's oscillator with ε = 1e-6 from (2, -0.66), at t = 2 s (Hairer & Wanner's test set).
VAN_DER_POL = ("z", "((1 - x**2)*z - x)/1e-6")
AT_TWO = (1.706167732170483, -0.8928097010247975)


def run_with_states(options, **own):
    """(report, recorder, marks)."""
    return run(options, text=PENDULUM.replace("output_step: 0.05", "output_step: 0.2"), **own)


def following(t):
    """What x' = FAST (cos t - x) settles to."""
    return (FAST / (FAST + 1j) * np.exp(1j * t)).real


def fixed(formulation, integrator, step):
    return {"formulation": formulation, "integrator": integrator, "step": repr(step)}


def by_error(formulation, integrator, tolerance):
    return {"formulation": formulation, "integrator": integrator, "tolerance": repr(tolerance)}


@both
@each
def test_a_stiff_state_is_followed_at_the_step_of_the_mechanism(formulation, integrator):
    """At hλ = 1e5 the order is that of a stage, 2 or 3, of errors that are small; Newton's method takes no more passes
    than with states that do nothing, but for coupled stages that are solved one after another."""
    errors, start = [], (following(0.0), 0.0)
    for step in (0.1, 0.05):
        report, found, _ = run_with_states(fixed(formulation, integrator, step), texts=(FOLLOWS, "0*x"), start=start)
        errors.append(np.abs(found["states/value"][:, 0] - following(found["time"])).max())
        calm, _, _ = run_with_states(fixed(formulation, integrator, step), texts=("0*x", "0*x"))
        apart = integrator == "radau5"
        assert report.counters["evaluations"] <= (2.2 if apart else 1.0) * calm.counters["evaluations"]
    assert errors[0] < 1e-9
    assert np.log2(errors[0] / errors[1]) > (2.9 if integrator == "radau5" else 1.9)


@both
@each
def test_a_transient_does_not_hold_the_steps(formulation, integrator):
    """From 0 the state jumps to what leads it within some microseconds."""
    report, found, _ = run_with_states(by_error(formulation, integrator, 1e-6), texts=(FOLLOWS, "0*x"))
    assert np.abs(found["states/value"][1:, 0] - following(found["time"][1:])).max() < 1e-5
    assert report.counters["steps"] < 120


#: In NumPy a run takes seconds: with one method.
ALL = [
    (each, method)
    for each in FORMULATIONS
    for method in implicit_integrators()
    if (each, method) != ("full", "esdirk4")
]


@pytest.mark.parametrize(("formulation", "integrator"), ALL)
def test_van_der_pol(formulation, integrator):
    options = by_error(formulation, integrator, 1e-5)
    report, found, _ = run_with_states(options, until=2.0, texts=VAN_DER_POL, start=(2.0, -0.66))
    np.testing.assert_allclose(found["states/value"][-1], AT_TWO, rtol=1e-4)
    assert report.counters["steps"] < 500


@both
@each
def test_their_orders(formulation, integrator):
    """x' = x (z - x), z' = -z²: z = 2/(1 + 2t), and x of the linear equation of 1/x."""
    steps, errors = (0.2, 0.1, 0.05), []
    for step in steps:
        _, found, _ = run_with_states(
            fixed(formulation, integrator, step), texts=("x*(z - x)", "-z**2"), start=(0.5, 2.0)
        )
        t = found["time"]
        # u = 1/x: u' = 1 - z u, so u (1 + 2t) = 2 + t + t²
        exact = np.stack([(1.0 + 2.0 * t) / (2.0 + t + t**2), 2.0 / (1.0 + 2.0 * t)], axis=1)
        errors.append(np.abs(found["states/value"][-1] - exact[-1]).max())
    assert np.log2(errors[0] / errors[-1]) / 2 > integrators()[integrator].order - 0.4


@both
@each
def test_a_stage_without_a_solution_names_its_state(formulation, integrator):
    """Where the rate jumps, no x of a stage agrees with its own rate."""
    options = fixed(formulation, integrator, 0.1)
    with pytest.raises(SimulationError, match=r"state 'lag\.x'.*Newton's method"):
        run_with_states(options, texts=("-1e9*sign(x - 0.01)", "0*x"), start=(0.05, 0.0))


# States of elements that are stiff for the steps of a run: what is told, and what `auto` makes of it.

seldom_full = pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS[1:]])
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


# Implicit steps with what names channels: a motor's current and its controller, oil in a cylinder, forces that go by
# the motion of something else: orders, passes of Newton's method, and one motion in all formulations.

#: The controlled motor; forces on each body that go by the other one; and oil that is stiff beside the pendulum.
CONTROLLED = {}
UNSYMMETRIC = {
    "motor": "2*current*cos(turn) - 30*turn - 2*integral",
    "spring": "40*angle - 3*speed - 20*turn + 0.3*current",
    "rates": (RATES[0], "1 - angle*turn", RATES[2]),
}
OIL = {"motor": "2e3*current", "spring": "0*t", "rates": ("2e5*(sin(5*t) - speed)", "0*t", "-filtered")}


def run_driven(case, **options):
    """(report, recorder)."""
    system, start, settings = driven(**case, **options)
    found = Recorder()
    return simulate(system, start, settings, found), found


@cache
def exact(name, duration):
    return run_driven(globals()[name], formulation=FORMULATIONS[-1], duration=duration)[1]


def off(found, name, duration="0.2"):
    """Of angles and states at the end, beside what they range over."""
    own, worst = exact(name, duration), 0.0
    for path in ("joints/coordinate", "states/value"):
        size = 1.0 + np.abs(own[path]).max(axis=0)
        worst = max(worst, float(np.abs((found[path][-1] - own[path][-1]) / size).max()))
    return worst


@both
@each
def test_orders_with_channels(formulation, integrator):
    steps, most, less = ("0.004", "0.002"), 1e-6, 0.3
    if formulation == "full":  # in NumPy: many seconds
        steps, most, less = ("0.01", "0.005"), 1e-5, 0.7
    errors = []
    for step in steps:
        _, found = run_driven(UNSYMMETRIC, formulation=formulation, integrator=integrator, step=step, duration="0.2")
        errors.append(off(found, "UNSYMMETRIC"))
    assert errors[0] < most
    assert np.log2(errors[0] / errors[1]) > integrators()[integrator].order - less


@both
@each
@pytest.mark.parametrize("name", ["UNSYMMETRIC", "OIL"])
def test_newtons_method_knows_what_names_channels(name, formulation, integrator):
    """Its matrix is that of the equations, so that passes are few, down to round-off: 3 to 7 of each stage, and up to
    17 where coupled stages are solved one after another."""
    report, _ = run_driven(globals()[name], formulation=formulation, integrator=integrator, step="0.01", duration="0.1")
    passes = report.counters["evaluations"] / report.counters["steps"] / {"esdirk4": 5, "radau5": 3}[integrator]
    assert passes < (17.5 if integrator == "radau5" else 7.5)


@both
@each
def test_error_control_sees_what_names_channels(formulation, integrator):
    until, most = ("0.05", 100) if formulation == "full" else ("0.2", 200)  # in NumPy: seconds
    report, found = run_driven(
        CONTROLLED, formulation=formulation, integrator=integrator, tolerance="1e-7", duration=until
    )
    assert off(found, "CONTROLLED", until) < 1e-5
    assert report.counters["steps"] < most


@each
def test_stiff_oil_is_followed_in_steps_of_what_drives_it(formulation):
    """ω² = 2e3 · 2e5 / J: 47 000 rad/s, of which 10 ms do not see anything but that the rod follows sin 5t."""
    _, found = run_driven(OIL, formulation=formulation, integrator="radau5", step="0.01", duration="0.5")
    np.testing.assert_allclose(found["joints/coordinate"][-1, 0], (1.0 - np.cos(2.5)) / 5.0, atol=1e-5)
