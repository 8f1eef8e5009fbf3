"""simulate(): output times, samples inside steps, schedules, counters, turns, and failures with time and joint."""

from __future__ import annotations

import os
import signal
import sys
import threading
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis.strategies import floats

from mbproj import read_scene, read_scene_text, settings_to_run, simulate
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.scene.records import Body, Joint, Pair
from mbproj.scene.sampling import output_times, whole_steps
from tests.kernel.scenes import ROUND, needs_kernel, run, spinner
from tests.support import ROOT, Recorder, assembled, random_chain, scene_of


@pytest.fixture
def chain():
    return random_chain(12, ["revolute", "universal", "spherical"])


def test_fixed_steps_end_at_the_duration_with_one_shorter_step():
    recorder, report = run(spinner(1.0), duration=1.0, step=0.03)
    assert report.counters["steps"] == 34
    np.testing.assert_allclose(recorder["time"], [*(0.03 * np.arange(34)), 1.0], rtol=1e-15)
    assert recorder["diagnostics/step_size"][-1] == pytest.approx(0.01)


def test_time_does_not_drift():
    """t = t0 + k h: 0.1 added 100 times is not 10."""
    recorder, _ = run(spinner(1.0), duration=10.0, step=0.1)
    assert recorder["time"][30] == 30 * 0.1
    assert recorder["time"][-1] == 10.0
    assert whole_steps(Settings(duration=10.0, step=0.1)) == 100


@pytest.mark.parametrize("way", [{"step": 0.01, "integrator": "rk4"}, {"tolerance": 1e-6, "integrator": "dopri5"}])
def test_recording_does_not_change_the_motion(chain, way):
    fine, fine_report = run(chain, duration=0.4, output_step=0.01, **way)
    coarse, coarse_report = run(chain, duration=0.4, output_step=0.2, **way)
    np.testing.assert_array_equal(fine["bodies/position"][-1], coarse["bodies/position"][-1])
    assert fine_report.counters["steps"] == coarse_report.counters["steps"]
    assert len(fine["time"]) == 41
    assert len(coarse["time"]) == 3
    np.testing.assert_array_equal(fine["bodies/velocity"][20], coarse["bodies/velocity"][1])


@pytest.mark.parametrize("integrator", ["bs32", "dopri5", "dop853"])
def test_error_control_keeps_what_it_promises(chain, integrator):
    """A hundred times tighter tolerance: a much smaller error at the end, with closed joints at every output."""
    exact, _ = run(chain, duration=0.5, tolerance=1e-12, integrator="dop853", output_step=0.05)
    errors = []
    for tolerance in (1e-5, 1e-7):
        recorder, _ = run(chain, duration=0.5, tolerance=tolerance, integrator=integrator, output_step=0.05)
        errors.append(np.abs(recorder["markers/position"] - exact["markers/position"]).max())
        assert recorder["diagnostics/position_violation"].max() <= 1e-13
        assert recorder["diagnostics/velocity_violation"].max() <= 1e-12
    assert errors[0] < 1e-3
    assert errors[1] < 0.1 * errors[0]


@pytest.mark.parametrize("formulation", ["planar", "full"])
def test_the_largest_violation_is_that_of_the_samples_too(formulation):
    """Samples inside steps are closed as far as the projection asks for, which is less than steps reach."""
    settings = {"duration": "0.3", "integrator": "dopri5", "tolerance": "1e-8", "formulation": formulation}
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, settings)
    recorder = Recorder()
    report = simulate(*assembled(scene), scene.settings, recorder)
    recorded = recorder["diagnostics/position_violation"].max()
    assert recorded > 1e-14
    assert report.position_violation.value == pytest.approx(recorded, abs=2e-15)


def test_output_times_include_the_end_once():
    times = output_times(Settings(duration=1.0, tolerance=1e-6, output_step=0.3), 0.0)
    np.testing.assert_allclose(times, [0.0, 0.3, 0.6, 0.9, 1.0])
    assert len(output_times(Settings(duration=1.0, tolerance=1e-6, output_step=0.1), 0.0)) == 11


@pytest.mark.parametrize("name", [name for name in PROJECTIONS if name != "popm"])
def test_every_method_runs_and_says_what_it_did(chain, name):
    options = {"alpha": 1e7} if "alpha" in PROJECTIONS[name].options else {}
    options |= {"gains": (25.0, 25.0)} if name == "baumgarte" else {}
    recorder, report = run(chain, duration=0.2, step=0.01, projection={"method": name, **options})
    corrects = PROJECTIONS[name].corrects
    assert report.counters["projections"] == (20 if corrects else 0)
    assert report.counters["projection_failures"] == 0
    assert report.counters["evaluations"] == 4 * 20 + 1
    assert report.position_violation.value == pytest.approx(recorder["diagnostics/position_violation"].max(), abs=4e-15)
    assert (report.position_violation.value <= 1e-13) == corrects


