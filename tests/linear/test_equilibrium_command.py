"""`mbproj equilibrium` and what begins there: the report, the file, the scene that is written, runs."""

from __future__ import annotations

import json
import re
from math import pi

import numpy as np
import pytest

from mbproj.results.reader import open_results
from tests.cli.commands import mbproj
from tests.linear.closed_forms import HEAD

SCENE = (
    HEAD
    + """\
bodies:
  bar:                                   # a comment
    mass: 2
    inertia: [0.1, 0.2, 0.2]
    position: [0.5, 0, 0]
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0], speed: 2 rad/s}   # another
"""
)
FALLS = HEAD + "bodies:\n  stone: {mass: 3, inertia: [1, 1, 1], position: [0, 0, 0]}\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    (tmp_path / "falls.yaml").write_text(FALLS)
    return tmp_path


def test_json_has_stable_keys_and_the_file_one_sample(folder):
    found = json.loads(mbproj("equilibrium", "scene.yaml", "--json", folder=folder).stdout)
    assert (found["converged"], found["stable"], found["neutral"]) == (True, True, [])
    assert found["coordinates"] == {"pin.angle": pytest.approx(pi / 2, rel=1e-14)}
    assert found["reactions"]["pin"]["force"] == pytest.approx([0, 0, 2 * 9.81], abs=1e-12)
    assert found["residual"]["relative"] < 1e-14
    with open_results(folder / "equilibrium.h5") as results:
        assert results.time.tolist() == [0.0]
        np.testing.assert_allclose(results.body("bar").position[0], [0, 0, -0.5], atol=1e-15)
        assert not results.body("bar").velocity.any()


def test_the_pose_is_written_into_the_scene_and_the_run_stays_there(folder):
    done = mbproj("equilibrium", "scene.yaml", "--write", folder=folder)
    assert "scene.yaml: the joints start there now" in done.stdout
    text = (folder / "scene.yaml").read_text()
    assert "# a comment" in text and "# another" in text and "speed" not in text
    assert re.sub(r", angle: 1\.5707963267948\d+", "", text) == SCENE.replace(", speed: 2 rad/s", "")
    assert mbproj("run", "scene.yaml", "-o", "r.h5", folder=folder).returncode == 0
    with open_results(folder / "r.h5") as results:
        assert np.abs(results.coordinate("pin.angle").value - pi / 2).max() < 1e-13


@pytest.mark.parametrize("way", ["option", "scene"])
def test_a_run_begins_there(folder, way):
    if way == "scene":
        (folder / "scene.yaml").write_text(SCENE.replace("step: 1 ms}", "step: 1 ms, start: equilibrium}"))
    more = ["--start", "equilibrium"] if way == "option" else []
    assert mbproj("run", "scene.yaml", "-o", "r.h5", *more, folder=folder).returncode == 0
    assert mbproj("rerun", "r.h5", "-o", "again.h5", folder=folder).returncode == 0
    for name in ("r.h5", "again.h5"):
        with open_results(folder / name) as results:
            assert results.settings.start == "equilibrium"
            assert np.abs(results.coordinate("pin.angle").value - pi / 2).max() < 1e-13


def test_what_has_none_fails_and_says_why(folder):
    done = mbproj("equilibrium", "falls.yaml", "--json", folder=folder)
    assert done.returncode == 3
    assert json.loads(done.stdout)["converged"] is False
    assert "there is no equilibrium: nothing balances 29.43 N" in done.stderr
    done = mbproj("run", "falls.yaml", "--start", "equilibrium", folder=folder)
    assert (done.returncode, "there is no equilibrium" in done.stderr) == (3, True)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--steady", "pin.angle"], "--steady: error: 'pin.angle' is not NAME=RATE"),
        (["--steady", "pin.angl=60rpm"], "--steady: error: unknown joint coordinate 'pin.angl'; did you mean"),
        (["--steady", "pin.angle=60 m"], "--steady pin.angle: error: '--steady pin.angle' is in rad/s"),
        (["--steady", "pin.angle=60rpm"], "forces do not turn with the mechanism"),
        (["--write", "--steady", "pin.angle=60rpm"], "--write: error: a steady turn is no pose at rest"),
        (["--at", "-1"], "--at: error: '--at' must be at least 0"),
    ],
)
def test_what_is_wrong_is_said_at_its_place(folder, arguments, said):
    done = mbproj("equilibrium", "scene.yaml", *arguments, folder=folder)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr


def test_a_pose_that_joints_do_not_tell_is_not_written(folder):
    text = SCENE.replace("type: revolute", "type: spherical").replace(", axis: [0, 1, 0], speed: 2 rad/s", "")
    (folder / "ball.yaml").write_text(text)
    done = mbproj("equilibrium", "ball.yaml", "--write", folder=folder)
    assert (done.returncode, "begin runs there with 'start: equilibrium'" in done.stderr) == (2, True)
    assert (folder / "ball.yaml").read_text() == text
