"""`mbproj modes` and `mbproj plot modes.h5`: what they print, write and refuse."""

from __future__ import annotations

import json
from math import pi, sqrt

import pytest

from mbproj.results.linear_files import read_modes
from tests.cli.commands import mbproj
from tests.linear.closed_forms import HEAD, g
from tests.stops.scenes import resting_on_a_stop

SCENE = (
    HEAD
    + """\
parameters: {m: 2, length: 0.5 m}
bodies:
  bar: {mass: m, inertia: [0.1, 0.17, 0.17], position: [0, 0, -length]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
"""
)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    return tmp_path


def frequency(length):
    return sqrt(2 * g * length / (0.17 + 2 * length**2)) / (2 * pi)


def test_json_has_stable_keys(folder):
    done = mbproj("modes", "scene.yaml", "--json", folder=folder)
    found = json.loads(done.stdout)
    assert found["frequencies_hz"] == pytest.approx([frequency(0.5)], rel=1e-12)
    assert (found["damping_ratios"], found["growth_rates"]) == ([0.0], [0.0])
    assert (found["at"], found["degrees_of_freedom"], found["balanced"]) == ("start", 1, True)
    assert found["modes"][0]["kinetic_energy"] == {"bar": 1.0}
    assert (folder / "modes.h5").exists()


UNLOADED = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 1 ms}
bodies: {b: {mass: 4, inertia: [1, 1, 1], position: [0, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, b], location: [0, 0, 0], axis: [1, 0, 0]}}
forces: {spring: {type: linear_spring_damper, joint: rail, stiffness: 100}}
"""


def test_where_no_force_acts_forces_balance(folder):
    (folder / "unloaded.yaml").write_text(UNLOADED)
    found = json.loads(mbproj("modes", "unloaded.yaml", "--json", folder=folder).stdout)
    assert (found["balanced"], found["imbalance"]["relative"]) == (True, 0.0)
    assert found["frequencies_hz"] == pytest.approx([5.0 / (2.0 * pi)], rel=1e-12)
    done = mbproj(
        "linearize", "unloaded.yaml", "--inputs", "spring", "--outputs", "rail.displacement", "--json", folder=folder
    )
    assert json.loads(done.stdout)["balanced"] is True
    found = json.loads(mbproj("equilibrium", "unloaded.yaml", "--json", folder=folder).stdout)
    assert (found["converged"], found["residual"]["relative"]) == (True, 0.0)


SPRING = "forces: {spring: {type: linear_spring_damper, joint: rail, stiffness: 700}}\n"


@pytest.mark.parametrize("at", ["start", "0.1 s"])
def test_modes_and_linear_models_are_those_of_where_a_run_begins(folder, at):
    """40 N press the mass on a stop of 900 N/m, beside a spring of 700 N/m: ω = 20 rad/s."""
    (folder / "rests.yaml").write_text(resting_on_a_stop(4.0, "step: 1 ms", SPRING))
    found = json.loads(mbproj("modes", "rests.yaml", "--at", at, "--json", folder=folder).stdout)
    assert found["frequencies_hz"] == pytest.approx([20.0 / (2.0 * pi)], rel=1e-9)
    assert found["balanced"]
    done = mbproj(
        "linearize",
        "rests.yaml",
        "--at",
        at,
        "--inputs",
        "spring",
        "--outputs",
        "rail.displacement",
        "--json",
        folder=folder,
    )
    assert json.loads(done.stdout)["A"][1][0] == pytest.approx(-400.0, rel=1e-9)


def test_a_trace_over_a_parameter_and_its_pictures(folder, undrawn):
    done = mbproj("modes", "scene.yaml", "--vary", "length=0.5 m:1000 mm:3", "-o", "t.h5", folder=folder)
    assert "3 values of length; the table is of the last, 1" in done.stdout
    traced = read_modes(folder / "t.h5")
    assert traced.varied == ("length",)
    assert traced.trace[:, 0].imag / (2 * pi) == pytest.approx([frequency(x) for x in (0.5, 0.75, 1.0)], rel=1e-12)
    drawn = mbproj("plot", "t.h5", folder=folder)
    assert drawn.stdout.split() == ["t-eigenvalues.png", "t-shapes.png", "t-traces.png"]


def test_a_time_of_a_run_and_of_its_file_give_the_same(folder):
    scene = SCENE.replace("axis: [0, 1, 0]}", "axis: [0, 1, 0], speed: 1 rad/s}")
    (folder / "swing.yaml").write_text(scene)
    assert mbproj("run", "swing.yaml", "-o", "r.h5", folder=folder).returncode == 0
    found = [
        json.loads(mbproj("modes", "swing.yaml", "--at", "0.25 s", "--json", *more, folder=folder).stdout)
        for more in ([], ["--from", "r.h5"])
    ]
    assert found[0]["angular_frequencies"] == pytest.approx(found[1]["angular_frequencies"], rel=1e-9)
    assert not found[0]["balanced"]
    assert "forces do not balance here" in found[0]["notes"][0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--at", "sometime"], "--at: error: unknown place 'sometime'; give start"),
        (["--at", "1 m"], "--at: error: '--at' is in s, this is a length, in m"),
        (["--at", "0.3", "--from", "r.h5"], "--from: error: 'r.h5' has no sample at t = 0.3 s; its nearest is at 0.25"),
        (["--from", "r.h5"], "--from: error: it needs a time; give one of its samples: --at TIME"),
        (["--vary", "length"], "--vary: error: 'length' is not NAME=RANGE"),
        (["--vary", "size=1:2:3"], "--set size: error: unknown parameter 'size'"),
        (["-o", "scene.yaml"], "'scene.yaml' exists and is not an HDF5 file of mbproj, so it is not replaced"),
    ],
)
def test_what_is_wrong_is_said_at_its_place(folder, arguments, said):
    options = ("--duration", "0.25", "--output-step", "0.25")
    assert mbproj("run", "scene.yaml", *options, "-o", "r.h5", folder=folder).returncode == 0
    done = mbproj("modes", "scene.yaml", *arguments, folder=folder)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr


def test_options_for_results_do_not_fit_a_file_of_modes(folder):
    assert mbproj("modes", "scene.yaml", "-q", folder=folder).stdout == ""
    done = mbproj("plot", "modes.h5", "--marker", "tip", folder=folder)
    assert (done.returncode, "--marker is for results of runs, and 'modes.h5' is none" in done.stderr) == (
        2,
        True,
    )
    done = mbproj("plot", "modes.h5", "--kind", "traces", folder=folder)
    assert "--kind traces: no parameter was varied: mbproj modes --vary" in done.stderr


def test_a_file_without_modes_has_nothing_to_draw(folder):
    fixed = SCENE + "  end: {type: revolute, bodies: [ground, bar], location: [1, 0, 0], axis: [0, 1, 0]}\n"
    (folder / "fixed.yaml").write_text(fixed)
    assert mbproj("modes", "fixed.yaml", folder=folder).returncode == 0
    done = mbproj("plot", "modes.h5", folder=folder)
    assert (done.returncode, "'modes.h5' has nothing to draw: the mechanism has no modes" in done.stderr) == (2, True)
