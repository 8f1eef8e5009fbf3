"""What studies measure: references and their uncertainty, settings, sample times, stiff mechanisms."""

from __future__ import annotations

import shlex
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipj, ellipk

from mbproj.base.errors import InputError
from mbproj.motion.formulations.choice import Choice
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.studies.compare import compare
from mbproj.studies.measure import reference as references
from mbproj.studies.measure.measurement import SettingsStudy, time_settings
from mbproj.studies.measure.reference import (
    _computed,
    _Fine,
    common_times,
    divisors,
    error,
    reference,
    sampled,
    stride_for,
)
from mbproj.studies.measure.setting import Setting, shortest
from mbproj.studies.measure.solve import Mechanism, sample_times, solve
from mbproj.studies.recommend import families, recommend
from mbproj.studies.stability import stability
from mbproj.studies.tradeoff import MOST, Ladder, step_numbers
from mbproj.studies.variants import with_damping
from mbproj.studies.verify.checks import verify
from tests.cli.commands import FIVE_BAR
from tests.integrate.stiff_scenes import CREEP
from tests.studies.scenes import OSCILLATOR, PENDULUM
from tests.support import ROOT, Recorder

# Solving, the reference and its uncertainty, trials in processes, and what is resumed.


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


def test_solutions_that_agree_are_uncertain_by_what_the_last_halving_moved(pendulum, monkeypatch):
    times, moved = sample_times(1.0, 10), 1e-6 * np.arange(11.0)[:, None]
    solution = solve(pendulum, Setting(integrator="rk4", step=0.01), times)
    monkeypatch.setattr(references, "_fine", lambda *_: _Fine(solution, moved))
    found = _computed(pendulum, times, "dopri5", "dop853", 1.0)
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
    alone = SettingsStudy("alone", pendulum, found).measured(settings)
    first = SettingsStudy("test", pendulum, found, 2).measured(settings[:2])
    whole = SettingsStudy("test", pendulum, found, 2, tell=lambda *told: seen.append(told)).measured(settings)
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


# A setting says the same in every rendering: its options, its command line, the scene's keys.

SCENE = ROOT / "mechanisms" / "physical_pendulum.yaml"
SETTINGS = [
    Setting("gpopm", "dop853", tolerance=1e-8),
    Setting("none", "rk4", step=0.005, formulation="full"),
    Setting("baumgarte", "rk4", step=0.005, gains=(10.0, 20.0)),
    Setting("gopm", "bs32", step=0.0025, every=3, threshold=1e-6, projection_tolerance=1e-10, max_iterations=4),
    Setting("mmopm", "heun2", step=0.001, alpha=1e5, projection_test="paper", project_velocity=False),
]


def test_command_line():
    line = "--integrator dop853 --tolerance 1e-8 --projection gpopm"
    assert Setting("gpopm", "dop853", tolerance=1e-8).command_line() == line
    scene = read_scene(SCENE, {}, {"every": 4, "threshold": 1e-3})
    line = Setting("gpopm", "rk4", step=0.01).command_line(scene.settings)
    assert line == "--integrator rk4 --step 0.01 --projection gpopm --every 1 --threshold 1e-50"


@pytest.mark.parametrize("setting", SETTINGS, ids=lambda setting: setting.label)
@pytest.mark.parametrize("before", [{}, {"every": 4, "threshold": 1e-3}, {"projection": "none", "integrator": "bs32"}])
def test_the_command_line_gives_the_setting_over_any_scene(setting, before):
    scene = read_scene(SCENE, {}, before)
    words = shlex.split(setting.command_line(scene.settings))
    names = [word.removeprefix("--").replace("-", "_") for word in words[::2]]
    options = dict(zip(names, words[1::2], strict=True))
    kept = [f"{key}: {value}" for key, value in before.items() if key in ("every", "threshold")]
    method = before.get("projection", "gpopm")
    text = scene.text.replace("projection: gpopm", f"projection: {{{', '.join([f'method: {method}', *kept])}}}")
    again = Setting.of(read_scene_text(text, simulation=options).settings)
    expected = Setting.of(setting.settings(1.0, 0.25))
    if setting.threshold is None and "threshold" in before and again.threshold is not None:
        assert again.threshold == 1e-50
        again = Setting(**{**vars(again), "threshold": None})
    assert again == expected


