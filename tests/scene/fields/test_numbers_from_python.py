"""What a Python caller gives in place of text: numbers, flags and lists, also of NumPy; and scenes as mappings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml

from mbproj import InputError, Setting, read_scene, read_scene_text
from tests.crossed import some
from tests.support import MECHANISMS, ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"


@pytest.mark.parametrize("number", [np.float64(0.1), np.float32(0.25), np.int64(2), np.longdouble(0.5), np.array(3.0)])
def test_a_number_of_numpy_is_the_number_that_it_is(number):
    found, again = (read_scene(FIVE_BAR, {"bodies.bar1.mass": each}) for each in (number, float(number)))
    assert found.bodies == again.bodies
    assert found.bodies[0].mass == float(number)
    assert float(found.overrides["bodies.bar1.mass"]) == float(number)


def test_arrays_are_lists_and_what_was_changed_reads_the_same():
    found = read_scene(FIVE_BAR, {"gravity": np.array([0.0, 1e-5, -9.5])}, {"break_times": np.array([0.1, 0.2])})
    assert (found.gravity, found.settings.break_times) == ((0.0, 1e-5, -9.5), (0.1, 0.2))
    assert read_scene(FIVE_BAR, found.overrides).gravity == found.gravity
    assert read_scene(FIVE_BAR, {"gravity": (0.0, -1e-5, -9.5)}).overrides == {"gravity": '[0.0, "-1e-05", -9.5]'}


def test_settings_take_numbers_and_flags_of_numpy():
    given = {"step": np.float64(0.01), "every": np.int32(2), "project_velocity": np.bool_(False)}
    found = read_scene(FIVE_BAR, simulation={**given, "duration": np.float32(0.5)}).settings
    assert (found.step, found.duration, found.projection.every, found.projection.velocity) == (0.01, 0.5, 2, False)


@pytest.mark.parametrize("path", some(MECHANISMS, 3, 2), ids=lambda path: path.stem)
def test_a_scene_may_be_a_mapping(path):
    found, again = read_scene_text(yaml.load(path.read_text(), yaml.BaseLoader)), read_scene(path)
    elsewhere = {"text": "", "path": None, "places": {}, "notes": ()}
    assert replace(found, **elsewhere) == replace(again, **elsewhere)
    assert replace(read_scene_text(found.text), **elsewhere) == replace(again, **elsewhere)


def test_a_mapping_has_numbers_of_numpy_and_nothing_where_a_bound_is_left_out():
    stopped = {"displacement": {"range": [np.float64(-0.5), None], "rigid": True}}
    rail = {"type": "prismatic", "bodies": ["ground", "b"], "location": np.zeros(3), "axis": [0, 0, 1]}
    body = {"mass": np.int64(2), "inertia": np.ones(3), "position": [0, 0, 0]}
    scene = {"mbproj": 1, "gravity": np.array([0, 0, -9.8]), "bodies": {"b": body}}
    found = read_scene_text({**scene, "joints": {"rail": {**rail, "limits": stopped}}})
    assert (found.bodies[0].mass, found.gravity) == (2.0, (0.0, 0.0, -9.8))
    with pytest.raises(InputError, match="unknown key 'mas'"):
        read_scene_text({**scene, "bodies": {"b": {**body, "mas": 2}}})


def test_parameters_in_the_place_of_the_name_are_refused():
    with pytest.raises(TypeError, match="give parameters="):
        read_scene_text(FIVE_BAR.read_text(), {"bodies.bar1.mass": 2})


def test_a_setting_says_which_names_it_has_and_writes_numbers_of_numpy():
    with pytest.raises(InputError, match=r"a setting has no 'method'; choose from: projection, integrator, step"):
        Setting(method="gopm")
    with pytest.raises(InputError, match="did you mean 'tolerance'"):
        Setting(tolerence=1e-6)
    found = Setting(step=np.float64(0.01), every=np.int64(2), gains=np.array([1.0, 2.0]))
    assert found == Setting(step=0.01, every=2, gains=(1.0, 2.0))
    assert found.command_line() == "--integrator rk4 --step 0.01 --projection gpopm --every 2"
