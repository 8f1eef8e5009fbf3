"""`Scene.with_` and `Scene.to_yaml`: changes are those of `read_scene`, and what is written reads the same."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene, read_scene_text
from tests.crossed import some
from tests.support import ROOT

SCENES = sorted((ROOT / "mechanisms").glob("*.yaml"))
FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"


def compared(scene):
    return scene.bodies, scene.joints, scene.forces, scene.motions, scene.markers, scene.parameters, scene.settings


def test_changes_by_path_are_those_of_reading():
    scene = read_scene(FIVE_BAR).with_(**{"bodies.bar3.mass": np.float32(2)})
    assert next(body for body in scene.bodies if body.name == "bar3").mass == 2.0
    assert compared(scene) == compared(read_scene(FIVE_BAR, {"bodies.bar3.mass": 2}))
    with pytest.raises(InputError, match="did you mean 'mass'"):
        scene.with_(**{"bodies.bar3.mas": 2})


def test_settings_from_python_hold():
    scene = read_scene(FIVE_BAR, {}, {"duration": 0.3}).with_(length=1.1)
    assert (scene.settings.duration, scene.parameters["length"]) == (0.3, 1.1)
    assert scene.with_(**{"simulation.duration": 0.7}).settings.duration == 0.7


@pytest.mark.parametrize("path", some(SCENES, 3, 1), ids=lambda path: path.stem)
def test_what_is_written_reads_the_same(path):
    scene = read_scene(path, {}, {"duration": 20, "max_iterations": 24})
    again = read_scene_text(scene.to_yaml(), str(path))
    assert compared(again) == compared(scene)
    assert read_scene(path).to_yaml() == path.read_text(encoding="utf-8")


def test_a_changed_scene_is_written_with_its_changes():
    scene = read_scene(FIVE_BAR).with_(length=1.25, **{"bodies.bar1.mass": 3})
    assert compared(read_scene_text(scene.to_yaml())) == compared(scene)


def test_what_could_not_be_read_again_is_not_written():
    with pytest.raises(InputError, match=r"3 s is after the end of the run, at 0.25 s"):
        read_scene(FIVE_BAR, {}, {"duration": 0.25}).to_yaml()


def test_a_tolerance_alone_takes_an_integrator_with_error_control():
    text = "mbproj: 1\nbodies: {a: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\ngravity: [0, 0, 0]\n"
    scene = read_scene_text(text + "joints: {}\nsimulation: {duration: 1, tolerance: 1e-6}\n")
    assert scene.settings.integrator == "dopri5"
