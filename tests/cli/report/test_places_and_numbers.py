"""Messages of a run stand where the fault is, and its summary shows no numbers that mean nothing."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.commands.run import command
from mbproj.motion.report import EnergyWatch
from mbproj.results.analysis.summary import energy_drift
from mbproj.studies.batch import Task, run_task
from tests.cli.commands import mbproj

HEAD = "mbproj: 1\ngravity: [1, 2, -9.81]\nsimulation: {duration: 1, step: 1 ms, formulation: auto}\nbodies:\n"
BAR = "  bar: {mass: 1, inertia: [0.01, 0.1, 0.1], position: [0.5, 0.1, 0.07]}\n"
HEAVY_POINT = "  lump: {mass: 1, inertia: [0, 0, 0], position: [0, 0, 0]}\n"
PIN = "  p: {type: revolute, bodies: [ground, bar], location: [0, 0, 0.1], axis: [0.1, 1, 0.3]}\n"
STRUCTURE = f"""{HEAD}{BAR}  strut: {{mass: 1, inertia: [0.01, 0.1, 0.1], position: [1, 0.3, 0.5]}}
joints:
{PIN}  q: {{type: spherical, bodies: [bar, strut], location: [1, 0.2, 0]}}
  r: {{type: universal, bodies: [ground, strut], location: [1, 0.7, 1], axes: [[1, 0, 0.3], [0, 1, 0.1]]}}
"""
ONE_BAR = f"{HEAD}{BAR}joints:\n{PIN}"


def run(folder: Path, text: str, *options: str) -> tuple[int, str, str]:
    (folder / "s.yaml").write_text(text)
    done = mbproj("run", "s.yaml", *options, folder=folder)
    return done.returncode, done.stdout, done.stderr


LUMPS = {
    "free": HEAD + HEAVY_POINT,
    "on a ball": f"{HEAD}{HEAVY_POINT}joints:\n  b: {{type: spherical, bodies: [ground, lump], location: [0, 0, 0]}}",
}


@pytest.mark.parametrize("case", LUMPS)
def test_a_body_without_inertia_is_reported_at_the_body(case, tmp_path):
    code, out, error = run(tmp_path, LUMPS[case])
    assert (code, out) == (2, "")
    assert error.startswith("s.yaml:5:3: error: the joints leave 3 motions that move no mass (Eq. 20 does not hold)")
    checked = mbproj("check", "s.yaml", folder=tmp_path)
    assert (checked.returncode, checked.stderr) == (4, error)


def test_a_formulation_that_is_not_available_is_reported_where_it_is_asked_for(tmp_path):
    code, _, error = run(tmp_path, LUMPS["free"].replace("[0, 0, 0]", "[1, 1, 1]", 1).replace("auto", "planar"))
    assert (code, error.splitlines()[0]) == (
        2,
        "s.yaml:3:52: error: the scene is not planar: nothing but symmetry can keep the bodies in a plane: no joint "
        "has an axis",
    )
    message = (
        "the reduced formulation is not available here: the projection 'mmopm' exists in the full formulation only"
    )
    options = ("--formulation", "reduced", "--projection", "mmopm")
    assert run(tmp_path, ONE_BAR, *options)[2] == f"--formulation: error: {message}\n"


def test_a_file_that_cannot_be_written_is_reported_at_the_option(tmp_path, monkeypatch):
    def refuse(descriptor: int, size: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("mbproj.results.crash_safety.reserve", refuse)
    (tmp_path / "s.yaml").write_text(ONE_BAR)
    with pytest.raises(InputError) as raised:
        command.main([str(tmp_path / "s.yaml"), "-o", "out.h5"], standalone_mode=False)
    cannot = "error: cannot write '{}': No space left on device; choose another file with -o"
    assert str(raised.value) == f"--output: {cannot.format('out.h5')}"
    found = run_task(Task(tmp_path / "s.yaml", tmp_path / "out.h5", keep=False))
    assert found.message == cannot.format(tmp_path / "out.h5")


@pytest.mark.parametrize("options", [("--projection", "none"), ("--integrator", "dop853", "--tolerance", "1e-8")])
def test_a_structure_has_neither_an_energy_drift_nor_velocities(options, tmp_path):
    code, out, error = run(tmp_path, STRUCTURE, *options)
    assert (code, error) == (0, "")
    assert "(0.0e+00 of the largest kinetic energy + |ΔV|)" in out
    (velocities,) = (line for line in out.splitlines() if line.startswith("  velocity violation"))
    assert velocities.endswith("; nothing moves")
    assert "relative 0\n" in mbproj("info", "results.h5", folder=tmp_path).stdout


def test_a_violation_of_zero_has_no_place(tmp_path):
    text = ONE_BAR.replace("[1, 2, -9.81]", "[0, 0, 0]").replace("[0.1, 1, 0.3]", "[0, 1, 0]")
    lines = run(tmp_path, text, "--duration", "0.01")[1].splitlines()
    assert "  position violation  0; round-off allows 2e-16" in lines
    assert "  velocity violation  0; nothing moves" in lines


def test_what_turns_moves_however_short_the_run(tmp_path):
    turning = ONE_BAR.replace("axis: [0.1, 1, 0.3]}", "axis: [0.1, 1, 0.3], speed: 1}")
    _, out, _ = run(tmp_path, turning, "--duration", "1e-18", "--step", "1e-18")
    (velocities,) = (line for line in out.splitlines() if line.startswith("  velocity violation"))
    assert "round-off allows" in velocities and "nothing moves" not in velocities


SQUEEZED = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.5, tolerance: 1e-9, integrator: dop853}
bodies:
  jaw: {mass: 0.2, inertia: [1e-4, 1e-4, 1e-4], position: [-0.025, 0, 0]}
  part: {mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [0, 0, 0]}
joints:
  guide: {type: prismatic, bodies: [ground, jaw], location: [-0.025, 0, 0], axis: [1, 0, 0]}
forces:
  spring: {type: linear_spring_damper, joint: guide, force: 40}
"""
POINT = """
  {name}:
    type: stop
    plane: {{body: {body}, location: [{x}, 0, 0], normal: [{normal}, 0, 0]}}
    point: {{body: part, location: [{x}, 0, {z}]}}
    rigid: true
    friction: 0.3
"""


