"""Ropes and telescopes in `mbproj export --mjcf` are tendons; read again, a scene accelerates as before."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import run
from mbproj.formats.export.mjcf import as_mjcf
from mbproj.scene.scene import read_scene_text
from tests.formats.round_trip import accelerations, again, difference

pytest.importorskip("mujoco")
#: Two links that turn in the plane of a rope, which runs over a sheave of the ground and one of the first link.
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.1 s, tolerance: 1.0e-9, output_step: 10 ms, integrator: dopri5}
bodies:
  a: {mass: 1, inertia: [1, 2, 2.5], position: [0, 0, -0.3], orientation: {axis: [0, 1, 0], angle: 0.2}}
  b: {mass: 2, inertia: [1, 1, 1], position: [0.3, 0, -0.7]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0], speed: 0.5}
  B: {type: revolute, bodies: [a, b], location: [0, 0, -0.6], axis: [0, 1, 0]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: ground, at: [-1, 0.2, 0.1]}
      - {sheave: ground, at: [0, 0.2, 0.3], radius: 0.1, bends: right}
      - {point: a, at: [0.6, 0.2, 0]}
      - {sheave: a, at: [0.3, 0.2, -0.4], radius: 0.08, bends: left}
      - {point: b, at: [0.2, 0.2, -0.8]}
"""
TELESCOPE = "  rope: {type: telescope, bodies: [ground, b], locations: [[-1, 0, 0.3], [0.4, 0.1, -0.7]], KEYS}\n"


def over_points(text):
    return "\n".join(line for line in text.splitlines() if "sheave" not in line) + "\n"


FORCE = "forces:\n  f: {type: linear_spring_damper, joint: rope, coordinate: length, "
ALIKE = {
    "taut": ("", ""),
    "given its length": ("    length: LENGTH m\n", ""),
    "with a spring": ("    free: true\n", FORCE + "stiffness: 30, free_displacement: 1.5, damping: 2}\n"),
}


@pytest.mark.parametrize("name", ALIKE)
@pytest.mark.parametrize("change", [str, over_points], ids=["sheaves", "points"])
def test_a_rope_accelerates_bodies_as_before(name, change, tmp_path):
    own, more = ALIKE[name]
    text = change(SCENE) + own.replace("LENGTH", "2.6") + more
    scene = read_scene_text(text)
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert ("<geom" in written.text) is (change is str)
    back = again(written, tmp_path, "xml")
    assert difference(accelerations(scene), accelerations(back)) < 1e-12
    without = read_scene_text(text.partition("  rope:")[0])
    assert difference(accelerations(scene), accelerations(without)) > 1e-3


@pytest.mark.parametrize(
    "own", ["slack: true", "stiffness: 1 kN/m", "limits: {length: {range: [2 m, LENGTH], rigid: true}}"]
)
def test_a_rope_that_may_be_slack_moves_as_before(own, tmp_path):
    """It is a little longer than its path at the start, and taut before the end."""
    taut = read_scene_text(SCENE)
    start = run(taut, duration=0.01).coordinate("rope.length").value[0] + 1e-4
    own = f"    {own}\n".replace("LENGTH", f"{start} m") + (f"    length: {start} m\n" if "limits" not in own else "")
    scene = read_scene_text(SCENE + own)
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    one, other = (run(each, duration=0.1) for each in (scene, again(written, tmp_path, "xml")))
    for body in ("a", "b"):
        np.testing.assert_allclose(other.body(body).position[-1], one.body(body).position[-1], atol=1e-7)
    assert one.coordinate("rope.length").value.max() > start - 1e-9


def test_what_acts_along_a_telescope_acts_along_a_tendon(tmp_path):
    keys = "reflected_inertia: 0.4"
    text = SCENE.partition("  rope:")[0] + TELESCOPE.replace("KEYS", keys)
    scene = read_scene_text(text + FORCE + "stiffness: 30, free_displacement: 1.5, damping: 2}\n")
    written = as_mjcf(scene, "1")
    assert not [row for row in written.said if row.same.value == "no"]
    assert difference(accelerations(scene), accelerations(again(written, tmp_path, "xml"))) < 1e-12


OTHERWISE = {
    "no tendon turns the wheel that it runs over": ("sheave: a", "wheel: a"),
    "no tendon rubs on what it runs over": ("at: [0, 0.2, 0.3]", "at: [0, 0.2, 0.3], friction: 0.2"),
    "no tendon has whole turns around a shape": ("radius: 0.08, bends: left", "radius: 0.08, bends: left, turns: 1"),
    "a tendon has a point between two shapes": (
        "{point: a, at: [0.6, 0.2, 0]}",
        "{sheave: a, at: [0.6, 0.2, 0], radius: 0.05, bends: right}",
    ),
    "it leans at its place 2, and a tendon runs along a helix there": ("at: [-1, 0.2, 0.1]", "at: [-1, 0.21, 0.1]"),
    "what it touches at its place 4 moves out of its plane": (
        "B: {type: revolute, bodies: [a, b]",
        "B: {type: spherical, bodies: [a, b]",
    ),
}


@pytest.mark.parametrize("why", OTHERWISE)
def test_what_no_tendon_says_is_said(why):
    old, new = OTHERWISE[why]
    text = SCENE.replace(old, new)
    if "wheel" in new:
        text = text.replace(", speed: 0.5", "")
    if "spherical" in new:
        text = text.replace("location: [0, 0, -0.6], axis: [0, 1, 0]", "location: [0, 0, -0.6]")
    (row,) = [each for each in as_mjcf(read_scene_text(text), "1").said if each.same.value == "no"]
    assert (row.element, row.what) == ("joint 'rope'", f"left out: {why}")
