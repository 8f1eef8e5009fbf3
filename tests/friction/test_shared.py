"""Loads that contacts share at will are marked: of feet on a floor, brakes on one shaft, joints between brakes."""

from __future__ import annotations

import json

import pytest

from tests.cli.commands import mbproj
from tests.stops.runs import run

BRAKES = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 2 s, integrator: dop853, tolerance: 1e-9, output_step: 0.1}}
bodies: {{wheel: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}}}
joints: {{axle: {{type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0]}}}}
forces:
  pull: {{type: torsion_spring_damper, joint: axle, torque: "2*t"}}
  {brakes}
expect:
  holds: {{friction: first, quantity: force, at: 0.4 s, above: -10, source: statics}}
"""
BRAKE = "{name}: {{type: friction, joint: axle, coulomb: {{torque: {size}}}}}"
TWO = BRAKES.format(brakes="\n  ".join(BRAKE.format(name=name, size=1) for name in ("first", "second")))
ONE = BRAKES.format(brakes=BRAKE.format(name="first", size=2))
#: A rod between two hinged arms, whose hinges are braked: the rod holds one against the other.
LINKED = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.2 s, integrator: dop853, tolerance: 1e-9, output_step: 0.1, formulation: reduced}
bodies:
  left: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 1]}
  right: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0.5]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: spherical, bodies: [left, rod], location: [0, 0, 1]}
  C: {type: universal, bodies: [rod, right], location: [1, 0, 1], axes: [[0, 1, 0], [0, 0, 1]]}
  D: {type: revolute, bodies: [ground, right], location: [1, 0, 0], axis: [0, 1, 0]}
forces:
  push: {type: force, body: left, force: [1, 0, 0]}
  first: {type: friction, joint: A, coulomb: {torque: 3}}
  second: {type: friction, joint: D, coulomb: {torque: 3}}
"""
BOX = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 0.1, integrator: dop853, tolerance: 1e-9, output_step: 0.05}}
bodies: {{box: {{mass: 3, inertia: [0.1, 0.1, 0.1], position: [0.4, 0.3, 0], velocity: {velocity}}}}}
forces:
{feet}
"""
FOOT = (
    "  {name}: {{type: stop, plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}, rigid: true, "
    "restitution: 0, point: {{body: box, location: [{x}, {y}, 0]}}{more}}}"
)
CORNERS = {"a": (0, 0), "b": (0, 1), "c": (1, 0), "d": (1, 1)}


def box(names: str, velocity: str = "[0, 0, 0]", more: str = "") -> str:
    feet = "\n".join(FOOT.format(name=name, x=CORNERS[name][0], y=CORNERS[name][1], more=more) for name in names)
    return BOX.format(feet=feet, velocity=velocity)


def marked(recorded):
    return {(event.name, event.direction) for event in recorded.of("shared")}


def test_two_brakes_on_a_shaft_share_until_they_slip():
    report, recorded = run(TWO)
    shared = recorded.of("shared")
    assert marked(recorded) == {(f"friction '{name}'", way) for name in ("first", "second") for way in (1, -1)}
    assert {event.time for event in shared if event.direction == 1} == {0.0}
    assert all(event.time == pytest.approx(1.0, abs=1e-6) for event in shared if event.direction == -1)
    assert report.shared == "friction 'first', friction 'second', first at t = 0 s"


def test_one_brake_knows_its_load():
    report, recorded = run(ONE)
    assert not marked(recorded) and report.shared == ""


def test_joints_between_brakes_carry_what_these_share():
    """What the rod carries goes by which brake holds the push."""
    _, recorded = run(LINKED)
    friction = {f"friction '{name}'" for name in ("first", "second")}
    assert {name for name, _ in marked(recorded)} == friction | {f"joint '{name}'" for name in "ABCD"}


def test_four_feet_share_and_three_do_not():
    _, recorded = run(box("abcd"))
    assert marked(recorded) == {(f"stop '{name}'", 1) for name in "abcd"}
    _, recorded = run(box("abd").replace("[0.4, 0.3, 0]", "[0.3, 0.6, 0]").replace("location: [1", "location: [1.2"))
    assert not marked(recorded)


def test_feet_that_slide_share_their_friction():
    _, recorded = run(box("abcd", "[1, 0, 0]", ", friction: 0.2"))
    rubs = {f"friction '{name}.{tangent}'" for name in "abcd" for tangent in (1, 2)}
    assert {name for name, _ in marked(recorded)} == rubs | {f"stop '{name}'" for name in "abcd"}


def test_what_tells_these_forces_says_so(tmp_path):
    (tmp_path / "brakes.yaml").write_text(TWO, encoding="utf-8")
    done = mbproj("run", "brakes.yaml", "-o", "brakes.h5", folder=tmp_path)
    assert (
        "note: contacts share a load arbitrarily (friction 'first', friction 'second', first at t = 0 s)" in done.stderr
    )
    assert "not unique, joints or contacts can share it in any proportion" in done.stdout
    told = json.loads(mbproj("info", "brakes.h5", "--json", folder=tmp_path).stdout)
    assert told["shared_at_contacts"] == {"friction 'first'": 0.0, "friction 'second'": 0.0}
    assert mbproj("export", "brakes.h5", "-o", "tables", folder=tmp_path).returncode == 0
    heading = (tmp_path / "tables" / "brakes-friction-first.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "force (N m; not unique)" in heading
