"""`adjust_joints`: loops of rounded numbers close by the least change of the joints, and stay closed as they move."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility
from mbproj.linear.equilibrium.start import start_state
from mbproj.scene.scene import read_scene, read_scene_text
from tests.cli.commands import mbproj
from tests.formats.adjusted_wrist import wrist
from tests.support import ROOT


def freedoms(text: str) -> int:
    scene = read_scene_text(text)
    system = compile_system(scene)
    return mobility(system, pose_of(start_state(scene, system).q)).degrees_of_freedom


@pytest.mark.parametrize("digits", [8, 6])
def test_a_rounded_wrist_is_a_structure_and_turns_about_its_point_when_adjusted(digits):
    """Joints move by less than a rounding of their numbers, 10^-digits m."""
    assert freedoms(wrist(digits)) == 0
    assert freedoms(wrist(digits, "1 um")) == 3
    system = compile_system(read_scene_text(wrist(digits, "1 um")))
    assert len(system.adjustments) == 9
    assert 0.0 < max(change.size(system.length) for change in system.adjustments) < 0.5 * 10.0**-digits


def test_more_than_was_allowed_is_refused_with_what_would_do():
    with pytest.raises(InputError, match=r"adjust_joints is 1 um; .* or give adjust_joints: \d+ um") as caught:
        compile_system(read_scene_text(wrist(4, "1 um")))
    enough = str(caught.value).partition("give adjust_joints: ")[2].split("\n")[0]
    assert freedoms(wrist(4, enough)) == 3


@pytest.mark.parametrize("name", ["bennett", "planar_four_bar", "five_bar", "bricard"])
def test_what_closes_exactly_stays_as_it_is(name):
    text = (ROOT / "mechanisms" / f"{name}.yaml").read_text(encoding="utf-8")
    scene = read_scene_text(text.replace("simulation:\n", "simulation:\n  adjust_joints: 1 mm\n", 1))
    assert scene.settings.adjust_joints == 1e-3
    system, before = compile_system(scene), compile_system(read_scene(ROOT / "mechanisms" / f"{name}.yaml"))
    assert not system.adjustments
    np.testing.assert_array_equal(system.joints.local, before.joints.local)


def test_check_and_run_say_alike_which_joints_moved(tmp_path):
    (tmp_path / "wrist.yaml").write_text(wrist(8, "1 um"), encoding="utf-8")
    check = mbproj("check", "wrist.yaml", folder=tmp_path)
    assert check.returncode == 0, check.stderr
    run = mbproj("run", "wrist.yaml", "-o", "r.h5", folder=tmp_path)
    assert run.returncode == 0, run.stderr
    (note,) = [line for line in check.stderr.splitlines() if "joints were moved so that the loops close" in line]
    assert note in run.stderr.splitlines()
    assert note.startswith("wrist.yaml:3:")
