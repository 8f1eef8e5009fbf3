"""Scenes with forces and motions on the command line: summaries, results, and what fails."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from mbproj.results.reader import open_results
from tests.cli.commands import mbproj, succeeds

SCENE = """\
mbproj: 1
title: Driven crank
gravity: [0, 0, -9.8]
simulation: {duration: 0.5, step: 0.01}
bodies:
  bar: {mass: 2, inertia: [0.1, 0.3, 0.3], position: [0.5, 0, 0]}
joints:
  A: {type: cylindrical, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0]}
forces:
  k: {type: linear_spring_damper, joint: A, stiffness: 100}
  f: {type: friction, joint: A, coefficient: {angle: 0.2, displacement: 3}}
motions:
  m: {joint: A, angle: MOTION}
"""


def write(folder, motion="0.5*sin(3*t)", text=SCENE):
    (folder / "scene.yaml").write_text(text.replace("MOTION", motion))
    return "scene.yaml"


def test_run_and_what_the_results_say(tmp_path, undrawn):
    done = mbproj("run", write(tmp_path), "--json", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    numbers = json.loads(done.stdout)
    assert (numbers["degrees_of_freedom"], numbers["status"]) == (1, "complete")
    assert numbers["energy_drift"] < 1e-5
    with open_results(tmp_path / "results.h5") as results:
        t = results.time
        assert results.names("forces") == ("k", "f.angle", "f.displacement")
        assert (results.names("force_units"), results.names("motion_units")) == (("m", "rad", "m"), ("rad",))
        angle, speed, bend = 0.5 * np.sin(3 * t), 1.5 * np.cos(3 * t), -4.5 * np.sin(3 * t)
        np.testing.assert_allclose(results.motion("m").value, angle, atol=1e-14)
        np.testing.assert_allclose(results.force("f.angle").force, -0.2 * speed, atol=1e-12)
        exact = 0.8 * bend + 9.8 * np.cos(angle) + 0.2 * speed
        np.testing.assert_allclose(results.motion("m").force, exact, atol=1e-11)
        balance = results["diagnostics/total_energy"] - results["diagnostics/work"] + results["diagnostics/dissipation"]
        np.testing.assert_allclose(results["diagnostics/energy_balance"], balance - balance[0], atol=1e-12)
    exported = mbproj("export", "results.h5", "--table", "motion-m", "--table", "force-f.angle", folder=tmp_path)
    assert exported.stdout.split() == ["results-motion-m.csv", "results-force-f.angle.csv"]
    with (tmp_path / "results-motion-m.csv").open() as file:
        assert next(csv.reader(file)) == ["time (s)", "value (rad)", "rate (rad/s)", "force (N m)"]
    plotted = mbproj("plot", "results.h5", "--kind", "forces", "--kind", "motions", folder=tmp_path)
    assert plotted.stdout.split() == ["results-forces.png", "results-motions.png"]
    succeeds("rerun", "results.h5", "-o", "again.h5", "--quiet", folder=tmp_path)
    with open_results(tmp_path / "results.h5") as one, open_results(tmp_path / "again.h5") as other:
        for path in ("motions/force", "forces/force", "diagnostics/work", "bodies/position"):
            np.testing.assert_array_equal(one[path], other[path])


def test_an_expression_that_fails_during_the_run(tmp_path):
    done = mbproj("run", write(tmp_path, "0.5*log(1 + 3*(0.1 - t))"), folder=tmp_path)
    assert done.returncode == 3
    assert done.stderr.splitlines()[0] == "note: what was computed until then is in results.h5"
    said = done.stderr.splitlines()[1]
    assert said.startswith("error: stopped at t = 0.43")
    assert "at motion 'm': '0.5*log(1 + 3*(0.1 - t))' fails: log(" in said
    with open_results(tmp_path / "results.h5") as results:
        assert results.status.startswith("failed: stopped at t = 0.43")
        assert results.time[-1] == pytest.approx(0.43)


def test_an_expression_that_fails_at_the_start(tmp_path):
    for command in ("run", "check"):
        done = mbproj(command, write(tmp_path, "sqrt(t)"), folder=tmp_path)
        assert done.returncode == 3
        assert done.stderr == (
            "error: stopped at t = 0 s at motion 'm': 'sqrt(t)' fails: sqrt(0) has a derivative that is not finite; "
            "correct the expression, or end the run before that time\n"
        )
    assert not (tmp_path / "results.h5").exists()


@pytest.mark.parametrize("formulation", ["auto", "full"])
def test_a_force_that_fails_at_the_start_is_named(formulation, tmp_path):
    """Before the first sample there is nothing that a stiff force can have spoilt."""
    force = '  push: {type: torsion_spring_damper, joint: A, torque: "exp(1000 - t)"}\n'
    scene = write(tmp_path, text=SCENE[: SCENE.index("motions:")] + force)
    done = mbproj("run", scene, "--formulation", formulation, folder=tmp_path)
    assert (done.returncode, "at force 'push': 'exp(1000 - t)' fails: exp(1000) is not finite" in done.stderr) == (
        3,
        True,
    )


def test_a_contradiction_is_bad_input(tmp_path):
    text = SCENE.replace("axis: [0, -1, 0]}", "axis: [0, -1, 0], angle: 30 deg}")
    done = mbproj("run", write(tmp_path, text=text), folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr == (
        "scene.yaml:13:24: error: motion 'm' begins with A.angle at 0 rad, and the joint's own condition asks for "
        "0.523599; take the joint's condition out\n      m: {joint: A, angle: 0.5*sin(3*t)}\n" + " " * 27 + "^\n"
    )


def test_check_counts_the_motions(tmp_path):
    done = mbproj("check", write(tmp_path), "--json", folder=tmp_path)
    facts = json.loads(done.stdout)
    assert (facts["constraints"], facts["degrees_of_freedom"], facts["can_run"]) == (6, 1, True)
    assert facts["coordinates_at_start"]["A.angle"]["speed"] == pytest.approx(1.5)
    twice = SCENE.replace("motions:\n", "motions:\n  n: {joint: A, angle: 1}\n")
    again = mbproj("check", write(tmp_path, text=twice), "--json", folder=tmp_path)
    assert (again.returncode, "motion 'n' drives the angle of joint 'A' already" in again.stderr) == (2, True)


@pytest.mark.full
def test_a_reflected_inertia_is_checked_recorded_and_repeated(tmp_path):
    text = SCENE.replace("axis: [0, -1, 0]}", "axis: [0, -1, 0], reflected_inertia: {displacement: 3 kg}}")
    scene = write(tmp_path, text=text)
    checked = mbproj("check", scene, folder=tmp_path)
    assert "A  cylindrical of ground and bar, free: angle, displacement (reflected inertia 3 kg)" in checked.stdout
    done = mbproj("run", scene, "--json", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    with open_results(tmp_path / "results.h5") as results:
        assert results.names("forces") == ("k", "f.angle", "f.displacement", "A.displacement.inertia")
        assert results.names("force_units") == ("m", "rad", "m", "m")
        found = results.force("A.displacement.inertia")
        np.testing.assert_allclose(found.force, -3 * results.body("bar").acceleration @ [0, -1, 0], atol=1e-12)
        before = results["bodies/position"].tobytes()
    exported = mbproj("export", "results.h5", "--table", "force-A.displacement.inertia", folder=tmp_path)
    assert exported.stdout.split() == ["results-force-A.displacement.inertia.csv"]
    succeeds("rerun", "results.h5", "-o", "again.h5", "--quiet", folder=tmp_path)
    with open_results(tmp_path / "again.h5") as results:
        assert results["bodies/position"].tobytes() == before
