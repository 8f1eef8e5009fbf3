"""`mbproj recommend`, `run --accuracy` and `run --certify`, end to end."""

from __future__ import annotations

import json
import re
import signal
import time
from dataclasses import replace
from functools import partial

import h5py
import numpy as np
import pytest

from mbproj import open_results, read_scene
from mbproj.commands.report.summary import lines_on
from tests.cli.commands import FIVE_BAR, SLIDER_CRANK, begun, mbproj, succeeds
from tests.cli.commands import mbproj as run_mbproj
from tests.support import ROOT

# `mbproj run --certify`, end to end: the results file, the summary, --json, what is shaded, rerun, interruption.


def test_the_certificate_is_in_the_file_the_summary_and_info(tmp_path):
    done = succeeds("run", FIVE_BAR, "--duration", "4", "--certify", "-o", "a.h5", folder=tmp_path)
    assert "  how far to trust it, by gpopm, dop853, tol 1e-10\n" in done.stdout
    assert "error exceeds  1e-9 m" in done.stdout
    with open_results(tmp_path / "a.h5") as results:
        trust = results.trust
        assert trust.names == ("tip",)
        np.testing.assert_array_equal(trust.time, results.time)
        assert trust.untrusted_from(1e-3) == trust.horizon[0, list(trust.limits).index(1e-3)]
        assert trust.untrusted_from(1e-3, "tip") == pytest.approx(3.8, abs=0.05)
        assert trust.untrusted_from(1.0) is None
        times = {name: np.arange(10.0)[None] for name in ("horizon", "horizon_low", "horizon_high")}
        every = replace(trust, limits=10.0 ** np.arange(-9, 1), **times)
        heads = re.split("  +", [*lines_on(every)][1])
        assert heads[2:-2] == [*(f"1e{power} m" for power in range(-9, 0)), "1 m"]
        better, late = results.better(), results.time >= 3.8
        apart = np.linalg.norm(better.position - results["bodies/position"], axis=-1)[late, -1]
        assert np.all(apart <= 1.5 * trust.error[late, 0]) and np.all(apart >= 0.1 * trust.error[late, 0])
    with h5py.File(tmp_path / "a.h5") as file:
        assert {name: file["trust"][name].attrs["units"] for name in ("horizon", "error", "growth_rate")} == {
            "horizon": "s",
            "error": "m",
            "growth_rate": "1/s",
        }
        assert all(dataset.attrs["description"] for dataset in file["trust"].values())
    shown = mbproj("info", "a.h5", folder=tmp_path).stdout
    assert next(line for line in done.stdout.splitlines() if "tip " in line) in shown


def test_json_has_the_horizons_by_marker(tmp_path):
    arguments = ["--duration", "3", "--certify", "--limit", "1e-2", "--limit", "1e-5", "--json"]
    numbers = json.loads(mbproj("run", SLIDER_CRANK, *arguments, folder=tmp_path).stdout)
    trust = numbers["trust"]
    assert trust["limits"] == [1e-5, 1e-2]
    slider = trust["points"]["slider"]
    assert slider["horizon"][0] == pytest.approx(0.34, abs=0.02)
    assert slider["horizon"][1] is None
    assert slider["largest_uncertainty"] < 0.01 * slider["largest_error"]


def test_rerun_certifies_again_to_the_last_bit(tmp_path):
    arguments = ["--duration", "1", "--certify", "--limit", "1e-12", "--tolerance", "1e-13", "--integrator", "dop853"]
    mbproj("run", FIVE_BAR, *arguments, "--output-step", "0.1", "-q", "-o", "a.h5", folder=tmp_path)
    succeeds("rerun", "a.h5", "-q", "-o", "b.h5", folder=tmp_path)
    with h5py.File(tmp_path / "a.h5") as first, h5py.File(tmp_path / "b.h5") as second:
        assert dict(first["trust"].attrs) == dict(second["trust"].attrs)
        assert "round-off" in first["trust"].attrs["remark"]
        for name in first["trust"]:
            np.testing.assert_array_equal(first["trust"][name][...], second["trust"][name][...], err_msg=name)


@pytest.mark.full
def test_plots_mark_what_is_not_to_be_trusted(tmp_path):
    mbproj("run", FIVE_BAR, "--duration", "1", "--certify", "-q", "-o", "a.h5", folder=tmp_path)
    succeeds("plot", "a.h5", "--error", "1e-5", folder=tmp_path)
    assert (tmp_path / "a-trust.png").exists()
    wrong = mbproj("plot", "a.h5", "--error", "-1", folder=tmp_path)
    assert (wrong.returncode, wrong.stderr.count("--error: error: '--error' must be greater than 0")) == (2, 1)
    mbproj("run", FIVE_BAR, "--duration", "0.1", "-q", "-o", "b.h5", folder=tmp_path)
    wrong = mbproj("plot", "b.h5", "--kind", "trust", folder=tmp_path)
    assert (wrong.returncode, "mbproj run --certify" in wrong.stderr) == (2, True)


def test_a_failed_run_prints_its_certificate_too(tmp_path):
    (tmp_path / "stops.yaml").write_text(
        "mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {duration: 3, step: 0.01}\n"
        "bodies: {bar: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.5, 0, 0]}}\n"
        "joints: {A: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}}\n"
        "forces: {w: {type: torque, body: bar, torque: [0, sqrt(1.5 - t), 0]}}\n"
    )
    done = mbproj("run", "stops.yaml", "--certify", "--json", folder=tmp_path)
    assert done.returncode == 3
    numbers = json.loads(done.stdout)
    assert numbers["status"].startswith("failed: stopped at t = 1.505 s")
    assert 0.0 < numbers["trust"]["points"]["bar"]["horizon"][0] < 0.2