def test_where_nothing_moves_the_energy_says_nothing(tmp_path):
    """A part that four rough points hold: the round-off of 40 N is not a drift."""
    points = [
        POINT.format(name=f"{body}{z}", body=body, x=x, normal=-50 * x, z=0.001 * z)
        for body, x in (("jaw", -0.02), ("ground", 0.02))
        for z in (8, -8)
    ]
    code, out, error = run(tmp_path, SQUEEZED + "".join(points).replace("-8:", "m8:"))
    assert code == 0 and "nothing moves" in out
    assert "the energy drifted" not in error


def test_what_moves_without_joints_moves(tmp_path):
    text = ONE_BAR[: ONE_BAR.index("joints:")]
    _, out, _ = run(tmp_path, text)
    assert "nothing moves" not in out


def test_shares_of_the_time_are_shown_where_enough_steps_were_timed(tmp_path):
    for duration, shown in (("0.6", False), ("0.7", True)):
        _, out, _ = run(tmp_path, ONE_BAR, "--duration", duration)
        assert any(line.startswith("  time  ") for line in out.splitlines()) == shown


def test_a_real_drift_is_shown_however_small_the_motion():
    watch = EnergyWatch(scale=20.0)
    watch.take(balance=1e-6, kinetic=1e-4, lowest=-10.0, highest=-10.0)
    assert watch.relative == pytest.approx(1e-2)
    still = EnergyWatch(scale=20.0)
    still.take(balance=3e-13, kinetic=1e-26, lowest=-10.0, highest=-10.0)
    assert still.relative == 0.0
    locked = EnergyWatch(moves=False)
    locked.take(balance=1e-30, kinetic=1e-30, lowest=0.0, highest=0.0)
    assert locked.relative == 0.0


def test_the_drift_of_results_is_that_of_the_run():
    time = np.linspace(0.0, 1.0, 5)
    drift = energy_drift(1e-6 * time, 1e-4 * time, np.full(5, -10.0))
    assert drift.relative == pytest.approx(1e-2)
    assert energy_drift(3e-13 * time, 1e-26 * time, np.full(5, -10.0)).relative == 0.0
