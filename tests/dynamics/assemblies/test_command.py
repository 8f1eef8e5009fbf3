"""`mbproj branches`: the report, JSON, the scenes that it writes, its picture, and how it fails."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from mbproj.results.reader import open_results
from tests.cli.commands import mbproj
from tests.integrate.kinematic.scenes import FOUR_BAR

CRANK, COUPLER, ROCKER, GROUND = 0.2, float(np.hypot(0.4, 0.4)), float(np.hypot(0.1, 0.4)), 0.7
SCENE = """\
mbproj: 1
title: Four bars
gravity: [0, 0, -9.81]
simulation: {duration: 0.1 s, output_step: 0.1 s, kinematic: true}
parameters: {weight: 1}
"""
SCENE += FOUR_BAR[FOUR_BAR.index("bodies:") :].replace("{mass: 0.4,", "{mass: weight,")
FREE = SCENE[: SCENE.index("motions:")].replace(", kinematic: true", ", step: 1 ms")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "four_bar.yaml").write_text(SCENE)
    (tmp_path / "free.yaml").write_text(FREE)
    return tmp_path


def rockers(crank: float) -> list[float]:
    """Angles of the rocker in both assemblies, from that of the scene, by the cosine rule."""
    x, z = GROUND - CRANK * np.cos(crank), -CRANK * np.sin(crank)
    diagonal, start = np.hypot(x, z), np.arctan2(0.4, -0.1)
    inner = np.arccos((diagonal**2 + ROCKER**2 - COUPLER**2) / (2.0 * diagonal * ROCKER))
    both = np.arctan2(-z, -x) + inner * np.array([-1.0, 1.0]) - start
    return sorted(np.remainder(both + np.pi, 2.0 * np.pi) - np.pi)


def test_it_lists_both_assemblies_of_a_four_bar(folder):
    done = mbproj("branches", "four_bar.yaml", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "Four bars: 2 assemblies"
    assert lines[1].split() == ["A.angle", "B.angle", "C.angle", "D.angle", "found", "distance"]
    assert lines[2].startswith("1 (the start)")
    assert "random starts led to one; one that draws 3 % of such starts or more was missed" in lines[4]


def test_json_has_coordinates_by_name_and_poses(folder):
    done = mbproj("branches", "free.yaml", "--hold", "A.angle=50deg", "--json", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    facts = json.loads(done.stdout)
    assert facts["scene"] == "free.yaml" and facts["written"] == [] and facts["picture"] is None
    assert facts["units"] == dict.fromkeys(("A.angle", "B.angle", "C.angle", "D.angle"), "rad")
    found = facts["assemblies"]
    assert [each["at_start"] for each in found] == [True, False]
    assert not any(each["singular"] for each in found)
    np.testing.assert_allclose([each["coordinates"]["A.angle"] for each in found], np.radians(50.0), atol=1e-12)
    np.testing.assert_allclose(
        sorted(each["coordinates"]["D.angle"] for each in found), rockers(np.radians(50.0)), atol=1e-11
    )
    for each in found:
        pose = each["bodies"]["rocker"]
        np.testing.assert_allclose(
            np.hypot(pose["position"][0] - GROUND, pose["position"][2]), 0.5 * ROCKER, atol=1e-12
        )
        np.testing.assert_allclose(np.linalg.norm(pose["orientation"]), 1.0, atol=1e-13)
    assert sum(each["found"] for each in found) == facts["closed"] <= facts["starts"]
    assert facts["missed"] <= 1e-3 and facts["share"] < 0.05


def test_each_assembly_is_written_as_a_scene_that_starts_there(folder):
    done = mbproj("branches", "four_bar.yaml", "--json", "--write", "starts", "--picture", "both.png", folder=folder)
    facts = json.loads(done.stdout)
    assert facts["written"] == ["starts/four_bar_1.yaml", "starts/four_bar_2.yaml"]
    assert facts["picture"] == "both.png"
    for path, each in zip(facts["written"], facts["assemblies"], strict=True):
        assert mbproj("run", path, "-o", "run.h5", "-q", folder=folder).returncode == 0
        with open_results(folder / "run.h5") as results:
            start = results.body("rocker").position[0]
        np.testing.assert_allclose(start, each["bodies"]["rocker"]["position"], atol=1e-11)


def test_the_picture_shows_them_side_by_side(folder):
    done = mbproj("branches", "four_bar.yaml", "--picture", "both.png", folder=folder)
    assert done.returncode == 0 and done.stdout.splitlines()[-1] == "both.png"
    image = np.asarray(Image.open(folder / "both.png").convert("L"))
    drawn = np.flatnonzero((image < 200).any(axis=0))
    middle = image.shape[1] // 2
    assert (drawn < middle).sum() > 100 and (drawn > middle).sum() > 100


def test_a_search_from_few_starts_says_that_it_is_not_sure(folder):
    done = mbproj("branches", "four_bar.yaml", "--starts", "3", folder=folder)
    assert done.returncode == 0
    assert "search from more poses, --starts 12" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["free.yaml"],
            "--hold: error: 1 degree of freedom is left: assemblies cannot be counted; hold 1 of the coordinates",
        ),
        (
            ["free.yaml", "--hold", "A.angel"],
            "--hold: error: there is no coordinate 'A.angel'; did you mean 'A.angle'?",
        ),
        (
            ["free.yaml", "--hold", "A.angle=3 m"],
            "--hold A.angle: error: '--hold A.angle' is in rad, this is a length, in m",
        ),
        (["four_bar.yaml", "--set", "weight=2", "--write", "w"], "--write: error: --set has changed parameters"),
        (["missing.yaml"], "missing.yaml"),
    ],
)
def test_it_says_what_is_wrong(folder, arguments, message):
    done = mbproj("branches", *arguments, folder=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_files_of_others_are_not_replaced(folder):
    (folder / "starts").mkdir()
    (folder / "starts" / "four_bar_1.yaml").write_text("mine\n")
    (folder / "both.png").write_text("mine\n")
    done = mbproj("branches", "four_bar.yaml", "--write", "starts", folder=folder)
    assert done.returncode == 2 and "starts/four_bar_1.yaml" in done.stderr
    done = mbproj("branches", "four_bar.yaml", "--picture", "both.png", folder=folder)
    assert done.returncode == 2 and "both.png" in done.stderr
    assert (folder / "both.png").read_text() == "mine\n"
    assert mbproj("branches", "four_bar.yaml", "--write", "starts", "--force", folder=folder).returncode == 0
    assert (folder / "starts" / "four_bar_1.yaml").read_text().startswith("mbproj: 1")
