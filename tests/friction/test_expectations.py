"""What a scene may expect of its dry friction, and what a run then finds."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import compile_system, read_scene_text
from mbproj.analysis.observed import series
from mbproj.results import open_results
from mbproj.scene import OBSERVABLES, friction_units
from tests.cli.commands import mbproj
from tests.friction.scenes import EVERY_FRICTION as MANY
from tests.scene.scenes import errors

#: I ω' = -4 from ω = 3: the disc turns 9/4 rad in 1.5 s, and its energy of 9 J is lost.
SCENE = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1e-10, integrator: dopri5, output_step: 0.25}
bodies: {disc: {mass: 1, inertia: [1, 1, 2], position: [0, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, disc], location: [0, 0, 0], axis: [0, 0, 1], speed: 3}}
forces: {brake: {type: friction, joint: A, coulomb: {torque: 4, static: 5}}}
expect:
  angle: {joint: A, quantity: angle, at: end, value: 9 / 4, absolute: 1e-9, source: I w^2 / 2 T}
  heat: {friction: brake, quantity: dissipation, at: end, value: 9 J, relative: 1e-9, source: kinetic energy}
  slides: {friction: brake, quantity: state, at: 1.25, value: 1, absolute: 1e-9, source: w = 0.5 rad/s}
  holds: {friction: brake, quantity: state, at: 1.75, value: 0, absolute: 1e-9, source: w = 0 from 1.5 s on}
  torque: {friction: brake, quantity: force, at: minimum, value: -4 N*m, absolute: 1e-9, source: statics}
"""


def test_a_run_finds_them_and_tells_them(tmp_path):
    (tmp_path / "brake.yaml").write_text(SCENE, encoding="utf-8")
    done = mbproj("run", "brake.yaml", "-o", "brake.h5", folder=tmp_path)
    assert done.returncode == 0 and "expectations        5 of 5 hold" in done.stdout, done.stdout + done.stderr
    scene = read_scene_text(SCENE)
    with open_results(tmp_path / "brake.h5") as results:
        seen = results.friction("brake")
        assert results.names("frictions") == ("brake",) and results.names("friction_units") == ("rad",)
        aside = np.abs(results.time - 1.5) > 0.1
        np.testing.assert_array_equal(seen.state[aside], np.where(results.time < 1.5, 1, 0)[aside])
        np.testing.assert_allclose(seen.rate, np.maximum(3.0 - 2.0 * results.time, 0.0), atol=1e-9)
        found = {each.quantity: series(each, results) for each in scene.expectations if each.of == "friction"}
        np.testing.assert_array_equal(found["force"][:, 0], seen.force)
        np.testing.assert_array_equal(found["dissipation"][:, 0], seen.dissipation)
        shown = {entry.path.partition("/")[2] for entry in results.datasets if entry.symbol == "nr"}
        assert shown == OBSERVABLES["friction"].keys()
    assert mbproj("export", "brake.h5", "-o", "tables", folder=tmp_path).returncode == 0
    head, *rows = (tmp_path / "tables" / "brake-friction-brake.csv").read_text(encoding="utf-8").splitlines()
    assert head.split(",")[-2:] == ["state (1)", "dissipation (J)"] and len(rows) == 9


def test_frictions_have_the_names_and_units_of_the_arrays():
    scene = read_scene_text(MANY)
    names = compile_system(scene).names
    found = friction_units({joint.name: joint for joint in scene.joints}, {force.name: force for force in scene.forces})
    assert found == dict(zip(names.frictions, names.friction_units, strict=True))


def expecting(given):
    return f"{SCENE[: SCENE.index('expect')]}expect:\n  e: {{{given}, at: end, value: 1, absolute: 1, source: x}}\n"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("friction: break, quantity: force", "8:17: error: unknown dry friction 'break'; did you mean 'brake'?"),
        ("friction: brake, quantity: gap", "8:34: error: a dry friction has no 'gap'; it has: rate, force, state, "
         "dissipation"),
        ("force: brake, quantity: force", "8:14: error: force 'brake' is dry friction; write  friction: NAME  with "
         "rate, force, state or dissipation"),
    ],
)  # fmt: skip
def test_an_expectation_of_no_friction(given, message):
    assert errors(expecting(given)) == [f"f.yaml:{message}"]


def test_an_expectation_is_in_the_unit_of_what_it_is_about():
    """What is regularised is a force as others are; it has no state."""
    smooth = expecting("friction: brake, quantity: force").replace("static: 5", "regularised: 1 rpm")
    assert errors(smooth) == ["f.yaml:8:17: error: unknown dry friction 'brake'; the scene has none that sticks"]
    (found,) = read_scene_text(smooth.replace("friction: brake, q", "force: brake, q")).expectations
    assert (found.of, found.unit) == ("force", "N*m")
    wrong = expecting("friction: brake, quantity: force").replace("value: 1", "value: 1 N")
    assert errors(wrong) == ["f.yaml:8:57: error: 'force' is in N*m, this is a force, in N"]
    (state,) = read_scene_text(expecting("friction: brake, quantity: state")).expectations
    assert state.unit == ""