def test_what_does_not_fit_is_an_error():
    with pytest.raises(InputError, match=r"'output_step' \(1 s\) is not a whole multiple of 'step' \(0.3 s\)"):
        Setting(step=0.3).settings(2.0, 1.0)
    with pytest.raises(InputError, match="unknown projection method 'gpom'; did you mean 'gpopm'"):
        Setting("gpom", step=0.1).settings(1.0, 1.0)
    with pytest.raises(InputError, match="'rk4' has no error estimate"):
        Setting(tolerance=1e-6).settings(1.0, 1.0)


@given(st.floats(min_value=1e-300, max_value=1e300))
def test_shortest_reads_back(value):
    assert float(shortest(value)) == value


def test_shortest():
    assert [shortest(value) for value in (1e-8, 0.01, 2.5e-7, 1e20)] == ["1e-8", "0.01", "2.5e-7", "1e20"]


# Sample times that steps meet, and the sizes of a grid.


@given(st.sets(st.sampled_from([0.1, 0.05, 0.02, 0.01, 0.005, 0.0025, 0.002, 1.0 / 64.0, 1.0 / 30.0]), min_size=1))
def test_every_step_meets_every_time(steps):
    times = common_times(30.0, steps)
    ratios = np.array([(times[1] - times[0]) / step for step in steps])
    assert ratios == pytest.approx(np.round(ratios), rel=1e-9)
    assert ratios.min() >= 1.0 - 1e-9
    assert times[-1] <= 30.0
    assert 30.0 - times[-1] < times[1]


def test_the_span_ends_with_the_last_common_time():
    assert common_times(1.0, [0.3])[-1] == pytest.approx(0.9)
    assert len(common_times(10.0, [0.001])) == 1001
    assert len(common_times(10.0, [])) == 481
    with pytest.raises(InputError, match=r"the steps do not meet before 2\.1 s, and the study ends at 2 s"):
        common_times(2.0, [0.3, 0.7])


@given(st.integers(min_value=20, max_value=2000))
def test_numbers_of_steps(intervals):
    numbers = step_numbers(intervals)
    assert all(intervals % number == 0 or number % intervals == 0 for number in numbers)
    assert all(20 <= number <= MOST and after >= 1.4 * number for number, after in pairwise(numbers))
    assert numbers[-1] > MOST / 1.5 - intervals


@pytest.mark.parametrize("samples", [200, 480, 997])
def test_each_size_of_a_ladder_meets_some_of_the_times(samples):
    times = np.linspace(0.0, 3.0, samples + 1)
    for setting in Ladder(Setting(), by_tolerance=False).sizes(times):
        stride = stride_for(times, setting.step)
        assert stride is not None
        ratio = times[::stride][1] / setting.step
        assert ratio == pytest.approx(round(ratio), rel=1e-9)
        assert samples % stride == 0
    assert stride_for(times, 0.77) is None


def test_tolerances_of_a_ladder():
    settings = Ladder(Setting(integrator="dop853"), by_tolerance=True).sizes(np.linspace(0.0, 1.0, 11))
    assert [setting.tolerance for setting in settings] == pytest.approx([10.0**-k for k in range(2, 14)])
    assert all(setting.step is None for setting in settings)


def test_divisors():
    assert divisors(12) == [1, 2, 3, 4, 6, 12]


@pytest.mark.parametrize("unit", [1e-300, 1e-9, 1e9, 1e40])
def test_steps_meet_in_every_unit_of_time(unit):
    times = common_times(30.0 * unit, [0.01 * unit, 0.0025 * unit])
    assert times[-1] == pytest.approx(30.0 * unit, rel=1e-9)
    assert times[1] / (0.01 * unit) == pytest.approx(round(times[1] / (0.01 * unit)), rel=1e-9)


def test_steps_that_meet_beyond_all_numbers_do_not_meet():
    with pytest.raises(InputError, match=r"the steps do not meet before .* s, and the study ends at 1 s"):
        common_times(1.0, [1e-3, *(1e40 * (1.0 + part / 997.0) for part in range(12))])


def test_samples_that_no_memory_holds_are_refused():
    with pytest.raises(InputError, match=r"more than 1e\+07 samples, every 0\.01 s until 1e\+44 s"):
        sampled(read_scene(FIVE_BAR), 1e44)


