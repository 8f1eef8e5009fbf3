"""The motion itself: closed forms, branches, turning points, and what a run says of itself."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import Mechanism, check, simulate_certified
from mbproj.errors import InputError
from mbproj.integrate.formulations import choice
from mbproj.scene import read_scene_text, settings_to_run
from mbproj.studies.compare.comparison import compare
from tests.integrate.kinematic.scenes import (
    BY_THE_ROCKER,
    FORMULATIONS,
    FOUR_BAR,
    PARALLELOGRAM,
    rocker_angle,
    rocker_at_dead_centre,
    run,
)

COORDINATE, SPEED = "joints/coordinate", "joints/speed"


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_driven_four_bar_is_where_the_cosine_rule_puts_it(formulation):
    report, found, _ = run(FOUR_BAR, formulation=formulation, duration="2 s")
    assert report.kinematic and report.formulation == formulation
    rocker = found[COORDINATE][:, 3]
    np.testing.assert_allclose(rocker - rocker[0], rocker_angle(found["time"]) - rocker_angle(0.0), atol=4e-13)
    step = 1e-5
    rate = (rocker_angle(found["time"] + step) - rocker_angle(found["time"] - step)) / (2.0 * step)
    np.testing.assert_allclose(found[SPEED][:, 3], rate, rtol=0, atol=1e-7)
    assert report.energy_drift_relative < 1e-10
    assert not report.drifts


def test_accelerations_reactions_and_torques_are_those_of_a_run_that_integrates():
    _, found, _ = run(FOUR_BAR)
    report, integrated, _ = run(FOUR_BAR, kinematic=False, tolerance=1e-11)
    assert not report.kinematic
    np.testing.assert_array_equal(found["time"], integrated["time"])
    for path in ("bodies/acceleration", "joints/reaction_force", "motions/force", "diagnostics/work"):
        scale = np.abs(integrated[path]).max()
        np.testing.assert_allclose(found[path], integrated[path], rtol=0, atol=1e-9 * scale, err_msg=path)


def test_samples_take_no_more_than_two_evaluations_each():
    pytest.importorskip("mbproj.kernel._core")
    report, _, _ = run(FOUR_BAR, output_step="2 ms")
    assert report.counters["evaluations"] < 2 * 1001
    assert report.counters["steps"] < 100


def test_steps_of_the_scene_say_when_to_record_and_nothing_else():
    _, found, _ = run(FOUR_BAR, duration="0.4 s")
    _, fixed, _ = run(FOUR_BAR, duration="0.4 s", step="10 ms", integrator="heun2")
    np.testing.assert_allclose(fixed["time"], found["time"], rtol=1e-15)
    np.testing.assert_allclose(fixed[COORDINATE], found[COORDINATE], rtol=0, atol=1e-12)


def test_a_motion_turns_back_before_the_dead_centre():
    before = rocker_at_dead_centre() - 1e-5
    there_and_back = BY_THE_ROCKER.replace("constant_speed: 20 rpm", f"expression: '{before}*sin(3*t)**2'")
    _, found, _ = run(there_and_back, duration="3 s")
    np.testing.assert_allclose(found[COORDINATE][:, 3], before * np.sin(3.0 * found["time"]) ** 2, atol=1e-12)
    crank = np.unwrap(found[COORDINATE][:, 0])
    assert np.ptp(crank) < np.pi  # it has not gone over to the other branch


def test_a_parallelogram_stays_one_where_branches_cross():
    report, found, _ = run(PARALLELOGRAM, duration="3 s", output_step="7 ms")
    crank, rocker = found[COORDINATE][:, 0], found[COORDINATE][:, 3]
    np.testing.assert_allclose(np.unwrap(rocker), np.unwrap(crank), atol=1e-9)
    assert report.kinematic


def test_a_motion_begins_at_rest():
    text = FOUR_BAR.replace(
        "constant_speed: 60 rpm", "smooth_step: {from: 0, to: 2 rad, start: 0.1 s, duration: 0.5 s}"
    )
    report, found, _ = run(text, duration="0.8 s", output_step="10 ms")
    np.testing.assert_allclose(found[COORDINATE][found["time"] >= 0.6, 0], 2.0, atol=1e-12)
    assert report.energy_drift_relative < 1e-9


def test_a_run_goes_on_from_its_mark_to_the_same_bits():
    _, whole, _ = run(FOUR_BAR, duration="1 s", resumed={})
    _, _, marks = run(FOUR_BAR, duration="0.5 s", resumed={})
    _, rest, _ = run(FOUR_BAR, duration="1 s", resumed=marks[-1])
    count = len(rest["time"])
    assert 0 < count < len(whole["time"])
    for path in (COORDINATE, "motions/force", "diagnostics/work"):
        np.testing.assert_array_equal(rest[path], whole[path][-count:])


def test_a_mechanism_that_is_free_is_refused():
    free = FOUR_BAR[: FOUR_BAR.index("motions:")]
    with pytest.raises(InputError, match="has 1 degree of freedom: a kinematic run needs 0"):
        run(free, kinematic=True)
    assert not run(free, duration="0.1 s")[0].kinematic


def test_a_kinematic_scene_needs_neither_step_nor_tolerance():
    text = FOUR_BAR.replace("tolerance: 1e-3, integrator: dop853", "kinematic: true")
    report, found, _ = run(text, duration="0.1 s")
    assert report.kinematic and len(found["time"]) == 3


def test_a_certificate_compares_with_poses_of_another_method():
    scene = read_scene_text(FOUR_BAR, simulation={"duration": "0.5 s"})
    _, trust = simulate_certified(Mechanism.of(scene), settings_to_run(scene))
    assert trust.error.max() < 1e-12 and trust.uncertainty.max() < 1e-12
    assert "Gauss-Newton" in trust.solution


def test_full_says_to_use_reduced(monkeypatch):
    """Its steps in NumPy integrate; contacts and implicit steps, which the kernel makes for it, may be kinematic."""
    with pytest.raises(InputError, match="the full formulation has no kinematic steps; use reduced: 'form") as refused:
        run(FOUR_BAR, formulation="full")
    assert "or integrate the motion, with 'kinematic: false'" in str(refused.value)
    assert run(FOUR_BAR, projection="gpopm-pinv", duration="0.1 s")[0].formulation == "planar"  # it is not used
    assert not run(FOUR_BAR, formulation="full", kinematic=False, duration="0.05 s")[0].kinematic
    found = check(read_scene_text(FOUR_BAR, simulation={"formulation": "full"}))
    assert [each.message for each in found.problems] == ["the full formulation has no kinematic steps"]
    monkeypatch.setattr(choice, "core", lambda: None)
    with pytest.raises(InputError, match="kinematic steps need the kernel; install a C\\+\\+ compiler, or a wheel"):
        run(FOUR_BAR, formulation="full")


def test_studies_say_that_there_is_no_setting_to_choose():
    scene = read_scene_text(FOUR_BAR)
    with pytest.raises(InputError, match="kinematic, exact at any setting"):
        compare(scene, tolerances=[1e-6])
