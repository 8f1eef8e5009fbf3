"""`mbproj recommend` and `run --accuracy`, end to end."""

from __future__ import annotations

import json
from functools import partial

import pytest

from mbproj import read_scene
from tests.cli import commands
from tests.support import ROOT

PENDULUM = (ROOT / "mechanisms" / "spherical_pendulum.yaml").read_text()


@pytest.fixture
def mbproj(tmp_path):
    """`mbproj ARGUMENTS` in a folder with pendulum.yaml, with a cache of its own."""
    (tmp_path / "pendulum.yaml").write_text(PENDULUM)
    return partial(commands.mbproj, folder=tmp_path)


def test_the_command_line_that_is_printed_runs_and_json_says_the_same(mbproj, tmp_path):
    done = mbproj("recommend", "pendulum.yaml", "--error", "1 mm", "--until", "1 s")
    assert (done.returncode, done.stderr) == (0, "")
    line, *rest = done.stdout.splitlines()
    assert "  the scene's own  gpopm, rk4, h = 0.005 s: " in done.stdout
    assert rest[0].endswith("0.001 m is asked for, until t = 1 s")
    run = mbproj(*line.split()[1:], "--json")
    assert run.returncode == 0, run.stderr
    again = mbproj("recommend", "pendulum.yaml", "--error", "1e-3", "--until", "1", "--json", "--plot", "search.svg")
    assert again.stderr == "search.svg\n"
    drawn = (tmp_path / "search.svg").read_text()
    assert all(words in drawn for words in ("asked for", "recommended", "dop853, tolerance", "rk4, fixed steps"))
    numbers = json.loads(again.stdout)
    assert numbers["reached"] is True
    assert numbers["best"]["error"] <= 1e-3


def test_write_changes_the_block_and_nothing_else(mbproj, tmp_path):
    done = mbproj("recommend", "pendulum.yaml", "--error", "1e-8", "--write", "-q")
    assert (done.returncode, done.stderr) == (0, "written into pendulum.yaml\n")
    before, after = PENDULUM.splitlines(), (tmp_path / "pendulum.yaml").read_text().splitlines()
    assert len(set(before) - set(after)) <= 2  # step and integrator
    assert [line for line in after if line in before] == [line for line in before if line in after]
    settings = read_scene(tmp_path / "pendulum.yaml").settings
    assert settings.integrator in done.stdout
    assert settings.output_step == 0.005


def test_accuracy_chooses_and_runs(mbproj):
    done = mbproj("run", "pendulum.yaml", "--accuracy", "1e-6", "--duration", "1", "--certify", "--json")
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
def test_refusals(mbproj, arguments, code, message):
    done = mbproj(*arguments)
    assert (done.returncode, message in done.stderr) == (code, True), done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.full
def test_an_error_that_cannot_be_kept_to_the_end_says_until_when(mbproj):
    arguments = ["--error", "3e-14", "--output-step", "0.1", "--until", "3"]
    done = mbproj("recommend", str(ROOT / "mechanisms" / "five_bar.yaml"), *arguments)
    assert done.returncode == 4
    assert "--duration " in done.stdout.splitlines()[0]
    assert "note: no setting keeps 3e-14 m until t = 3 s: errors grow from round-off: starts that" in done.stderr
    assert "; this one keeps it until " in done.stderr