# Studies of stiff mechanisms: references by two implicit methods, and implicit methods among what is tried.

DAMPED = OSCILLATOR.replace("stiffness: 1}", "stiffness: 1, damping: 1}")


@pytest.fixture
def stiff(tmp_path, monkeypatch):
    """A mass that creeps behind 0.1 sin(t) by 2e-4 s; explicit methods need some 800 steps."""
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path))
    return read_scene_text(CREEP)


def test_the_reference_is_by_two_implicit_methods_that_differ(stiff, monkeypatch):
    monkeypatch.setattr(references, "STIFF", 100)
    found = references.reference(Mechanism.of(stiff), np.linspace(0.0, 0.5, 6), seconds=1.0)
    assert found.method.startswith("esdirk4, tolerance 1e-")
    assert found.check.startswith("radau5, tolerance 1e-")
    off = abs(found.position[-1, 0, 0] - 0.1 * np.sin(0.5 - 2e-4))
    assert off < 3e-9 + found.uncertainty[-1].max()
    assert found.uncertainty[-1].max() < 1e-5


@pytest.mark.full
def test_an_implicit_method_is_recommended_where_stability_holds_explicit_ones_up(stiff):
    found = recommend(stiff, 1e-4, timed=False)
    assert found.setting.integrator in ("esdirk4", "radau5")
    assert found.best.at() <= 1e-4
    assert found.best.evaluations < 250  # an explicit method takes 9,600; 131 of esdirk4 lose 0.3 % of the energy
    assert found.best.doubt <= 1.0


def test_implicit_families_are_tried_only_where_forces_are_stiff():
    usual, more = (list(families(Setting(), 0.1, stiff=stiff)) for stiff in (False, True))
    assert {"esdirk4", "auto"} <= {family.integrator for family in more[len(usual) :]}
    assert more[: len(usual)] == usual
    assert not {"esdirk4", "auto"} & {family.integrator for family in usual}


@pytest.mark.full
def test_the_implicit_limit_stands_beside_the_explicit_one():
    """RK4 and ESDIRK4 lose a tenth of the energy of a vibration at different stiffness: neither follows what its steps
    do not resolve."""
    explicit, implicit = stability(
        read_scene_text(OSCILLATOR), "stiffness", projections=["gpopm"], low=1, high=1e3, points=3, processes=1
    ).tracks
    assert (explicit.method, implicit.method) == ("gpopm", "gpopm, esdirk4")
    assert explicit.changes[-1].value == pytest.approx(20.1, rel=0.01)
    assert implicit.changes[-1].value > 5.0 * explicit.changes[-1].value


def test_every_damping_is_scaled():
    scene = with_damping(read_scene_text(DAMPED), 10.0)
    (law,) = scene.forces[0].laws.values() if hasattr(scene.forces[0], "laws") else [scene.forces[0].law]
    assert (law.stiffness, law.damping) == (1.0, 10.0)
    with pytest.raises(InputError) as caught:
        with_damping(read_scene_text(OSCILLATOR), 2.0)
    assert caught.value.problems[0].message == "no force of the scene has a 'damping' to vary"


def test_auto_is_compared_at_tolerances_alone(stiff):
    found = compare(stiff, projections=["gpopm"], integrators=["auto"], tolerances=[1e-4], until=0.2, repetitions=1)
    (entry,) = found.entries
    assert entry.solution.failure is None
    assert entry.split is None
    with pytest.raises(InputError) as caught:
        compare(stiff, projections=["gpopm"], integrators=["auto"], steps=[0.1])
    assert caught.value.problems[0].message == "'auto' chooses its steps by their error: it takes no 'step'"


def test_verify_takes_the_explicit_method_of_auto_with_fixed_steps():
    """The order is that of DOP853."""
    text = PENDULUM.replace("step: 0.01", "tolerance: 1.0e-6, integrator: auto")
    spring = "forces:\n  coil: {type: torsion_spring_damper, joint: pin, stiffness: 10, damping: 0.1}\n"
    found = verify(read_scene_text(text + spring))
    assert not found.of("failed")
    (order,) = (check for check in found.checks if check.name == "order")
    assert order.remark.startswith("dop853 has order 8")