def test_bordered_and_eliminated_accelerations_give_the_same_motion(chain):
    bordered, _ = run(chain, duration=0.2, step=0.01, acceleration="bordered")
    eliminated, _ = run(chain, duration=0.2, step=0.01, acceleration="eliminated")
    np.testing.assert_allclose(eliminated["bodies/position"], bordered["bodies/position"], atol=1e-10)
    size = np.abs(bordered["joints/reaction_force"]).max()
    np.testing.assert_allclose(eliminated["joints/reaction_force"], bordered["joints/reaction_force"], atol=1e-8 * size)


def test_schedules_save_projections(chain):
    _, every = run(chain, duration=0.4, step=0.01, projection={"every": 4})
    assert every.counters["projections"] == 10
    _, threshold = run(chain, duration=0.4, step=0.01, projection={"threshold": 1e-10})
    assert 0 < threshold.counters["projections"] < 40
    assert threshold.position_violation.value <= 1e-10


def test_turns_are_counted_even_when_a_step_turns_more_than_half_round():
    """200 rad/s over steps of 0.02 s is 4 rad a step."""
    recorder, _ = run(spinner(200.0), duration=1.0, step=0.02, integrator="dop853")
    np.testing.assert_allclose(recorder["joints/coordinate"][:, 0], 200.0 * recorder["time"], rtol=1e-3)
    assert np.all(np.abs(np.diff(recorder["joints/coordinate"][:, 0])) > np.pi)


def test_energy_drift_falls_with_the_order_of_the_method(chain):
    drifts = [run(chain, duration=0.4, step=step, integrator="rk4")[1].energy_drift for step in (0.01, 0.005)]
    assert np.log2(drifts[0] / drifts[1]) > 3.5


def test_popm_is_refused_with_euler_parameters(chain):
    with pytest.raises(InputError, match="'popm' needs a positive definite mass matrix"):
        run(chain, duration=0.1, step=0.01, formulation="full", projection={"method": "popm"})


def test_a_step_far_too_large_stops_with_the_time():
    with pytest.raises(SimulationError) as caught:
        run(random_chain(12, ["spherical"] * 3), duration=1000.0, step=20.0, projection={"method": "none"})
    assert caught.value.time == 20.0
    assert "it has drifted open by" in str(caught.value)
    assert caught.value.hint == "use a projection method, gpopm for example, or a smaller step"


def folded_slider_crank():
    """Crank and rod of one length, straight up from the pivot and back down to it: the slider may move or stay."""
    up, across = Pair((0.0, 1.0, 0.0), (0.0, 1.0, 0.0)), Pair((1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    pivot, top = Pair((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), Pair((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    names = {"crank": 0.5, "rod": 0.5, "block": 0.0}
    return scene_of(
        [Body(name, 1.0, ROUND, (0.0, 0.0, height)) for name, height in names.items()],
        [
            Joint("A", "revolute", ("ground", "crank"), pivot, up),
            Joint("B", "spherical", ("crank", "rod"), top),
            Joint("C", "universal", ("rod", "block"), pivot, Pair((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))),
            Joint("D", "prismatic", ("ground", "block"), pivot, across),
        ],
    )


def test_a_singular_start_is_refused_with_the_joint():
    with pytest.raises(InputError, match="joint 'D' is redundant: 2 of its constraints already follow"):
        run(folded_slider_crank(), duration=1.0, step=0.01)


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_hands_over_what_it_computed(chain, signum):
    before = signal.getsignal(signum)
    recorder = Recorder()
    system, state = assembled(chain)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signum))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        simulate(system, state, Settings(duration=1e4, step=0.01), recorder)
    timer.join()
    times = recorder["time"]
    assert len(times) > 5
    np.testing.assert_allclose(np.diff(times), 0.01)
    assert signal.getsignal(signum) is before


def test_a_failed_run_hands_over_what_it_computed(chain):
    recorder = Recorder()
    system, state = assembled(chain)
    with pytest.raises(SimulationError):
        simulate(
            system,
            state.changed(velocities=1e3 * state.v),
            Settings(duration=1.0, step=0.05, projection=ProjectionSettings(max_iterations=1)),
            recorder,
        )
    assert len(recorder["time"]) >= 1
    assert np.all(np.isfinite(recorder["bodies/position"]))


def test_a_run_can_start_from_where_another_ended(chain):
    """Two halves are the whole, to the bits of fixed steps."""
    system, start = assembled(chain)
    settings = Settings(duration=0.4, step=0.01)
    whole = simulate(system, start, settings).state
    half = simulate(system, start, replace(settings, duration=0.2)).state
    again = simulate(system, half, replace(settings, duration=0.2)).state
    assert (half.t, whole.t, again.t) == pytest.approx((0.2, 0.4, 0.4))
    np.testing.assert_allclose(again.y, whole.y, atol=1e-12)


# Samples inside a step: recorded on the constraints, or the run says why not.

QUICK_RETURN = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, integrator: dop853, tolerance: 0.021, output_step: 0.001, kinematic: false}
bodies:
  crank: {mass: 1, shape: {rod: {length: 0.1, axis: x}}, position: [0.05, 0, 0.2]}
  rocker:
    mass: 2
    shape: {rod: {length: 0.5, axis: x}}
    position: [0.1118, 0, 0.2236]
    orientation: {axis: [0, -1, 0], angle: 63.43 deg}
  link: {mass: 0.5, shape: {rod: {length: 0.2, axis: x}}, position: [0.32, 0, 0.4736]}
  ram: {mass: 3, inertia: [0.01, 0.01, 0.01], position: [0.4165, 0, 0.5]}
joints:
  O: {type: revolute, bodies: [ground, rocker], location: [0, 0, 0], axis: [0, 1, 0]}
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0.2], axis: [0, 1, 0]}
  B: {type: point_on_line, bodies: [rocker, crank], location: [0.1, 0, 0.2], axis: [1, 0, 2]}
  C: {type: revolute, bodies: [rocker, link], location: [0.2236, 0, 0.4472], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [link, ram], location: [0.4165, 0, 0.5], axis: [0, 1, 0]}
  guide: {type: prismatic, bodies: [ground, ram], location: [0.4165, 0, 0.5], axis: [1, 0, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 60 rpm}}
