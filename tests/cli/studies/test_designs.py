"""`mbproj fit`, `optimise` and `sensitivity` on the command line: what they print and write, and their exit codes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.cli.commands import mbproj
from tests.studies.design.scenes import BALL, table, written

FAR = "maximise: {far: {body: ball, quantity: position, component: x, at: end}}\n"
VARY = "vary: {parameters.angle: [0.1, 1.5]}\nstarts: 1\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path / "cache"))
    times = np.linspace(0.0, 1.0, 11)
    table(tmp_path / "flight.csv", time__s=times, position_x__m=10.0 * np.cos(0.5) * times)
    return tmp_path


def test_fit_prints_writes_and_goes_on(folder, undrawn):
    written(folder, BALL, VARY + "match: {flight: {body: ball, through: flight.csv}}\n")
    first = mbproj("fit", "design.yaml", "-j", "1", folder=folder)
    assert first.returncode == 0, first.stderr
    assert "least_squares, because all that is wanted are residuals" in first.stdout
    assert "flight: 11 points, off by " in first.stdout
    assert {path.name for path in (folder / "design-design").iterdir()} == {
        *("best.yaml", "starts.csv", "design.json", "design.png")
    }
    again = json.loads(mbproj("fit", "design.yaml", "-j", "1", "--json", folder=folder).stdout)
    assert again["reused"] == 1
    assert again["numbers"]["parameters.angle"]["value"] == pytest.approx(0.5, rel=1e-9)


@pytest.mark.full
def test_a_design_is_drawn_again_from_its_folder(folder):
    written(folder, BALL, VARY + "match: {flight: {body: ball, through: flight.csv}}\n")
    assert mbproj("fit", "design.yaml", "-j", "1", "-q", folder=folder).returncode == 0
    done = mbproj("plot", "design-design", "-o", "pictures", "--format", "svg", folder=folder)
    assert done.returncode == 0, done.stderr
    names = [f"design-design-{kind}.svg" for kind in ("fit", "convergence", "correlation")]
    assert [line.rpartition("/")[2] for line in done.stdout.split()] == names
    assert "flight" in (folder / "pictures" / names[0]).read_text()
    for options, said in (
        (("--kind", "front"), "--kind front: the design has one goal alone"),
        (("--kind", "heat"), "unknown kind 'heat' of a design"),
        (("--marker", "tip"), "--marker is for results of runs"),
    ):
        wrong = mbproj("plot", "design-design", *options, folder=folder)
        assert (wrong.returncode, said in wrong.stderr) == (2, True), wrong.stderr
    (folder / "design-design" / "design.json").write_text('{"format": "mbproj design 1", "matches": 3}')
    damaged = mbproj("plot", "design-design", folder=folder)
    assert damaged.returncode == 2
    assert "design.json: error: it is not what mbproj wrote of a design" in damaged.stderr


def test_a_constraint_that_is_not_kept_is_exit_code_3(folder):
    limit = "subject_to: {high: {body: ball, quantity: position, component: z, at: end, at_least: 100 m}}\n"
    written(folder, BALL, VARY + FAR + limit)
    done = mbproj("optimise", "design.yaml", "-j", "1", folder=folder)
    assert done.returncode == 3
    assert "note: no design keeps all constraints" in done.stderr


def test_each_command_names_the_other(folder):
    written(folder, BALL, VARY + FAR)
    done = mbproj("fit", "design.yaml", folder=folder)
    assert done.returncode == 2
    assert "it matches nothing; use: mbproj optimise design.yaml" in done.stderr


def test_what_somebody_else_wrote_is_not_replaced(folder):
    written(folder, BALL, VARY + FAR)
    (folder / "design-design").mkdir()
    (folder / "design-design" / "best.yaml").write_text("mine\n")
    done = mbproj("optimise", "design.yaml", folder=folder)
    assert done.returncode == 2
    assert "best.yaml" in done.stderr
    assert (folder / "design-design" / "best.yaml").read_text() == "mine\n"


def test_sensitivity_is_a_table(folder):
    (folder / "scene.yaml").write_text(BALL)
    done = mbproj("sensitivity", "scene.yaml", "--of", "far", "--to", "angle", "--json", folder=folder)
    (row,) = json.loads(done.stdout)
    assert (row["measure"], row["number"], row["unit"]) == ("far", "angle", "m/rad")
    assert row["elasticity"] == pytest.approx(-np.tan(1.0), rel=1e-9)
