"""Comparisons, trade-offs and their fronts, and the threshold of the projection."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.base.errors import InputError
from mbproj.commands.threshold import _verdict
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.studies.compare import compare
from mbproj.studies.measure.measurement import Measurement, Timing
from mbproj.studies.measure.reference import certain_reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism, solve
from mbproj.studies.threshold import ThresholdStudy, _recommended, threshold_study
from mbproj.studies.tradeoff import (
    Ladder,
    by_integrator,
    by_projection,
    cheapest,
    excess,
    front,
    projections_at_one_size,
    promising,
    studied,
    tradeoff,
    write_hdf5,
)
from tests.support import ROOT

# A trade-off on the pendulum, whose errors are known to fall with the order: its grid, its fronts, its resumption.

PENDULUM = ROOT / "mechanisms" / "physical_pendulum.yaml"
OPTIONS = {
    "projections": ("gpopm", "none"),
    "integrators": ("rk4", "dop853"),
    "until": 1.0,
    "longest": 0.01,
    "repetitions": 1,
    "processes": 1,
}


@pytest.fixture
def scene():
    return read_scene(PENDULUM)


@pytest.mark.full
def test_tradeoff(scene, tmp_path):
    found = tradeoff(scene, **OPTIONS)
    assert found.floor < 1e-12
    lines = by_integrator(found.trials)
    assert set(lines) == {"rk4, fixed steps", "dop853, fixed steps", "dop853, tolerance"}
    steps = np.array([found.trials[index].setting.step for index in lines["rk4, fixed steps"]])
    errors = found.error[lines["rk4, fixed steps"]]
    rows_ = (errors > 1e-10) & (steps < 0.01)
    assert np.polyfit(np.log(steps[rows_]), np.log(errors[rows_]), 1)[0] == pytest.approx(4.0, abs=0.2)
    timed = sorted(found.timings)
    for index in found.front:
        cheaper = [i for i in timed if found.seconds[i] < found.seconds[index]]
        assert all(found.error[i] > found.error[index] for i in cheaper)
    own = found.trials[found.own].setting
    assert (own.integrator, own.step, own.projection) == ("rk4", 0.005, "gpopm")
    assert {found.trials[index].setting.step for index in found.compared} == {0.005}
    variants = by_projection(found.trials, studied(found.trials, found.front))
    assert {"gpopm", "none", "gpopm every 5 steps"} <= set(variants)
    best = found.cheapest(1e-9)
    assert found.error[best] <= 1e-9
    assert found.seconds[best] == min(found.seconds[i] for i in timed if found.error[i] <= 1e-9)

    settings = [row[found.table.headings.index("setting")] for row in found.table.rows]
    assert len(set(settings)) == len(found.trials)
    path = write_hdf5(tmp_path / "t.h5", found)
    with h5py.File(path) as file:
        assert np.array_equal(file["trials/error"][:], found.error)
        described = dict(file["trials/cpu_seconds"].attrs)
        assert described == {"description": "processor time of the steps of one run, median", "units": "s"}
        assert {each.attrs["units"] for name, each in file["trials"].items() if name.startswith("error")} == {"m"}
        assert file["trials/setting"].asstr()[0] == settings[0]
        assert file["reference/uncertainty"].shape == (len(found.reference.times), 1)


@pytest.mark.full
def test_an_interrupted_study_resumes_and_gives_the_same_table_again(scene, tmp_path):
    small = OPTIONS | {"integrators": ("dop853",), "until": 0.2, "longest": 0.005}

    def interrupt(phase: str, done: int, whole: int) -> None:
        if (phase, done) == ("projections and schedules", 3):
            raise KeyboardInterrupt

    def told(number: int, **options: Any) -> tuple[str, int]:
        """What is said then, where the study is interrupted again."""
        said: list[tuple[str, int]] = []

        def tell(phase: str, done: int, whole: int) -> None:
            said.append((phase, done))
            if len(said) > number:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            tradeoff(scene, **small | options, tell=tell)
        return said[number]

    with pytest.raises(KeyboardInterrupt):
        tradeoff(scene, **small, tell=interrupt)
    assert told(2) == ("projections and schedules", 3)  # the sweeps of the integrators are through at once
    first = tradeoff(scene, **small).table.rows
    again = tradeoff(scene, **small).table.rows
    assert repr(first) == repr(again)  # to the last digit of every timing
    assert told(1, until=0.1) == told(1, fresh=True) == ("integrators", 0)


def test_a_motion_that_cannot_be_predicted_is_cut_short(scene, monkeypatch):
    mechanism, own = Mechanism.of(scene), Setting.of(scene.settings)
    whole, notes = certain_reference(mechanism, 5.0, own, ("rk4",))
    assert (whole.times[-1], len(notes)) == (5.0, 1)
    monkeypatch.setattr("mbproj.studies.measure.reference.CERTAIN", whole.uncertainty[500, 0] / mechanism.system.length)
    cut, notes = certain_reference(mechanism, 5.0, own, ("rk4",))
    assert cut.times[-1] == whole.certain_until(whole.uncertainty[500, 0]) < 5.0
    assert "the study ends at" in notes[1]
    assert "(errors grow from round-off: starts that differ by it are " in notes[1]


def test_what_cannot_be_asked_for(scene):
    with pytest.raises(InputError, match="there is no 'ende' among the markers; did you mean 'end'"):
        tradeoff(scene, **OPTIONS, at=("ende",))
    with pytest.raises(InputError, match="unknown projection method 'gpom'"):
        tradeoff(scene, **{**OPTIONS, "projections": ("gpom",)})
    with pytest.raises(InputError, match="unknown integrator 'rk5'"):
        tradeoff(scene, **{**OPTIONS, "integrators": ("rk5",)})
    with pytest.raises(InputError, match="the scene has no duration; add it to"):
        tradeoff(replace(scene, settings=replace(scene.settings, duration=None)), **{**OPTIONS, "until": None})


# The front by its definition.

VALUES = st.sampled_from([0.0, 1.0, 2.0, 3.0, 4.0, float("inf")]) | st.floats(min_value=1e-12, max_value=1e12)
CLOUDS = st.lists(st.tuples(VALUES, VALUES), max_size=30)


def dominates(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return a[0] <= b[0] and a[1] <= b[1] and a != b


@given(CLOUDS)
def test_front(cloud):
    costs, errors = [each[0] for each in cloud], [each[1] for each in cloud]
    found = front(costs, errors)
    on = [cloud[index] for index in found]
    finite = [each for each in cloud if np.isfinite(each).all()]
    assert set(on) == {each for each in finite if not any(dominates(other, each) for other in finite)}
    assert on == sorted(on)
    assert len(set(on)) == len(on)
    assert [error for _, error in on] == sorted((error for _, error in on), reverse=True)


@given(CLOUDS.filter(bool), st.floats(min_value=1e-12, max_value=1e12))
def test_cheapest_and_excess(cloud, limit):
    costs, errors = (np.array([each[axis] + 1e-3 for each in cloud]) for axis in (0, 1))
    able = costs[(errors <= limit) & np.isfinite(costs)]
    index = cheapest(costs, errors, limit)
    assert (index is None) == (len(able) == 0)
    if index is not None:
        assert errors[index] <= limit
        assert costs[index] == able.min()
    ratios = excess(costs, errors)
    assert np.all(ratios >= 1.0)
    assert ratios[front(costs, errors)] == pytest.approx(1.0)


# Which settings are worth another look, where nothing has an error at all.


def trial_near_front(projection: str, step: float, evaluations: int) -> Measurement:
    setting = Setting(projection=projection, integrator="rk4", step=step)
    return Measurement(setting, {"tip": 0.0}, {"tip": 0.0}, 0.0, 0.0, 0.0, 0.0, {"evaluations": evaluations}, 1e-3)


@pytest.mark.filterwarnings("error")
def test_where_every_error_is_zero_the_fewest_evaluations_win():
    ladders = [Ladder(Setting(projection=name, integrator="rk4", step=0.1), False) for name in ("gpopm", "none")]
    swept = [[trial_near_front("gpopm", 0.1, 400)], [trial_near_front("none", 0.1, 100)]]
    assert promising(ladders, swept) == [ladders[1]]
    trials = [trial_near_front(name, step, 10) for step in (0.1, 0.2, 0.4) for name in ("gpopm", "none")]
    assert projections_at_one_size(trials, np.zeros(6), None) == [0, 1]


# A comparison: what each entry is, one formulation for all, and failures as entries.


def test_compare(slider_crank):
    found = compare(
        slider_crank.scene, projections=("none", "gpopm"), steps=(0.01, 0.005), until=1.0, repetitions=1, processes=1
    )
    labels = [entry.label for entry in found.entries]
    assert labels == [f"{method}, h = {h} s" for method in ("none", "gpopm") for h in (0.01, 0.005)]
    numbers = {entry.label: entry.numbers for entry in found.entries}
    assert found.cost_in_time
    for entry in found.entries:
        row = numbers[entry.label]
        assert row["energy_drift"] == pytest.approx(entry.solution.energy_balance[-1], abs=1e-11)
        assert 0.0 < row["cpu_seconds"] < np.inf
        assert row["acceleration_violation"] < 1e-9
    coarse, fine = (numbers[f"gpopm, h = {h} s"] for h in (0.01, 0.005))
    assert coarse["error"] / fine["error"] > 8.0
    assert fine["position_violation"] <= 1e-13 < 1e-3 < numbers["none, h = 0.01 s"]["position_violation"]


def test_several_formulations_are_not_compared_in_time(pendulum):
    found = compare(
        pendulum.scene, projections=("gpopm",), formulations=("full", "reduced"), until=0.1, repetitions=1, processes=1
    )
    assert [entry.solution.report.formulation for entry in found.entries] == ["full", "reduced"]
    assert not found.cost_in_time
    assert all(entry.timing is None for entry in found.entries)
    assert any("cost is compared in factorisations and iterations" in note for note in found.notes)


def test_one_formulation_for_all_and_failures_are_entries(pendulum):
    found = compare(pendulum.scene, projections=("gpopm", "gpopm-pinv", "popm"), until=0.1, repetitions=1, processes=1)
    first, second, refused = found.entries
    assert first.solution.report.formulation == second.solution.report.formulation == "full"
    assert "all in the full formulation: 'gpopm-pinv' exists there only" in found.notes
    assert refused.split is None
    assert refused.numbers["failure"].startswith("'popm' needs a positive definite mass matrix")
    assert np.isnan(refused.numbers["cpu_seconds"])


def test_names_that_are_not_there(pendulum):
    with pytest.raises(InputError, match="unknown projection method 'gpom'; did you mean 'gpopm'"):
        compare(pendulum.scene, projections=("gpom",))
    with pytest.raises(InputError, match="unknown integrator 'rk5'"):
        compare(pendulum.scene, integrators=("rk5",))


def test_runs_of_a_comparison_are_not_run_again(pendulum, monkeypatch):
    options = {"projections": ("gpopm",), "until": 0.1, "repetitions": 1, "processes": 1}
    first = compare(pendulum.scene, **options)
    monkeypatch.setattr("mbproj.studies.compare.solve", None)
    again = compare(pendulum.scene, **options)
    np.testing.assert_array_equal(again.entries[0].error, first.entries[0].error)
    with pytest.raises(TypeError):
        compare(pendulum.scene, **{**options, "until": 0.2})


def test_a_row_has_its_numbers_under_their_headings(pendulum):
    """The row of a setting with the energy row was longer than the first, and its times stood under other headings."""
    options = {"projections": ("gpopm",), "energy_rows": (False, True), "until": 0.1, "repetitions": 1, "processes": 1}
    found = compare(pendulum.scene, **options)
    without, kept = found.table.records
    assert np.isnan(without["energy_row_given"]) and np.isfinite(kept["energy_row_given"])
    for record, entry in zip((without, kept), found.entries, strict=True):
        assert record["cpu_seconds"] == entry.timing.median
        assert record["failure"] == ""


# The threshold of the projection: fewer projections the higher it is, and no effect where it is low.


@pytest.mark.full
def test_threshold_study(slider_crank):
    options = {"until": np.float64(2.0), "repetitions": 1, "processes": 1}
    found = threshold_study(slider_crank.scene, **options)
    thresholds = [trial.setting.threshold for trial in found.trials]
    assert thresholds[0] is None
    assert found.trials[-1].setting.projection == "none"
    projections = [trial.counters["projections"] for trial in found.trials]
    assert projections == sorted(projections, reverse=True)
    assert (projections[0], projections[-1]) == (200, 0)
    assert found.trials[1].error == found.trials[0].error
    for trial in found.trials[1:-1]:
        assert trial.position_violation <= max(trial.setting.threshold, 1e-13)
        assert trial.velocity_violation <= max(trial.setting.threshold, 1e-13)
    last = found.recommended
    errors = np.array([trial.at() for trial in found.trials])
    assert errors[: last + 1].max() <= 1.1 * errors[0] < errors[last + 1 : -1].min()
    assert found.exceeded == ()
    assert found.saved(last) == 1.0 - projections[last] / 200
    again = threshold_study(slider_crank.scene, **options)
    assert (again.trials, again.timings, again.recommended) == (found.trials, found.timings, found.recommended)


def trial_of_threshold(threshold, error, projections):
    counters = {"projections": projections}
    return Measurement(Setting(threshold=threshold), {"tip": error}, {"tip": 0.0}, counters=counters)


def test_a_threshold_that_leaves_out_one_projection_of_hundreds_is_none_to_recommend():
    trials = [
        trial_of_threshold(None, 1e-11, 400),
        trial_of_threshold(1e-12, 1e-11, 399),
        trial_of_threshold(1e-9, 1.8e-9, 150),
    ]
    assert _recommended(trials, (), 0.0) == (None, ())
    assert _recommended([*trials[:2], trial_of_threshold(1e-9, 1e-11, 150)], (), 0.0) == (2, ())


def test_where_errors_fall_again_what_saves_most_is_recommended_and_the_others_are_named():
    errors = [1e-9, 1e-9, 1.3e-9, 2e-9, 0.9e-9, 5e-8]
    trials = [
        trial_of_threshold(None, 1e-9, 400),
        *(trial_of_threshold(10.0**-n, e, 40 * n) for n, e in zip(range(9, 3, -1), errors, strict=True)),
    ]
    found, exceeded = _recommended(trials, (), 0.0)
    assert (trials[found].setting.threshold, exceeded) == (1e-5, (3, 4))
    study = ThresholdStudy("", tuple(trials), (Timing((1.0, 2.0)),) * 7, None, found, exceeded, ())
    assert _verdict(study).endswith(
        "errors do not grow evenly: at 1e-7 to 1e-6 they are larger, so the next motion may differ"
    )


def test_a_method_without_projections_has_no_threshold(slider_crank):
    text = slider_crank.scene.text.replace("projection: gpopm", "projection: baumgarte")
    with pytest.raises(InputError, match="'baumgarte' makes no projections; choose one with --projection"):
        threshold_study(read_scene_text(text))


def test_what_has_no_joint_or_marker_to_ask_for_is_said(slider_crank):
    with pytest.raises(InputError, match="there is no 'slidr' among the markers; did you mean 'slider'"):
        threshold_study(slider_crank.scene, at=["slidr"])
    body = "bodies: {a: {mass: 1, inertia: [1, 2, 3], position: [0, 0, 0], angular_velocity: [0.1, 2, 0]}}"
    free = f"mbproj: 1\ngravity: [0, 0, -9.8]\nsimulation: {{duration: 1, step: 0.1}}\n{body}\n"
    with pytest.raises(InputError, match="there is nothing to project: no joint"):
        threshold_study(read_scene_text(free), processes=1)


def test_thresholds_come_as_an_array_too(slider_crank):
    found = threshold_study(
        slider_crank.scene, thresholds=np.array([1e-3, 1e-9, 1e-3]), until=0.1, repetitions=1, processes=1
    )
    assert [trial.setting.threshold for trial in found.trials] == [None, 1e-9, 1e-3, None]  # each once
    assert len(found.timings) == 4


def test_each_penalty_and_pair_of_gains_is_an_entry(pendulum):
    """Each is the run with this option alone; methods that take neither run once."""
    options = {"steps": (0.01,), "until": 0.5, "repetitions": 1, "processes": 1}
    methods = ("mass-orthogonal", "baumgarte", "gpopm")
    options |= {"alphas": (1e2, 1e6), "gains": ((5.0, 5.0), (20.0, 40.0))}
    compared = compare(pendulum.scene, projections=methods, **options)
    settings = [entry.measurement.setting for entry in compared.entries]
    assert [(each.projection, each.alpha, each.gains) for each in settings] == [
        ("mass-orthogonal", 1e2, None),
        ("mass-orthogonal", 1e6, None),
        ("baumgarte", None, (5.0, 5.0)),
        ("baumgarte", None, (20.0, 40.0)),
        ("gpopm", None, None),
    ]
    for entry in compared.entries:
        alone = solve(pendulum, entry.measurement.setting, entry.solution.times)
        np.testing.assert_array_equal(entry.solution.body_position, alone.body_position)
    labels = [entry.label for entry in compared.entries[:2]]
    assert labels == ["mass-orthogonal, α = 100", "mass-orthogonal, α = 1e+06"]


def test_an_option_that_no_method_takes_is_refused(pendulum):
    message = "--alphas: error: no method that is compared takes 'alpha'; add mass-orthogonal or mmopm"
    with pytest.raises(InputError, match=message):
        compare(pendulum.scene, projections=("gpopm",), alphas=(1e3,), steps=(0.01,))
