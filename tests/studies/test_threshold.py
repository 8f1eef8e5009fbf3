"""The threshold of the projection: fewer projections the higher it is, and no effect where it is low."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.commands.threshold import _verdict
from mbproj.scene.scene import read_scene_text
from mbproj.studies.measure.measurement import Measurement, Timing
from mbproj.studies.measure.setting import Setting
from mbproj.studies.threshold import ThresholdStudy, _recommended, threshold_study


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


def trial(threshold, error, projections):
    counters = {"projections": projections}
    return Measurement(Setting(threshold=threshold), {"tip": error}, {"tip": 0.0}, counters=counters)


def test_a_threshold_that_leaves_out_one_projection_of_hundreds_is_none_to_recommend():
    trials = [trial(None, 1e-11, 400), trial(1e-12, 1e-11, 399), trial(1e-9, 1.8e-9, 150)]
    assert _recommended(trials, (), 0.0) == (None, ())
    assert _recommended([*trials[:2], trial(1e-9, 1e-11, 150)], (), 0.0) == (2, ())


def test_where_errors_fall_again_what_saves_most_is_recommended_and_the_others_are_named():
    errors = [1e-9, 1e-9, 1.3e-9, 2e-9, 0.9e-9, 5e-8]
    trials = [
        trial(None, 1e-9, 400),
        *(trial(10.0**-n, e, 40 * n) for n, e in zip(range(9, 3, -1), errors, strict=True)),
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
        slider_crank.scene, thresholds=np.array([1e-3, 1e-9]), until=0.1, repetitions=1, processes=1
    )
    assert [trial.setting.threshold for trial in found.trials] == [None, 1e-9, 1e-3, None]