@pytest.mark.full
def test_an_interrupted_run_says_that_it_is_not_certified(tmp_path):
    arguments = ["run", FIVE_BAR, "--formulation", "full", "--duration", "1000", "--certify", "-q", "-o", "a.h5"]
    process = begun(*arguments, folder=tmp_path, when=(tmp_path / "a.h5.part").exists)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    with open_results(tmp_path / "a.h5") as results:
        assert (results.status, results.trust) == ("interrupted", None)
        assert len(results.certified) == 10
    assert "it was to be certified" in mbproj("info", "a.h5", folder=tmp_path).stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--limit", "1e-3"], "--limit: error: needs --certify"),
        (["--certify", "--limit", "0"], "--limit: error: '--limit' must be greater than 0"),
    ],
)
def test_wrong_limits(tmp_path, arguments, message):
    done = mbproj("run", FIVE_BAR, *arguments, folder=tmp_path)
    assert (done.returncode, done.stderr.startswith(message)) == (2, True)


# `mbproj recommend` and `run --accuracy`, end to end.

PENDULUM = (ROOT / "mechanisms" / "spherical_pendulum.yaml").read_text()


@pytest.fixture
def command(tmp_path):
    """`mbproj ARGUMENTS` in a folder with pendulum.yaml, with a cache of its own."""
    (tmp_path / "pendulum.yaml").write_text(PENDULUM)
    return partial(run_mbproj, folder=tmp_path)


def test_the_command_line_that_is_printed_runs_and_json_says_the_same(command, tmp_path):
    done = command("recommend", "pendulum.yaml", "--error", "1 mm", "--until", "1 s")
    assert (done.returncode, done.stderr) == (0, "")
    line, *rest = done.stdout.splitlines()
    assert "  the scene's own  gpopm, rk4, h = 0.005 s: " in done.stdout
    assert rest[0].endswith("0.001 m is asked for, until t = 1 s")
    run = command(*line.split()[1:], "--json")
    assert run.returncode == 0, run.stderr
    again = command("recommend", "pendulum.yaml", "--error", "1e-3", "--until", "1", "--json", "--plot", "search.svg")
    assert again.stderr == "search.svg\n"
    drawn = (tmp_path / "search.svg").read_text()
    assert all(words in drawn for words in ("asked for", "recommended", "dop853, tolerance", "rk4, fixed steps"))
    numbers = json.loads(again.stdout)
    assert numbers["reached"] is True
    assert numbers["best"]["error"] <= 1e-3


def test_write_changes_the_block_and_nothing_else(command, tmp_path):
    done = command("recommend", "pendulum.yaml", "--error", "1e-8", "--write", "-q")
    assert (done.returncode, done.stderr) == (0, "written into pendulum.yaml\n")
    before, after = PENDULUM.splitlines(), (tmp_path / "pendulum.yaml").read_text().splitlines()
    assert len(set(before) - set(after)) <= 2  # step and integrator
    assert [line for line in after if line in before] == [line for line in before if line in after]
    settings = read_scene(tmp_path / "pendulum.yaml").settings
    assert settings.integrator in done.stdout
    assert settings.output_step == 0.005


def test_accuracy_chooses_and_runs(command):
    done = command("run", "pendulum.yaml", "--accuracy", "1e-6", "--duration", "1", "--certify", "--json")
    numbers = json.loads(done.stdout)
    assert numbers["accuracy"] == 1e-6
    assert numbers["accuracy_error"] <= 1e-6
    assert numbers["trust"]["points"]["bob"]["largest_error"] <= 1.01e-6


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["recommend", "pendulum.yaml", "--error", "-1"], 2, "--error: error: '--error' must be greater than 0"),
        (["recommend", "pendulum.yaml", "--error", "1 kg"], 2, "--error: error: '--error' is in m"),
        (["recommend", "pendulum.yaml"], 2, "Missing option '--error'"),
        (["recommend", "pendulum.yaml", "--error", "1", "--write", "--set", "a=1"], 2, "--set: error: --write"),
        (["recommend", "pendulum.yaml", "--error", "1e-19"], 4, "error: no setting keeps the error below 1e-19 m"),
        (["run", "pendulum.yaml", "--accuracy", "1e-19"], 4, "error: no setting keeps the error below 1e-19 m"),
        (["run", "pendulum.yaml", "--accuracy", "1", "--step", "1"], 2, "--step: error: --accuracy chooses the step"),
    ],
)
def test_refusals(command, arguments, code, message):
    done = command(*arguments)
    assert (done.returncode, message in done.stderr) == (code, True), done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.full
def test_an_error_that_cannot_be_kept_to_the_end_says_until_when(command):
    arguments = ["--error", "3e-14", "--output-step", "0.1", "--until", "3"]
    done = command("recommend", str(ROOT / "mechanisms" / "five_bar.yaml"), *arguments)
    assert done.returncode == 4
    assert "--duration " in done.stdout.splitlines()[0]
    assert "note: no setting keeps 3e-14 m until t = 3 s: errors grow from round-off: starts that" in done.stderr
    assert "; this one keeps it until " in done.stderr
