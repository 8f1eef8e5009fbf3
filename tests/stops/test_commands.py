"""Commands on scenes with stops."""

from __future__ import annotations

import json

from tests.cli.commands import mbproj

SCENE = """\
mbproj: 1
title: Trolley
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  trolley: {mass: 2 kg, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, trolley], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.2,
    limits: {displacement: {range: [-1, 0.2], rigid: true}}}
forces:
  rope: {type: stop, points: {ground: [-1, 0, 0], trolley: [0, 0, 0]}, longest: 1.5, stiffness: 1e4}
"""


def test_check_says_which_stops_touch_at_the_start(tmp_path):
    path = tmp_path / "trolley.yaml"
    path.write_text(SCENE)
    said = mbproj("check", str(path), folder=tmp_path).stdout.splitlines()
    assert "  3 stops, touching at the start: 'rail.displacement.high'" in said
    found = json.loads(mbproj("check", str(path), "--json", folder=tmp_path).stdout)["stops_at_start"]
    assert {name: (round(entry["gap"], 12), entry["touches"], entry["unit"]) for name, entry in found.items()} == {
        "rail.displacement.low": (1.2, False, "m"),
        "rail.displacement.high": (0.0, True, "m"),
        "rope": (0.3, False, "m"),
    }


def test_check_refuses_a_start_beyond_a_stop(tmp_path):
    path = tmp_path / "trolley.yaml"
    path.write_text(SCENE.replace("displacement: 0.2,", "displacement: 0.9,"))
    done = mbproj("check", str(path), folder=tmp_path)
    assert done.returncode == 2
    assert "trolley.yaml:9:41: error: the start is beyond the stop 'rail.displacement.high' by 0.7 m" in done.stderr
    assert "trolley.yaml:11:81: error: the start is beyond the stop 'rope' by 0.4 m: at 1.9 m" in done.stderr


def test_check_and_run_refuse_a_motion_beyond_a_stop_alike(tmp_path):
    path = tmp_path / "trolley.yaml"
    scene = SCENE.replace("displacement: 0.2,", "displacement: -0.1,")
    path.write_text(f"{scene}motions: {{push: {{joint: rail, displacement: 0.5*sin(t) - 0.1}}}}\n")
    checked, ran = (mbproj(command, str(path), folder=tmp_path) for command in ("check", "run"))
    assert (checked.returncode, ran.returncode) == (2, 2)
    assert checked.stderr == ran.stderr
    assert "trolley.yaml:9:41: error: motion 'push' drives rail.displacement beyond this rigid stop" in ran.stderr
