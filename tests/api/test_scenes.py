"""Scenes of Python objects, and scenes that Python changes: what they are is what YAML says."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

import mbproj
from mbproj import InputError, read_scene, read_scene_text
from mbproj.joints.table import JOINTS
from mbproj.scene.parts import CLASSES
from scripts import write_parts
from tests.crossed import some
from tests.support import ROOT

# Scenes of Python objects: what they build is what YAML says, and errors name the argument.

YAML = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {length: 0.5}
bodies: {rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [length, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: y, angle: 0}}
forces: {spring: {type: torsion_spring_damper, joint: A, stiffness: 10 N*m/rad}}
markers: {tip: {body: rod, location: [1, 0, 0]}}
motions: {}
expect: {start: {marker: tip, quantity: position, component: x, at: 0 s, value: 1, absolute: 1e-12, source: by hand}}
simulation: {duration: 0.1, step: 10 ms}
"""


def built(**changed):
    given = {
        "gravity": np.array([0, 0, -9.81]),
        "parameters": {"length": np.float32(0.5)},
        "bodies": {"rod": mbproj.Body(mass=np.int64(2), inertia=np.full(3, 0.1), position=["length", 0, 0])},
        "joints": {"A": mbproj.Revolute(bodies=("ground", "rod"), location=np.zeros(3), axis="y", angle=0)},
        "forces": {"spring": mbproj.TorsionSpringDamper(joint="A", stiffness="10 N*m/rad")},
        "markers": {"tip": mbproj.Marker(body="rod", location=[1, 0, 0])},
        "expect": {
            "start": mbproj.Expectation(
                marker="tip",
                quantity="position",
                component="x",
                at="0 s",
                value=1,
                absolute=1e-12,
                source="by hand",
            )
        },
        "simulation": mbproj.Simulation(duration=0.1, step="10 ms"),
    }
    return mbproj.Scene.build(**{**given, **changed})


def test_what_is_built_is_what_yaml_says():
    scene, expected = built(), mbproj.read_scene_text(YAML)
    for name in (
        "gravity",
        "bodies",
        "joints",
        "forces",
        "motions",
        "markers",
        "parameters",
        "settings",
        "expectations",
    ):
        assert getattr(scene, name) == getattr(expected, name)
    again = mbproj.read_scene_text(scene.to_yaml())
    assert (again.bodies, again.joints, again.settings) == (scene.bodies, scene.joints, scene.settings)
    with mbproj.run(scene) as results:
        assert results.status == "complete"
    heavier = scene.with_(**{"bodies.rod.mass": np.float64(3)})
    assert heavier.bodies[0].mass == 3.0


def test_every_type_has_a_class_and_every_key_an_argument():
    kinds = {made.type for made in CLASSES.values() if made.type}
    assert set(JOINTS) <= kinds
    for name, made in CLASSES.items():
        assert list(inspect.signature(made).parameters) == sorted(
            made.keys_of_scene, key=lambda key, made=made: key not in made.required
        ), name
        assert all(f"{key}: " in made.__doc__ for key in made.keys_of_scene)
        assert getattr(mbproj, name) is made


def test_errors_name_the_argument():
    with pytest.raises(TypeError, match=r"Body\(\) has no argument 'mas'; did you mean 'mass'"):
        mbproj.Body(mas=1)
    with pytest.raises(TypeError, match=r"Revolute\(\) lacks the argument 'location'"):
        mbproj.Revolute(bodies=["ground", "rod"], axis="y")
    with pytest.raises(mbproj.InputError, match=r"^Scene.build: rod: error: 'mass' must be at least 0, found -1"):
        built(bodies={"rod": mbproj.Body(mass=-1, inertia=[1, 1, 1], position=[0, 0, 0])})
    with pytest.raises(mbproj.InputError, match=r"^Scene.build: spring: error: unknown joint 'B'; choose from: A"):
        built(forces={"spring": mbproj.TorsionSpringDamper(joint="B", stiffness=1)})
    assert repr(mbproj.Gear(joints=["A", "B"], teeth=[10, 20])) == "Gear(joints=['A', 'B'], teeth=[10, 20])"


def test_the_stub_is_what_the_tables_say():
    assert write_parts.STUB.read_text(encoding="utf-8") == write_parts.text(), "run scripts/write_parts.py"


# `Scene.with_` and `Scene.to_yaml`: changes are those of `read_scene`, and what is written reads the same.

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
