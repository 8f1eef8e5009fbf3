"""`mbproj compare-results`: is it the same motion?"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.commands import FIVE_BAR, mbproj


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    for name, *options in (("a.h5",), ("b.h5", "--output-step", "0.02"), ("c.h5", "--step", "0.02")):
        done = mbproj("run", FIVE_BAR, "-q", "--duration", "2", "-o", name, *options, folder=folder)
        assert done.returncode == 0, done.stderr
    return folder


def test_other_samples_of_one_run_are_the_same_motion(runs: Path) -> None:
    done = mbproj("compare-results", "a.h5", "b.h5", "--tolerance", "1e-15", folder=runs)
    lines = done.stdout.splitlines()
    assert lines[:3] == [
        "a.h5: 201 samples to t = 2 s",
        "b.h5: 101 samples to t = 2 s",
        "compared at the 101 times that both have",
    ]
    assert lines[4].split() == ["bodies/position", "0.00e+00", "m", "bar1", "0", "s", *lines[4].split()[6:8], "same"]
    assert (lines[-1], done.returncode) == ("the same motion", 0)


def test_another_step_is_another_motion(runs: Path) -> None:
    done = mbproj("compare-results", "a.h5", "c.h5", folder=runs)
    assert done.returncode == 4
    assert done.stdout.splitlines()[-1].startswith("they part at t = 0.")
    assert mbproj("compare-results", "a.h5", "c.h5", "--tolerance", "0.01", folder=runs).returncode == 0


def test_json(runs: Path) -> None:
    done = mbproj("compare-results", "a.h5", "c.h5", "--absolute", "markers/position=1 inch", "--json", folder=runs)
    assert done.returncode == 2  # no such unit
    done = mbproj("compare-results", "a.h5", "c.h5", "--absolute", "markers/position=1 um", "--json", folder=runs)
    found = json.loads(done.stdout)
    assert (found["same"], done.returncode, found["samples_compared"], found["ends"]) == (False, 4, 101, [2.0, 2.0])
    marker = next(each for each in found["quantities"] if each["quantity"] == "markers/position")
    assert (marker["allowed"], marker["largest"]["of"], marker["same"]) == (1e-6, "tip", False)
    assert marker["first"]["difference"] > 1e-6
    assert found["parting"]["time"] == min(each["first"]["time"] for each in found["quantities"] if each["first"])


def test_mistakes(runs: Path) -> None:
    for options, message in (
        (["--tolerance", "0"], "--tolerance: error: '--tolerance' must be greater than 0, found 0\n"),
        (
            ["--absolute", "marker/position=1"],
            "--absolute: error: there is no quantity 'marker/position'; did you mean 'markers/position'?\n",
        ),
        (["--absolute", "bodies/position=1 kg"], "--absolute: error: '--absolute' is in m, this is a mass, in kg\n"),
    ):
        done = mbproj("compare-results", "a.h5", "b.h5", *options, folder=runs)
        assert (done.returncode, done.stderr) == (2, message)
    missing = mbproj("compare-results", "a.h5", "d.h5", folder=runs)
    assert (missing.returncode, missing.stderr[:35]) == (2, "error: there is no results file 'd.")
