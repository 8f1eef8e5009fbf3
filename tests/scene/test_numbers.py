"""Numbers of a scene: ranges, extreme ones, those that Python gives, and those that other programs read."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from math import log

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj import InputError, Setting, assemble, compile_system, initial_guess, read_scene, read_scene_text
from mbproj.base.text import plain_number
from mbproj.scene.fields.reading import Reading
from mbproj.scene.ranges import RANGE, Listed, Normal, Points, Spaced, Uniform, given_range, named_range
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import flow
from tests.cli.commands import mbproj
from tests.crossed import some
from tests.scene.scenes import GOOD, changed, errors
from tests.support import MECHANISMS, ROOT

# Ranges: how they are written, what values they have, and what is said of wrong ones.


def read(text):
    """The range that the value of a key is, or the lines of what is wrong with it."""
    root, _ = compose(f"key: {text}", "spec.yaml")
    reading = Reading()
    found = RANGE.read(root.values["key"], ("key",), reading)
    return found if found is not None else [problem.line() for problem in reading.problems]


def test_evenly_spaced_values_begin_and_end_where_they_are_told_to():
    for text in ("0.8 m:120 cm:5", "{linspace: [0.8 m, 120 cm, 5]}"):
        found = read(text)
        assert isinstance(found, Spaced)
        assert found.items == pytest.approx((0.8, 0.9, 1.0, 1.1, 1.2), rel=1e-15)
        assert (found.item(0), found.item(4)) == (0.8, 1.2)
        assert [flow(node) for node in found.nodes] == ["0.8 m", "120 cm"]


def test_logarithms_are_evenly_spaced():
    for text in ("1:1000:4:log", "{log: [1, 1000, 4]}"):
        found = read(text)
        assert found.items == pytest.approx((1.0, 10.0, 100.0, 1000.0), rel=1e-14)
        assert (found.item(0), found.item(3)) == (1.0, 1000.0)


def test_a_list_holds_numbers_in_si_words_and_lists_of_their_own():
    assert read("[1 g, gopm, [0, 0, 1], 2 * length]").items == (0.001, "gopm", "[0, 0, 1]", "2 * length")
    assert read("2 m").items == (2.0,)
    assert given_range("1,2,4", "--vary").items == (1.0, 2.0, 4.0)


def test_distributions_have_their_quantiles():
    uniform, normal = read("{uniform: [1 m, 3 m]}"), read("{normal: {mean: 100 mm, deviation: 0.1 mm}}")
    assert isinstance(uniform, Uniform)
    assert isinstance(normal, Normal)
    assert uniform.quantile(0.25) == 1.5
    assert normal.quantile(0.5) == pytest.approx(0.1)
    assert normal.quantile(0.8413447460685429) == pytest.approx(0.1001, abs=1e-12)  # Φ(1)
    assert not isinstance(uniform, Points)


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.integers(2, 50), st.booleans())
def test_values_are_evenly_spaced_in_their_measure(first, last, count, logarithmic):
    found = Spaced((), None, first, last, count, logarithmic)
    numbers = [log(item) if logarithmic else item for item in found.items]
    steps = [two - one for one, two in pairwise(numbers)]
    assert steps == pytest.approx([(numbers[-1] - numbers[0]) / (count - 1)] * (count - 1), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("1:2", "spec.yaml:1:6: error: 'key' needs first:last:count, found '1:2'"),
        ("1:2:1", "spec.yaml:1:10: error: 'count' must be at least 2, found 1"),
        ("1:x:3", "spec.yaml:1:8: error: unknown name 'x'; parameters are defined under 'parameters'"),
        ("0:1:3:log", "spec.yaml:1:6: error: 'key' needs numbers above 0 for their logarithms"),
        ("{linspac: [1, 2, 3]}", "spec.yaml:1:7: error: unknown range 'linspac'; did you mean 'linspace'?"),
        ("{uniform: [1 m, 2 kg]}", "spec.yaml:1:22: error: a length and a mass are no range"),
        ("{uniform: [2, 1]}", "spec.yaml:1:16: error: 'uniform' has nothing between 2 and 1"),
        ("{normal: {mean: 1}}", "spec.yaml:1:7: error: 'normal' needs {mean: .., deviation: ..}, found a mapping"),
        (
            "{normal: {mean: 1, deviation: 0}}",
            "spec.yaml:1:36: error: 'deviation' must be greater than 0, found 0",
        ),
        (
            "[]",
            "spec.yaml:1:6: error: 'key' needs a list of values, first:last:count, or one of {linspace, log, uniform, "
            "normal}, found a list of 0",
        ),
    ],
)
def test_what_is_wrong_is_said_at_its_place(text, line):
    assert read(text) == [line]


def test_an_option_names_what_varies():
    name, found = named_range("crank = 1 mm:3 mm:3", "--vary")
    assert (name, found.items) == ("crank", (0.001, 0.002, 0.003))
    assert isinstance(named_range("projection=gopm,gpopm", "--vary")[1], Listed)
    with pytest.raises(InputError, match="--vary: error: 'crank' is not NAME=RANGE; e"):
        named_range("crank", "--vary")
    with pytest.raises(InputError, match="--vary crank: error: '--vary crank' needs first:last:count, found '1:2'"):
        named_range("crank=1:2", "--vary")


# What a Python caller gives in place of text: numbers, flags and lists, also of NumPy; and scenes as mappings.

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


# Numbers at the ends of the doubles are refused where their products or quotients would be none.

SCENES = [
    (changed("duration: 10", "duration: 1e-308"), "'duration' is 1e-308: numbers below 1e-50"),
    (changed("step: 0.01\n  integrator", "step: 5e-324\n  integrator"), "'step' is 4.94066e-324: numbers below 1e-50"),
    (changed("mass: 0.12", "mass: 1e300"), "'mass' is 1e+300: numbers beyond 1e+50"),
    (
        changed("    mass: 0.12\n", "    mass: 0.12\n    appearance: {mesh: {file: crank.stl, scale: 1e300}}\n"),
        "'scale' is 1e+300: numbers beyond 1e+50",
    ),
]


@pytest.mark.parametrize(("text", "message"), SCENES)
def test_a_scene(text: str, message: str) -> None:
    (error,) = errors(text)
    assert message in error and "in SI units overflow when" in error


OPTIONS = [
    ("threshold", "--thresholds", "1e305,1e-3", "'--thresholds' is 1e+305: numbers beyond 1e+50"),
    ("stability --vary step", "--from", "5e-324", "'--from' is 4.94066e-324: numbers below 1e-50"),
    ("stability --vary step", "--to", "1e308", "'--to' is 1e+308: numbers beyond 1e+50"),
]


@pytest.mark.parametrize(("command", "option", "value", "message"), OPTIONS)
def test_an_option(tmp_path, command: str, option: str, value: str, message: str) -> None:
    (tmp_path / "f.yaml").write_text(GOOD, encoding="utf-8")
    done = mbproj(*command.split(), "f.yaml", f"{option}={value}", folder=tmp_path)
    assert done.returncode == 2 and message in done.stderr, done.stderr


@pytest.mark.parametrize("command", ["plot", "animate"])
@pytest.mark.parametrize("option", ["--from", "--to"])
def test_times_that_are_no_number(tmp_path, command: str, option: str) -> None:
    done = mbproj(command, "none.h5", f"{option}=nan", folder=tmp_path)
    assert done.returncode == 2 and f"{option}: error: numbers must be finite" in done.stderr, done.stderr


PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.01, step: 1 ms}
bodies: {bob: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, -1], velocity: [0, 0, 3e11]}}
joints: {A: {type: spherical, bodies: [ground, bob], location: [0, 0, 0]}}
"""


def test_round_off_of_huge_velocities_asks_no_joint_for_its_speed() -> None:
    """What the joints leave of them is small beside them, and no joint has asked for a speed."""
    scene = read_scene_text(PENDULUM)
    system = compile_system(scene)
    assert abs(assemble(system, initial_guess(scene, system)).v[2]) < 1.0


# Numbers in files: what other programs read as that number too, and nothing else that Python takes.


@settings(derandomize=True, deadline=None)
@given(st.floats())
def test_numbers_survive(number: float) -> None:
    found = plain_number(f" {number!r}\t")
    assert np.array(found).tobytes() == np.array(number).tobytes() or (math.isnan(found) and math.isnan(number))


@pytest.mark.parametrize("text", ["-7", "+7.", ".5", "7e-3", "7E+3", "Inf", "-infinity", "nan"])
def test_the_usual_forms_are_read(text: str) -> None:
    assert repr(plain_number(text)) == repr(float(text))


@pytest.mark.parametrize("text", ["8_9", "1_000.5", "1e1_0", "８９", "٣", "0x10", "1,5", "1 2", "", "e3", "--1", "ınf"])
def test_other_forms_are_none(text: str) -> None:
    with pytest.raises(ValueError, match="could not convert"):
        plain_number(text)
