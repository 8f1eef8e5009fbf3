"""`--set` and settings changed in the text of a scene."""

from __future__ import annotations

import pytest

from mbproj.base.errors import InputError
from mbproj.scene.changes import with_simulation
from mbproj.scene.scene import read_scene, read_scene_text
from tests.support import ROOT

# `--set`: parameters by name and any value by its path, and what is said of paths that lead nowhere.

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"


def changed(**values):
    return read_scene(FIVE_BAR, {path.replace("__", "."): value for path, value in values.items()})


def test_any_value_changes_by_its_path():
    scene = changed(bodies__bar3__mass="2 kg", bodies__bar1__position__0="400 mm", gravity="[0, 0, -1.6]")
    assert scene.bodies[2].mass == 2.0
    assert scene.bodies[0].position == (0.4, 0.0, 0.0)
    assert scene.bodies[1].mass == 1.0
    assert changed(parameters__length=2).bodies[0].position == (1.0, 0.0, 0.0)


def test_a_list_may_take_the_place_of_a_value():
    scene = changed(bodies__bar3__inertia="[1, 2, 2.5]")
    assert [scene.bodies[2].inertia[k][k] for k in range(3)] == [1.0, 2.0, 2.5]


def test_what_an_item_leaves_out_may_be_given():
    assert changed(bodies__bar1__velocity="[0, 0, 1]").bodies[0].velocity == (0.0, 0.0, 1.0)
    settings = changed(simulation__projection__every="3").settings
    assert (settings.projection.method, settings.projection.every) == ("gpopm", 3)


def test_a_tolerance_takes_the_place_of_the_step():
    settings = changed(simulation__tolerance="1e-8", simulation__integrator="dop853").settings
    assert (settings.step, settings.tolerance) == (None, 1e-8)


def test_a_path_leads_to_a_key_with_a_dot():
    """A coupler names a joint's coordinate where the joint has several: its weight is a value as any other."""
    joints = "{type: coupler, of: {A: 2, B.angle: 1}}"
    text = FIVE_BAR.read_text(encoding="utf-8").replace("joints:\n", f"joints:\n  pair: {joints}\n", 1)
    scene = read_scene_text(text, "scene.yaml", {"joints.pair.of.B.angle": "-3", "joints.pair.of.A": "4"})
    pair = next(joint for joint in scene.joints if joint.name == "pair")
    assert list(pair.couples.of.values()) == [4.0, -3.0]


def test_changes_are_what_a_scene_that_says_so_itself_has():
    text = FIVE_BAR.read_text(encoding="utf-8")
    by_hand = read_scene_text(text.replace("bar2: {mass: mass", "bar2: {mass: 3 * mass"))
    assert changed(bodies__bar2__mass="3 * mass").bodies == by_hand.bodies


@pytest.mark.parametrize(
    ("path", "value", "line"),
    [
        ("lenght", "2", "--set lenght: error: unknown parameter 'lenght'; did you mean 'length'?"),
        (
            "parameters.lenght",
            "2",
            "--set parameters.lenght: error: unknown parameter 'lenght'; did you mean 'length'?",
        ),
        ("bodys.bar1.mass", "2", "--set bodys.bar1.mass: error: the scene has no 'bodys'; did you mean 'bodies'?"),
        (
            "bodies.bar9.mass",
            "2",
            "--set bodies.bar9.mass: error: the scene has no 'bodies.bar9'; did you mean 'bar5'?",
        ),
        ("bodies.bar1.mas", "2", "--set bodies.bar1.mas: error: unknown key 'mas'; did you mean 'mass'?"),
        (
            "bodies.bar1.position.3",
            "2",
            "--set bodies.bar1.position.3: error: 'bodies.bar1.position' is a list and has no place '3'; its places "
            "are 0 to 2",
        ),
        (
            "bodies.bar1.mass.x",
            "2",
            "--set bodies.bar1.mass.x: error: 'bodies.bar1.mass' is 'mass' and has no keys; give a path to a value of "
            "the scene",
        ),
        ("bodies.bar1.mass", "2 m", "--set bodies.bar1.mass: error: 'mass' is in kg, this is a length, in m"),
        ("bodies.bar1.mass", "-1", "--set bodies.bar1.mass: error: 'mass' must be at least 0, found -1"),
        ("simulation.stpe", "1", "--set simulation.stpe: error: unknown key 'stpe'; did you mean 'step'?"),
    ],
)
def test_a_path_that_leads_nowhere_says_so(path, value, line):
    with pytest.raises(InputError) as caught:
        read_scene(FIVE_BAR, {path: value})
    assert [problem.line() for problem in caught.value.problems] == [line]


# Settings changed in the text of a scene: every other character stays.

BLOCK = """\
mbproj: 1            # format
simulation:          # how
  duration: 10 s     # long
  step: 0.01 s       # the paper's

  # a remark
  projection:
    method: none     # drifts
    every: 4
bodies: {}
"""
CHOSEN = {"step": None, "tolerance": "1e-8", "integrator": "dop853"}


def test_a_block_keeps_its_comments_and_its_order():
    changes = {**CHOSEN, "projection": {"method": "gpopm", "every": None, "alpha": None}}
    assert with_simulation(BLOCK, changes) == (
        BLOCK.replace("step: 0.01 s ", "tolerance: 1e-8 ")
        .replace("method: none ", "method: gpopm ")
        .replace("    every: 4\n", "  integrator: dop853\n")
    )


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("{duration: 1, step: 0.1}", "{duration: 1, tolerance: 1e-8, integrator: dop853}"),
        ("{duration: 1,  # a\n  step: 0.1}", "{duration: 1,  # a\n  tolerance: 1e-8, integrator: dop853}"),
        ("{step: 0.1, duration: 1, integrator: rk4}", "{tolerance: 1e-8, duration: 1, integrator: dop853}"),
        ("{tolerance: 1e-3}", "{tolerance: 1e-8, integrator: dop853}"),
        ("{}", "{tolerance: 1e-8, integrator: dop853}"),
        ("", "{tolerance: 1e-8, integrator: dop853}"),
    ],
)
def test_a_block_in_braces(before, after):
    text = "mbproj: 1\nsimulation: {}\nbodies: 1\n"
    found = with_simulation(text.replace("simulation: {}", f"simulation: {before}".rstrip()), CHOSEN)
    assert found == text.replace("simulation: {}", f"simulation: {after}")


def test_a_scene_without_the_block_gets_one():
    assert with_simulation("mbproj: 1", {"tolerance": "1e-8"}) == "mbproj: 1\nsimulation: {tolerance: 1e-8}\n"


def test_several_keys_are_removed_from_braces():
    text = "simulation: {step: 0.1, projection: {method: none, every: 4, threshold: 1e-3}}\n"
    changes = {"projection": {"method": "gpopm", "every": None, "threshold": None}}
    assert with_simulation(text, changes) == "simulation: {step: 0.1, projection: {method: gpopm}}\n"


def test_line_ends_stay_those_of_the_file():
    text = BLOCK.replace("\n", "\r\n")
    assert "\n" not in with_simulation(text, CHOSEN).replace("\r\n", "")
