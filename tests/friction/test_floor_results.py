"""What is said of a point that slides on the plane of a stop: both tangents together, by the name of the stop."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mbproj.results.analysis.contacts import sticking
from mbproj.results.reader import open_results
from tests.cli.commands import mbproj

#: Thrown at 3 and 4 m/s along a floor with μ = 0.5 under g = 10 it rests after 1 s; with 12.5 J less.
SCENE = """\
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 1.6 s, integrator: dop853, tolerance: 1.0e-10, output_step: 0.03 s}
bodies:
  box: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0], velocity: [3, 4, 0]}
forces:
  floor:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: box, location: {box: [0, 0, 0]}}
    rigid: true
    restitution: 0
    friction: {coefficient: 0.5, static: 0.6}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("floor")
    (path / "floor.yaml").write_text(SCENE)
    done = mbproj("run", "floor.yaml", "--json", folder=path)
    assert done.returncode == 0, done.stderr
    return path


def test_both_tangents_are_one_friction(folder):
    (name, found), *others = json.loads(mbproj("info", "results.h5", "--json", folder=folder).stdout)[
        "frictions"
    ].items()
    assert (name, others, found["unit"]) == ("floor", [], "m")
    assert (found["sticks"], found["slips"], found["turns"]) == (1, 0, 0)
    assert found["sticking_seconds"] == pytest.approx(0.6, rel=1e-8)
    assert found["largest_force"] == pytest.approx(5.0, rel=1e-9)
    assert found["energy"] == pytest.approx(12.5, rel=1e-8)


def test_a_tangent_sticks_when_both_do(folder):
    with open_results(folder / "results.h5") as results:
        assert results.names("frictions") == ("floor.1", "floor.2")
        for name in results.names("frictions"):
            np.testing.assert_allclose(sticking(results, name), [(1.0, 1.6)], rtol=1e-8)


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("position: [0, 0, 0], velocity: [0, 0, 0]", "sticking at the start: 'floor' bears 0 of 6 N"),
        ("position: [0, 0, 1], velocity: [0, 0, 0]", "none sticks at the start"),
        ("position: [0, 0, 0], velocity: [3, 4, 0]", "none sticks at the start"),
    ],
)
def test_check_says_whether_the_point_sticks_where_it_touches(folder, place, said):
    (folder / "there.yaml").write_text(SCENE.replace("position: [0, 0, 0], velocity: [3, 4, 0]", place))
    assert f"  1 dry friction, {said}" in mbproj("check", "there.yaml", folder=folder).stdout.splitlines()
