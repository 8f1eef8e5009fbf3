"""A regularised brake never holds: how far it has crept is said, against the closed form."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.cli.commands import mbproj

#: 1 N m on a brake of 2 N m: it creeps with w artanh(1/2) as soon as J w/T have passed.
SCENE = """\
mbproj: 1
gravity: [0, 0, 0]
parameters: {load: 1, speed: 0}
simulation: {duration: 2 s, integrator: radau5, tolerance: 1.0e-9, output_step: 0.05 s}
bodies:
  rotor: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
joints:
  B: {type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0, 0, 1], speed: speed}
forces:
  load: {type: torque, body: rotor, torque: [0, 0, load]}
  brake: {type: friction, joint: B, coulomb: {torque: 2, regularised: 0.01}}
"""


def test_how_far_it_has_crept(tmp_path):
    (tmp_path / "brake.yaml").write_text(SCENE)
    done = mbproj("run", "brake.yaml", "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    said = mbproj("info", "results.h5", folder=tmp_path).stdout
    for found in (json.loads(done.stdout), json.loads(mbproj("info", "results.h5", "--json", folder=tmp_path).stdout)):
        brake = found["creep"]["brake"]
        assert (brake["unit"], brake["width"], found["frictions"]) == ("rad", 0.01, {})
        assert brake["seconds"] == pytest.approx(2.0)
        assert brake["creep"] == pytest.approx(2.0 * 0.01 * np.arctanh(0.5), rel=1e-4)
    assert f"brake  crept by {brake['creep']:.4g} rad in 2 s, slower than its 0.01 rad/s" in said


def test_what_slides_does_not_creep(tmp_path):
    (tmp_path / "brake.yaml").write_text(SCENE.replace("{load: 1, speed: 0}", "{load: 3, speed: 1}"))
    mbproj("run", "brake.yaml", "--quiet", folder=tmp_path)
    assert "brake  never slower than its 0.01 rad/s" in mbproj("info", "results.h5", folder=tmp_path).stdout
