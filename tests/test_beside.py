"""Other programs run the same mechanism: each comes to the same reference, from one scene."""

from __future__ import annotations

import pytest

from scripts.beside.measure import installed, tried
from scripts.beside.problems import problem_of


def smallest_error(problem, program, below, most=60):
    """Of settings from coarse to fine, until an error is below."""
    error = float("inf")
    for number, trial in enumerate(tried(problem, program)):
        error = min(error, trial.error)
        if error < below or number > most:
            break
    return error


@pytest.mark.parametrize("name", ["five-bar", "slider-crank"])
def test_mujoco_and_mbproj_have_the_motion_of_the_reference(name):
    pytest.importorskip("mujoco")
    problem = problem_of(name)
    programs = installed(problem, ["mbproj", "mujoco"])
    assert [program.name for program in programs] == ["mbproj, RK4", "mbproj, DOPRI5", "mbproj, DOP853", "MuJoCo, RK4"]
    assert max(smallest_error(problem, program, 1e-3) for program in programs) < 1e-3


def test_springs_on_coordinates_are_the_bushing():
    """MuJoCo's frame of the bushing is the near half's, which differs by the square of its deflection."""
    pytest.importorskip("mujoco")
    problem = problem_of("four-bar-1e6")
    (program,) = [each for each in installed(problem, ["mujoco"]) if each.name.endswith("implicitfast")]
    assert smallest_error(problem, program, 1e-4, 300) < 1e-4


def test_dry_friction_of_a_joint_is_that_of_the_scene():
    pytest.importorskip("mujoco")
    problem = problem_of("brake")
    errors = {
        trial.setting.label: trial.error for each in installed(problem, ["mujoco"]) for trial in tried(problem, each)
    }
    assert errors["h = 0.1 ms"] == pytest.approx(5e-4, rel=0.1)
    assert errors["h = 1 ms"] == pytest.approx(5e-3, rel=0.1)


def test_a_name_that_is_no_problem():
    for name in ("six-bar", "chain-", "chain-x"):
        with pytest.raises((KeyError, ValueError)):
            problem_of(name)
