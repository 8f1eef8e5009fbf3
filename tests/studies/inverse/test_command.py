"""`mbproj loads` on the command line: tables in, tables out, and what is refused with its place."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from tests.cli.commands import mbproj

#: A bar that turns about a level axis: m = 2 kg, its centre 0.5 m away, J about the pin 0.3 + 2 · 0.25 kg m².
SCENE = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 1, step: 0.01}
bodies: {bar: {mass: 2, inertia: [0.1, 0.3, 0.3], position: [0.5, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0]}}
markers: {tip: {body: bar, location: {bar: [0.5, 0, 0]}}}
"""
MOTIONS = "motions: {m: {joint: A, angle: 0.5*sin(3*t)}}\n"
T = np.linspace(0.0, 1.0, 41)
ANGLE = 0.5 * np.sin(3.0 * T)
TORQUE = 0.8 * -9.0 * ANGLE + 2.0 * 9.8 * 0.5 * np.cos(ANGLE)


def write(folder, text, name="scene.yaml"):
    (folder / name).write_text(text)
    return name


def table(folder, headings, *columns):
    lines = [headings, *(",".join(f"{value:.17g}" for value in row) for row in zip(*columns, strict=True))]
    return write(folder, "\n".join(lines) + "\n", "given.csv")


def test_a_table_in_degrees_gives_a_table_a_picture_and_numbers(tmp_path):
    given = table(tmp_path, "time (s), A.angle (deg)", T, np.degrees(ANGLE))
    scene = write(tmp_path, SCENE)
    done = mbproj(
        "loads", scene, "--given", given, "-o", "a.csv", "--plot", "a.png", "--over", "A.angle", folder=tmp_path
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "1 degree of freedom, 1 actuator, 41 samples" in done.stdout
    assert "power balance" in done.stdout and "interpolated" in done.stdout
    assert (tmp_path / "a.png").stat().st_size > 10_000
    with (tmp_path / "a.csv").open() as file:
        headings, *rows = csv.reader(file)
    assert headings == ["time (s)", "A.angle force (N m)", "A.angle rate (rad/s)", "A.angle power (W)"]
    found = np.array(rows, dtype=float)
    np.testing.assert_allclose(found[5:-5, 1], TORQUE[5:-5], rtol=0.0, atol=1e-5)
    numbers = json.loads(mbproj("loads", scene, "--given", given, "--json", folder=tmp_path).stdout)
    np.testing.assert_allclose(numbers["actuators"]["A.angle"]["force"], found[:, 1], rtol=1e-12)
    assert numbers["power_balance"] < 1e-12


@pytest.mark.full
def test_a_marker_in_millimetres_and_results_tell_the_same_motion(tmp_path):
    x, z = 1000.0 * np.cos(ANGLE), 1000.0 * np.sin(ANGLE)
    given = table(tmp_path, "t;tip.position_x [mm];tip.z [mm]".replace(";", ","), T, x, z)
    scene = write(tmp_path, SCENE)
    done = mbproj("loads", scene, "--given", given, "--actuator", "A.angle", "--json", folder=tmp_path)
    found = json.loads(done.stdout)["actuators"]["A.angle"]["force"]
    np.testing.assert_allclose(found[8:-8], TORQUE[8:-8], rtol=0.0, atol=1e-3)
    assert mbproj("run", write(tmp_path, SCENE + MOTIONS, "driven.yaml"), folder=tmp_path).returncode == 0
    of_results = json.loads(mbproj("loads", "results.h5", "--json", folder=tmp_path).stdout)
    t = np.array(of_results["time"])
    exact = -7.2 * 0.5 * np.sin(3.0 * t) + 9.8 * np.cos(0.5 * np.sin(3.0 * t))
    np.testing.assert_allclose(of_results["actuators"]["m"]["force"], exact, rtol=0.0, atol=1e-10)
    as_given = mbproj("loads", scene, "--given", "results.h5", "--actuator", "A.angle", "--json", folder=tmp_path)
    np.testing.assert_allclose(json.loads(as_given.stdout)["actuators"]["A.angle"]["force"], exact, atol=2e-4)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time, A.angel\n" + "0,0\n" * 7, "given.csv:1: error: column 'A.angel' is no joint coordinate"),
        ("time, A.angle (mm)\n" + "0,0\n" * 7, "given.csv:1: error: column 'A.angle' is in rad, and 'mm' is not"),
        ("time, A.angle (furlong)\n" + "0,0\n" * 7, "unknown unit 'furlong'"),
        ("A.angle\n" + "0\n" * 7, "it needs a column 'time (s)'"),
        ("time, A.angle\n0,0\n1,x\n", "given.csv:3: error: 'x' is not a number"),
        ("time, A.angle\n0,0\n1,4_5\n", "given.csv:3: error: '4_5' is not a number"),
        ("time, A.angle, A.angle\n" + "0,0,0\n" * 7, "given.csv:1: error: two columns are of 'A.angle'"),
        ("time, A.angle\n0,0\n1\n", "given.csv:3: error: it has 1 cells"),
        ("time, A.angle\n0,0\n1,nan\n", "given.csv:3: error: a number is not finite"),
        ("time, A.angle\n0,0\n1,1\n2,2\n", "it has 3 samples"),
        ("time, A.angle\n" + "".join(f"{t},0\n" for t in (0, 1, 2, 2, 3, 4, 5)), "given.csv:5: error: its time"),
        ("", "it is empty"),
    ],
)
def test_what_is_wrong_with_a_table_is_said_with_its_line(tmp_path, text, said):
    scene, given = write(tmp_path, SCENE), write(tmp_path, text, "given.csv")
    done = mbproj("loads", scene, "--given", given, folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "it is not said which actuators move the mechanism"),
        (("--smooth", "1 mm"), "--smooth is for a motion that is given"),
        (("--actuator", "B.angle"), "--actuator: error: there is no actuator 'B.angle'"),
        (("--actuator", "A.angle", "--weight", "A.angle"), "'A.angle' is not NAME=W"),
        (("--actuator", "A.angle", "--over", "A.angel"), "did you mean 'A.angle'?"),
        (("--actuator", "A.angle", "--plot", "a.gif"), "has no ending of a picture"),
    ],
)
def test_options_that_are_wrong_are_said(tmp_path, options, said):
    done = mbproj("loads", write(tmp_path, SCENE), *options, folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr, done.stderr
