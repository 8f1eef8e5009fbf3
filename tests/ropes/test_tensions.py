"""The tension of each portion of a rope, as a run records it."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import mbproj
from mbproj import InputError, read_scene_text
from mbproj.base.mechanisms_folder import mechanism
from mbproj.commands.main import mbproj as command
from mbproj.results.analysis.contacts import pushed_by_ropes
from mbproj.results.analysis.tables import tables
from mbproj.show.figures import kinds
from tests.kernel.scenes import needs_kernel
from tests.ropes.scenes import ATWOOD, LOAD, UP, G, scene, swinging
from tests.stops.runs import run

pytestmark = needs_kernel
LENGTH = "    length: 2.0 m + 0.1*pi\n"


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_the_tensions_on_both_sides_of_a_wheel(formulation):
    """Against the machine's own equations."""
    _, recorded = run(scene(ATWOOD, formulation, 1))
    *_, first, second = swinging(recorded["time"])
    np.testing.assert_allclose(recorded["ropes/tension"].T, [first, second], atol=1e-9)


def test_a_rope_that_becomes_taut_bears_the_load():
    """Nothing while it is slack."""
    _, recorded = run(scene(LOAD + "    slack: true\n" + LENGTH, duration=0.6))
    (taut, *_) = recorded.of("impact", "touch", "contact")
    expected = np.where(recorded["time"] > taut.time, 2.0 * G, 0.0)
    np.testing.assert_allclose(recorded["ropes/tension"][:, 0], expected, atol=1e-9)


def test_an_elastic_rope_bears_what_its_stiffness_says():
    _, recorded = run(scene(LOAD + "    stiffness: 1000 N/m\n" + LENGTH, duration=0.5))
    longer = recorded["joints/coordinate"][:, 1] - 2.0 - 0.1 * np.pi
    np.testing.assert_allclose(recorded["ropes/tension"][:, 0], 1000.0 * np.maximum(longer, 0.0), atol=1e-9)
    assert longer.max() > 0.05


def test_what_winds_a_rope_pulls():
    motion = "motions:\n  wind: {joint: rope, length: {expression: 1.5 m + 0.1*pi - 0.2*t**2}}\n"
    _, recorded = run(scene(LOAD + motion, duration=0.2))
    np.testing.assert_allclose(recorded["ropes/tension"][:, 0], 2.0 * (G + 0.4), rtol=1e-12)


def test_a_file_its_tables_and_its_picture_have_them(tmp_path):
    path = tmp_path / "results.h5"
    results = mbproj.run(mechanism("swinging_atwood"), duration=0.1, output=path)
    with h5py.File(path) as file:
        assert [name.decode() for name in file["ropes/names"]] == ["rope.tension_1", "rope.tension_2"]
        stored = file["ropes/tension"][:]
    with mbproj.open_results(path) as found:
        (table,) = [table for table in tables(found) if table.name == "joint-rope"]
        own = [table.headings.index(f"tension_{number} (N)") for number in (1, 2)]
        np.testing.assert_array_equal(table.read()[:, own], stored)
        figure = kinds.draw("ropes", [found], ["run"])
    labels = [axis.get_ylabel() for axis in figure.axes]
    assert any("tension" in label for label in labels) and any("rope: length" in label for label in labels)
    assert stored.shape == (len(results.time), 2)


def test_a_free_rope_has_none():
    _, recorded = run(scene(LOAD + "    free: true\n", duration=0.02))
    assert "ropes/tension" not in recorded.blocks[0]


@pytest.mark.parametrize(("item", "quantity"), [("rope", "tension_2"), ("guide", "tension_1")])
def test_what_has_no_such_tension_says_so(item, quantity):
    pull = f"{{joint: {item}, quantity: {quantity}, at: end, value: 1 N, relative: 1, source: none}}"
    with pytest.raises(InputError, match=f"has no '{quantity}'"):
        read_scene_text(scene(LOAD + f"expect:\n  pull: {pull}\n"))


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_a_driven_rope_turns_its_wheel(formulation):
    """J φ'' = r (T2 - T1). A rope that is drawn in at its end lifts the load by s(t)."""
    text = """
bodies:
  load: {mass: 3, inertia: [1, 1, 1], position: [-0.1, 0, -2]}
  wheel: {mass: 2, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0]}
joints:
  guide: {type: prismatic, bodies: [ground, load], location: [-0.1, 0, -2], axis: z}
  axle: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: y}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: load, at: [-0.1, 0, -2]}
      - {wheel: wheel, radius: 0.1, bends: right}
      - {point: ground, at: [0.1, 0, -1]}
motions:
  draws: {joint: rope, length: {expression: 3 m + 0.1*pi - 0.4*t**2}}
"""
    parts = scene(text, formulation, 0.1 if formulation == "full" else 1)
    _, found = run(
        parts.replace("simulation: {", "simulation: {kinematic: false, ") if formulation == "full" else parts
    )
    t = found["time"]
    np.testing.assert_allclose(found["bodies/position"][:, 0, 2], -2.0 + 0.4 * t**2, atol=1e-12)
    np.testing.assert_allclose(np.abs(found["joints/coordinate"][:, 1]), 4.0 * t**2, atol=1e-11)
    first, second = found["ropes/tension"].T
    np.testing.assert_allclose(first, 3.0 * (G + 0.8), rtol=1e-10)
    np.testing.assert_allclose(second - first, 0.02 * 8.0 / 0.1, rtol=1e-9)
    np.testing.assert_allclose(np.abs(found["motions/force"][:, 0]), second, rtol=1e-12)


def test_a_rope_that_pushes_is_told(tmp_path):
    """A weight of 2 kg that is lifted with 30 N: at π/20 s the rope pushes with what that is more."""
    (tmp_path / "push.yaml").write_text(scene(LOAD + UP, duration=0.3).replace("20 ms", "0.5 ms"))
    done = CliRunner().invoke(command, ["run", str(tmp_path / "push.yaml"), "-o", str(tmp_path / "push.h5"), "--json"])
    pushed = json.loads(done.stdout)["ropes_that_push"]["rope"]
    assert pushed["push"] == pytest.approx(30.0 - 2.0 * G, rel=1e-6)
    assert pushed["time"] == pytest.approx(np.pi / 20.0, abs=5e-4)
    assert "note: rope 'rope' pushes with up to 10.38 N" in done.stderr


def test_a_rope_that_pulls_is_not():
    parsed = read_scene_text(scene(ATWOOD, duration=0.2))
    assert pushed_by_ropes(mbproj.run(parsed), parsed) == {}