"""


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
@pytest.mark.parametrize("tolerance", [0.01, 0.021, 0.03, 0.1])
def test_no_sample_is_recorded_with_an_open_joint(tolerance, formulation):
    """Some ten steps pass the fast return of the ram twice: what is interpolated leaves the joints far open."""
    scene = read_scene_text(QUICK_RETURN, "f", {}, {"tolerance": tolerance, "formulation": formulation})
    recorder = Recorder()
    report = simulate(*assembled(scene), settings_to_run(scene), recorder)
    assert report.counters["steps"] < 15
    assert len(recorder["time"]) == 2001
    assert recorder["diagnostics/position_violation"].max() <= 1e-13


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_samples_inside_steps_are_as_closed_as_their_ends(formulation):
    """Several in each step of a pendulum of five bars, whose interpolation alone leaves the joints open by 1e-7 m."""
    options = {"tolerance": 1e-6, "integrator": "dopri5", "output_step": 0.005, "formulation": formulation}
    scene = read_scene(ROOT / "mechanisms" / "five_bar.yaml", {}, {**options, "duration": 1.0})
    recorder = Recorder()
    report = simulate(*assembled(scene), settings_to_run(scene), recorder)
    assert report.counters["steps"] < 100
    assert recorder["diagnostics/position_violation"].max() <= 1e-13
    assert recorder["diagnostics/velocity_violation"].max() <= 1e-12


@given(start=floats(-10.0, 10.0), interval=floats(1e-3, 0.3), duration=floats(1.0, 9.0))
def test_samples_are_at_multiples_of_the_output_step_and_at_the_end(start, interval, duration) -> None:
    """To the last bit."""
    listed = list(output_times(Settings(duration=duration, tolerance=1e-6, output_step=interval), start))
    assert listed[0] == start
    assert listed[-1] == start + duration
    assert all(time == start + k * interval for k, time in enumerate(listed[:-1]))
    assert all(before < after for before, after in pairwise(listed))


def test_times_of_a_million_samples_take_no_memory() -> None:
    times = output_times(Settings(duration=1e3, tolerance=1e-6, output_step=1e-3), 0.0)
    assert len(times) == 10**6 + 1
    assert (times[-1], times[-2], times[10:12]) == (1e3, 999999 * 1e-3, [10 * 1e-3, 11 * 1e-3])
    assert sys.getsizeof(times) + sum(map(sys.getsizeof, vars(times).values())) < 1000


TURNS = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1.5, integrator: rk4, step: 0.01, output_step: OUTPUT, kinematic: false}
bodies: {b: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0.3, 0.1]}}
joints: {A: {type: revolute, bodies: [ground, b], location: [0, 0, 0], axis: AXIS}}
motions: {drive: {joint: A, angle: "2*pi*t"}}
"""


@needs_kernel
@pytest.mark.parametrize("output_step", ["0.05", "0.0625"])
def test_at_half_a_turn_an_angle_has_the_turns_of_the_pose_that_is_recorded(output_step):
    """There round-off tells on which side of ±π the kernel has it, and on which side the pose that is recorded."""
    rng = np.random.default_rng(0)
    for axis in rng.normal(size=(20, 3)).tolist():
        text = TURNS.replace("AXIS", str(axis)).replace("OUTPUT", output_step)
        scene = read_scene_text(text, "f", {}, {"formulation": "reduced", "step": float(output_step) / 5.0})
        recorder = Recorder()
        simulate(*assembled(scene), settings_to_run(scene), recorder)
        np.testing.assert_allclose(recorder["joints/coordinate"][:, 0], 2.0 * np.pi * recorder["time"], atol=1e-12)
