"""Degrees of freedom, verdict, and distance from a singular pose of mechanisms that lean, or whose numbers are rounded.

`check`, `run` and the full formulation agree. `python scripts/turned_mechanisms.py` asks all shipped mechanisms."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import InputError
from mbproj.base.mechanisms_folder import mechanism
from mbproj.scene.scene import read_scene
from scripts.turned_mechanisms import disagreements, turned
from tests.crossed import once, some

#: A four-bar with a hinge that is tilted.
FOUR_BAR = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {{tilt: {tilt}}}
simulation: {{duration: 20 ms, step: 5 ms, formulation: {formulation}{more}}}
bodies:
  crank: {{mass: 1, inertia: [1e-3, 2e-3, 2e-3], position: [0.04, 0, 0.09]}}
  coupler: {{mass: 2, inertia: [0.02, 0.02, 0.02], position: [0.3, 0, 0.24]}}
  rocker: {{mass: 1, inertia: [6e-3, 6e-3, 1e-3], position: [0.48, 0, 0.15]}}
joints:
  A: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}}
  B: {{type: revolute, bodies: [crank, coupler], location: [0.08, 0, 0.18], axis: [0, 1, 0]}}
  C: {{type: revolute, bodies: [coupler, rocker], location: [0.52, 0, 0.3], axis: [0, 1, 0]}}
  D: {{type: revolute, bodies: [ground, rocker], location: [0.44, 0, 0], axis: [sin(tilt), cos(tilt), 0]}}
{motions}
"""


def four_bar(tilt=0.0, formulation="auto", more="", motions=""):
    return FOUR_BAR.format(tilt=tilt, formulation=formulation, more=more, motions=motions)


@pytest.mark.parametrize(
    "name, every", some([("bennett", 5), ("n_four_bar", 6), ("locomotive", 8), ("hooke_shaft", 8)], 4)
)
def test_shipped_mechanisms_do_not_depend_on_how_they_lean(name, every):
    assert list(disagreements(read_scene(mechanism(name)), every)) == []


def leaning(angle, driven):
    """The four-bar turned about an axis in its plane."""
    motions = "motions:\n  drive: {joint: A, angle: {constant_speed: 2}}" if driven else ""
    return turned(mbproj.read_scene_text(four_bar(motions=motions)), np.array([0.6, 0.0, 0.8]), angle)


@pytest.mark.parametrize(
    ("angle", "driven"), some(once([1e-9, 4e-9, 1.3e-8, 2.7e-8, 1e-7, 1e-6, 1e-4, 1e-2, 1.0], [False, True]), 3)
)
def test_a_leaning_four_bar_is_as_free_as_an_upright_one(angle, driven):
    upright, found = mbproj.check(leaning(0.0, driven)), mbproj.check(leaning(angle, driven))
    assert found.can_run
    assert found.degrees_of_freedom == upright.degrees_of_freedom == (0 if driven else 1)
    assert [entry.permanent for entry in found.diagnosis.redundancy.sets] == [True] * 3
    assert not any(entry.contradictory for entry in found.diagnosis.redundancy.sets)
    assert found.diagnosis.conditioning.distance == pytest.approx(upright.diagnosis.conditioning.distance, rel=1e-6)
    assert found.diagnosis.conditioning.distance > 0.1
    assert found.diagnosis.conditioning.scaled < 100.0
    assert mbproj.check(leaning(angle, driven), formulation="full", kinematic=False).choice.redundant == 3


@pytest.mark.parametrize(("tilt", "formulation"), once([1e-10, 1e-9, 1e-8], ["auto", "full"]))
def test_a_tilt_within_rounding_leaves_the_freedom_that_check_and_run_see(tilt, formulation):
    text = four_bar(tilt, formulation)
    assert mbproj.check(text).degrees_of_freedom == 1
    assert mbproj.check(text).diagnosis.verdict == "far from singular poses"
    assert mbproj.run(text).attributes["degrees_of_freedom"] == 1


@pytest.mark.parametrize(("tilt", "formulation"), once([3e-7, 1e-5, 3e-4], ["auto", "full"]))
def test_a_tilted_hinge_locks_with_words_in_every_formulation(tilt, formulation):
    text = four_bar(tilt, formulation)
    (problem,) = mbproj.check(text).problems
    assert "the joints lock" in problem.message and "adjust_joints" in problem.hint
    with pytest.raises(InputError, match="the joints lock"):
        mbproj.run(text)


def test_joints_that_are_adjusted_are_as_free_as_exact_ones():
    found = mbproj.check(four_bar(3e-7, more=", adjust_joints: 1 um"))
    assert found.can_run and found.degrees_of_freedom == 1
    assert all(entry.permanent and not entry.contradictory for entry in found.diagnosis.redundancy.sets)


def test_speeds_that_open_a_tilted_loop_name_the_joint_that_opens():
    text = four_bar(1e-4).replace(
        "location: [0, 0, 0], axis: [0, 1, 0]}", "location: [0, 0, 0], axis: [0, 1, 0], speed: 30}"
    )
    with pytest.raises(InputError, match=r"joint '[ABCD]' would open at \S+ rad/s"):
        mbproj.check(text)


def test_an_almost_stretched_pose_is_no_redundancy():
    """A parallelogram a little from flat: at it four rows depend on others, but three of them for good."""
    h = 1e-7
    text = f"""
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 1 ms, step: 1 ms}}
bodies:
  left: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.1, 0, {0.5 * h}]}}
  bar: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.5, 0, {h}]}}
  right: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.7, 0, {0.5 * h}]}}
joints:
  A: {{type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0]}}
  B: {{type: revolute, bodies: [left, bar], location: [0.2, 0, {h}], axis: [0, 1, 0]}}
  C: {{type: revolute, bodies: [bar, right], location: [0.8, 0, {h}], axis: [0, 1, 0]}}
  D: {{type: revolute, bodies: [ground, right], location: [0.6, 0, 0], axis: [0, 1, 0]}}
"""
    found = mbproj.check(text)
    assert [entry.permanent for entry in found.diagnosis.redundancy.sets] == [True] * 3
    assert found.diagnosis.verdict == "all but singular"
    assert 1e-9 < found.diagnosis.conditioning.distance < 1e-6
