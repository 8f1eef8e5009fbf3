"""Verdicts on planes that the topology alone gives: they are those of the whole analysis, to the bit."""

from __future__ import annotations

import dataclasses
import sys

import numpy as np
import pytest

from mbproj import Mechanism
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import NotPlanar, planar_reduction
from mbproj.scene.scene import SceneText
from tests.model.planar_scenes import REFUSED, SCENES, Drawing, reduced, turns
from tests.support import MECHANISMS

REDUCTION = sys.modules["mbproj.model.planar.reduction"]
FOUR_BAR = SceneText(
    next(path for path in MECHANISMS if path.stem == "n_four_bar").read_text(encoding="utf-8"), "scene"
)


def numbers(part) -> list:
    """All that a plane holds, arrays as their bytes."""
    if isinstance(part, np.ndarray):
        return [part.dtype.str, part.shape, part.tobytes()]
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        return [numbers(getattr(part, field.name)) for field in dataclasses.fields(part)]
    return [part]


@pytest.fixture
def calls(monkeypatch):
    """Lists that the results of `certain_plane` and those of `escape`, the test of the rank, are added to."""
    found = {"certain": [], "escape": []}
    for name, own in (("certain", "certain_plane"), ("escape", "escape")):
        whole = getattr(REDUCTION, own)

        def kept(*given, whole=whole, name=name):
            found[name].append(whole(*given))
            return found[name][-1]

        monkeypatch.setattr(REDUCTION, own, kept)
    return found


def both(system, q, monkeypatch):
    """The verdict, and that of the whole analysis."""
    short = planar_reduction(system, q)
    with monkeypatch.context() as patched:
        patched.setattr(REDUCTION, "certain_plane", lambda *_: None)
        return short, planar_reduction(system, q)


@pytest.mark.parametrize("name", [*SCENES, *REFUSED])
def test_it_is_the_verdict_of_the_whole_analysis(name, monkeypatch):
    build = SCENES[name] if name in SCENES else REFUSED[name][0]
    for turn in turns(9)[:2]:
        system, q, _ = reduced(build(Drawing(9, turn)))
        short, whole = both(system, q, monkeypatch)
        assert type(short) is type(whole)
        assert numbers(short) == numbers(whole)


def test_other_lengths_are_not_analysed_again(calls, monkeypatch):
    for length in (1.0, 1.1, 0.7, 1.0000001):
        mechanism = Mechanism.of(FOUR_BAR.scene({"length": length}))
        short, whole = both(mechanism.system, mechanism.state.q, monkeypatch)
        assert isinstance(short, Plane)
        assert numbers(short) == numbers(whole)
    assert [found.is_held for found in calls["certain"]] == [True] * 4
    assert len(calls["escape"]) == 4  # of the whole analysis alone


SCENE = """\
mbproj: 1
gravity: [0, 0, 0]
parameters: {lean: 0, beside: 1 m}
bodies:
  rod: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  tip: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
"""


def verdicts(joints: str, name: str, values: list[float]) -> list[type]:
    """Those of the scene with further joints and these values of a parameter."""
    text = SceneText(SCENE + joints + "simulation: {duration: 1 s}\n", "scene")
    found = [Mechanism.of(text.scene({name: value})) for value in values]
    return [type(planar_reduction(each.system, each.state.q)) for each in found]


def test_an_axis_that_leans_is_analysed_again(calls):
    hinge = "  B: {type: revolute, bodies: [rod, tip], location: [1, 0, 0], axis: [0, 1, lean]}\n"
    assert verdicts(hinge, "lean", [0.0, 0.1, 0.0]) == [Plane, NotPlanar, Plane]
    assert [found is not None and found.is_held for found in calls["certain"]] == [True, False, True]


def test_a_rank_that_depends_on_lengths_is_looked_at_each_time(calls):
    """The tip hangs on a ball, and two of its points stay in the plane: unless these are in line with the ball."""
    joints = """\
  B: {type: spherical, bodies: [rod, tip], location: [1, 0, 0]}
  C: {type: point_in_plane, bodies: [ground, tip], location: [1, 0, 1], axis: [0, 1, 0]}
  D: {type: point_in_plane, bodies: [ground, tip], location: [1 + beside, 0, 1], axis: [0, 1, 0]}
"""
    assert verdicts(joints, "beside", [1.0, 0.0, 2.0]) == [Plane, NotPlanar, Plane]
    assert [found.is_held for found in calls["certain"]] == [False] * 3
    assert len(calls["escape"]) >= 3
