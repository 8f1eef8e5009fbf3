"""Solving, the reference and its uncertainty, trials in processes, and what is resumed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from mbproj.integrate import simulate
from mbproj.integrate.formulations.choice import Choice
from mbproj.scene import read_scene, read_scene_text
from mbproj.studies.measure.accuracy import attempt
from mbproj.studies.measure.measurement import MEASUREMENT_RECORDS
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import _checked, _Fine, error, reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import sample_times, solve
from mbproj.studies.measure.timing import time_settings
from mbproj.studies.store import ValueCache
from tests.support import ROOT, Recorder


def exact_end(times: np.ndarray) -> np.ndarray:
    """The bar's end by Jacobi's sn, (T, 3) in m: sin(φ/2) = k sn(K + ω t), k = sin 60°, ω² = 3 g / 2."""
    k = np.sin(np.pi / 3.0)
    sn = ellipj(ellipk(k * k) + np.sqrt(1.5 * 9.81) * times, k * k)[0]
    angle = 2.0 * np.arcsin(k * sn)
    return np.column_stack([np.sin(angle), np.zeros(len(times)), -np.cos(angle)])


@pytest.mark.parametrize(("integrator", "order"), [("heun2", 2), ("bs32", 3), ("rk4", 4), ("dopri5", 5)])
def test_errors_fall_with_the_order_of_the_integrator(pendulum, integrator, order):
    times, errors = sample_times(1.0, 4), []
    for steps in (128, 256):
        solution = solve(pendulum, Setting(integrator=integrator, step=1.0 / steps), times)
        errors.append(np.linalg.norm(solution.position[:, 0] - exact_end(times), axis=1).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("compared", [(), ("dopri5",), ("dopri5", "dop853", "rk4")])
def test_the_uncertainty_of_the_reference_bounds_its_true_error(pendulum, compared):
    times = sample_times(5.0, 50)
    found = reference(pendulum, times, compared)
    true = np.linalg.norm(found.position[:, 0] - exact_end(times), axis=1)
    assert np.all(true <= found.uncertainty[:, 0] + 1e-14)
    assert found.uncertainty.max() < 1e-11
    assert np.all(np.diff(found.uncertainty[:, 0]) >= 0.0)
    assert found.method.startswith("dop853" if compared == ("dopri5",) else "dopri5")
    assert found.certain_until(1e-11) == 5.0


def test_solutions_that_agree_are_uncertain_by_what_the_last_halving_moved(pendulum):
    times, moved = sample_times(1.0, 10), 1e-6 * np.arange(11.0)[:, None]
    solution = solve(pendulum, Setting(integrator="rk4", step=0.01), times)
    found = _checked(lambda *_, **__: _Fine(solution, moved), pendulum, times, "dopri5", "dop853", 1.0)
    np.testing.assert_array_equal(found.uncertainty, moved)


def test_a_reference_is_computed_once(pendulum, monkeypatch):
    times = sample_times(1.0, 10)
    first = reference(pendulum, times)
    monkeypatch.setattr("mbproj.studies.measure.reference.solve", None)
    again = reference(pendulum, times)
    assert np.array_equal(first.position, again.position)
    assert (first.method, first.check) == (again.method, again.check)
    with pytest.raises(TypeError):
        reference(pendulum, sample_times(1.0, 20))


def test_a_failure_is_a_value(slider_crank):
    times = sample_times(10.0, 100)
    broken = solve(slider_crank, Setting("none", "heun2", step=0.05), times)
    assert broken.report is None
    assert broken.failure is not None
    assert broken.failure.status == "failed"
    rows = times < broken.failure.time
    assert np.isfinite(broken.position[rows]).all()
    assert np.isnan(broken.position[~rows]).all()
    refused = solve(slider_crank, Setting("popm", step=0.05, formulation="full"), times)
    assert refused.failure is not None
    assert refused.failure.status == "refused"
    assert "needs a positive definite mass matrix" in refused.failure.cause


def test_points_are_the_bodies_where_there_is_no_marker(pendulum):
    text = pendulum.scene.text.partition("markers:")[0]
    bare = Mechanism.of(read_scene_text(text))
    assert bare.points == ("bar",)
    times = sample_times(1.0, 4)
    solution = solve(bare, Setting("gpopm", "dop853", tolerance=1e-12), times)
    assert solution.position[:, 0] == pytest.approx(0.5 * exact_end(times), abs=1e-10)


def test_processes_and_what_is_kept_change_nothing(pendulum):
    found = reference(pendulum, sample_times(1.0, 10))
    settings = [Setting(step=0.1 / k) for k in (10, 20)] + [Setting("none", "dop853", tolerance=1e-6)]
    seen: list[tuple[str, int, int]] = []
    alone = attempt(pendulum, settings, found, processes=1)
    first = attempt(pendulum, settings[:2], found, ValueCache("test", records=MEASUREMENT_RECORDS), processes=2)
    whole = attempt(
        pendulum,
        settings,
        found,
        ValueCache("test", records=MEASUREMENT_RECORDS),
        processes=2,
        tell=lambda *told: seen.append(told),
    )
    assert seen == [("runs", 2, 3), ("runs", 3, 3)]
    assert whole[:2] == first  # not run again: the seconds are the same, too
    assert [trial.error for trial in whole] == [trial.error for trial in alone]
    assert [trial.counters for trial in whole] == [trial.counters for trial in alone]
    errors = [error(solve(pendulum, s, found.times), found).max() for s in settings]
    assert [trial.at() for trial in whole] == errors


def test_timings_of_all_settings_and_repetitions(pendulum):
    settings, calls = [Setting(step=0.01), Setting(step=0.3)], []
    timings = time_settings(
        pendulum, settings, sample_times(1.0, 1), repetitions=2, tell=lambda _, done, whole: calls.append((done, whole))
    )
    assert calls == [(0, 2), (0, 2), (1, 2), (2, 2)]  # rounds; the clock of the first begins after the first runs
    assert [len(timing.samples) for timing in timings] == [2, 2]
    low, high = timings[0].spread
    assert 0.0 < low <= timings[0].median <= high


@pytest.mark.parametrize("formulation", ["auto", "full"])
@pytest.mark.parametrize("name", ["bennett", "n_four_bar"])
def test_a_shared_formulation_changes_no_bit(name, formulation):
    """The run before has chosen rows, too, where some depend on others."""
    mechanism = Mechanism.of(read_scene(ROOT / "mechanisms" / f"{name}.yaml"))
    how = {"formulation": formulation, "integrator": "rk4", "step": 1e-3, "tolerance": None, "duration": 0.02}
    settings = replace(mechanism.scene.settings, **how)
    choice = mechanism.choice(settings)

    def velocities(step: float, mechanism: Mechanism, choice: Choice | None = None) -> np.ndarray:
        recorder = Recorder()
        simulate(mechanism.system, mechanism.state, replace(settings, step=step), recorder, choice=choice)
        return recorder["bodies/velocity"]

    velocities(2e-3, mechanism, choice)
    alone = velocities(1e-3, Mechanism.of(mechanism.scene))
    assert np.array_equal(velocities(1e-3, mechanism, choice), alone)
    assert np.array_equal(velocities(1e-3, mechanism), alone)
