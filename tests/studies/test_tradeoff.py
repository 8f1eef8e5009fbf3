"""A trade-off on the pendulum, whose errors are known to fall with the order: its grid, its fronts, its resumption."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import h5py
import numpy as np
import pytest

from mbproj.errors import InputError
from mbproj.scene import read_scene
from mbproj.studies.measure.certain import certain_reference
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.tradeoff.fronts import by_integrator, by_projection, studied
from mbproj.studies.tradeoff.ladders import tradeoff
from mbproj.studies.tradeoff.result import write_hdf5
from tests.support import ROOT

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
    monkeypatch.setattr("mbproj.studies.measure.certain.CERTAIN", whole.uncertainty[500, 0] / mechanism.system.length)
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
