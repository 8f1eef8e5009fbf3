"""Commands on scenes with dry friction."""

from __future__ import annotations

import json

import pytest

from tests.cli.commands import mbproj
from tests.friction.scenes import BELT

#: Two arms of 1 kg each with their masses at 1 m and 3 m from the wall: a brake that holds 40 N m bears both, the other
#: one its own arm. The third joint slides.
ARMS = """\
mbproj: 1
title: Arms
gravity: [0, 0, -10]
parameters: {most: 45 N*m}
simulation: {duration: 1 s, step: 1 ms}
bodies:
  upper: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
  lower: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [3, 0, 0]}
  wheel: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 1, 0]}
joints:
  A: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [upper, lower], location: [2, 0, 0], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [ground, wheel], location: [0, 1, 0], axis: [0, 1, 0], speed: 3}
forces:
  shoulder: {type: friction, joint: A, coulomb: {torque: 5, static: most}}
  elbow: {type: friction, joint: B, coulomb: {torque: 10, static: 12}}
  axle: {type: friction, joint: C, coulomb: {torque: 0.5}}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "arms.yaml").write_text(ARMS)
    (tmp_path / "belt.yaml").write_text(BELT)
    return tmp_path


def test_check_says_what_sticks_at_the_start_and_what_it_bears(folder):
    said = mbproj("check", "arms.yaml", folder=folder).stdout.splitlines()
    line = "  3 dry frictions, sticking at the start: 'shoulder' bears 40 of 45 N m, 'elbow' bears 10 of 12 N m"
    assert line in said
    found = json.loads(mbproj("check", "arms.yaml", "--json", folder=folder).stdout)["frictions_at_start"]
    assert [entry["sticks"] for entry in found.values()] == [True, True, False]
    assert [abs(entry["force"]) for entry in found.values()] == pytest.approx([40.0, 10.0, 0.5], rel=1e-12)
    assert [entry["static"] for entry in found.values()] == pytest.approx([45.0, 12.0, 0.5], rel=1e-12)
    assert (found["axle"]["direction"], found["axle"]["rate"]) == (1.0, pytest.approx(3.0))


def test_a_brake_that_is_too_weak_slips_at_the_start(folder):
    said = mbproj("check", "arms.yaml", "--set", "most=39", folder=folder).stdout
    assert "'shoulder' bears" not in said and "3 dry frictions, sticking at the start: 'elbow' bears" in said


def test_the_integrator_may_be_chosen_on_the_way(folder):
    options = ("--integrator", "auto", "--tolerance", "1e-6")
    assert mbproj("check", "belt.yaml", *options, folder=folder).returncode == 0
    done = mbproj("run", "belt.yaml", *options, folder=folder)
    assert done.returncode == 0, done.stderr
    assert "dop853 throughout: " in done.stdout


def test_compare_divides_no_energy_of_friction(folder):
    """Steps that end where a friction sticks or slips are not those that the split makes again."""
    options = ("--projections", "gpopm", "--until", "0.2", "--repeat", "1", "-j", "1", "--json")
    done = mbproj("compare", "belt.yaml", *options, folder=folder)
    assert done.returncode == 0, done.stderr
    (entry,) = json.loads(done.stdout)["entries"]
    assert entry["error"] < 1e-9 and entry["failure"] == ""
    assert entry["energy_drift_integrator"] is entry["energy_drift_projection"] is None
