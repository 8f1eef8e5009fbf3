"""check, examples, paper, help: what they print and how they exit."""

from __future__ import annotations

import json

import pytest

from mbproj.base.mechanisms_folder import mechanism, mechanisms, validation_scenes
from mbproj.commands.main import COMMANDS
from tests.cli.commands import FIVE_BAR, SLIDER_CRANK, mbproj

FOUR_BAR = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  left: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
  top: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 1]}
  right: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0.5]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [left, top], location: [0, 0, 1], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [top, right], location: [1, 0, 1], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [right, ground], location: [1, 0, 0], axis: [0, 1, 0]}
"""

STRETCHED = FOUR_BAR
for bar, before, after in (
    ("left", "[0, 0, 0.5]", "[0.5, 0, 0]"),
    ("top", "[0.5, 0, 1]", "[1.5, 0, 0]"),
    ("right", "[1, 0, 0.5]", "[2.5, 0, 0]"),
    ("B", "[0, 0, 1]", "[1, 0, 0]"),
    ("C", "[1, 0, 1]", "[2, 0, 0]"),
    ("D", "location: [1, 0, 0]", "location: [3, 0, 0]"),
):
    STRETCHED = "\n".join(
        line.replace(before, after) if line.startswith(f"  {bar}:") else line for line in STRETCHED.split("\n")
    )


def test_check_says_what_a_scene_is(tmp_path):
    done = mbproj("check", SLIDER_CRANK, folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "    C  universal of rod and slider, free: angle_1, angle_2\n" in done.stdout
    assert "21 coordinates, 20 constraints of rank 20: 1 degrees of freedom\n" in done.stdout
    assert "bodies moved from their guess by up to " in done.stdout
    assert "    A.angle         0 rad, 6 rad/s\n" in done.stdout
    assert "    D.displacement  0 m, 0.24 m/s\n" in done.stdout
    assert done.stdout.endswith("  can run\n")


def test_check_counts_redundant_rows(tmp_path):
    (tmp_path / "four_bar.yaml").write_text(FOUR_BAR)
    done = mbproj("check", "four_bar.yaml", "--json", "--formulation", "reduced", folder=tmp_path)
    assert done.returncode == 0
    facts = json.loads(done.stdout)
    assert (facts["can_run"], facts["rank"], facts["degrees_of_freedom"]) == (True, 20, 1)
    assert len(facts["redundancy"]["sets"]) == 3


def test_run_refuses_what_check_refuses(tmp_path):
    """The four bars in one line, as long together as the ground is."""
    (tmp_path / "four_bar.yaml").write_text(STRETCHED)
    checked = mbproj("check", "four_bar.yaml", folder=tmp_path)
    assert checked.returncode == 4
    assert "four_bar.yaml:11:3: error: the pose is singular: at it rows of joints depend on" in checked.stderr
    for formulation in ("auto", "planar", "reduced", "full"):
        arguments = ["--duration", "1", "--step", "0.01", "--formulation", formulation]
        done = mbproj("run", "four_bar.yaml", *arguments, folder=tmp_path)
        assert (done.returncode, "stretched or folded" in done.stderr) == (2, True)
        assert not (tmp_path / "results.h5").exists()


def test_check_of_a_method_that_cannot_work(tmp_path):
    done = mbproj("check", FIVE_BAR, "--projection", "popm", "--formulation", "full", folder=tmp_path)
    assert done.returncode == 4
    assert "'popm' needs a positive definite mass matrix" in done.stderr


def test_examples_are_listed_and_copied_but_never_over_others(tmp_path):
    listed = mbproj("examples", folder=tmp_path)
    assert listed.returncode == 0
    assert [line.split()[0] for line in listed.stdout.splitlines()] == [path.name for path in mechanisms()]
    copied = mbproj("examples", "--copy", "here", folder=tmp_path)
    assert copied.returncode == 0
    assert (tmp_path / "here" / "five_bar.yaml").read_bytes() == mechanism("five_bar").read_bytes()
    validation = tmp_path / "here" / "validation"
    assert {path.name for path in validation.glob("*")} == {path.name for path in validation_scenes()}
    again = mbproj("examples", "--copy", "here", folder=tmp_path)
    assert again.returncode == 2
    assert "here has already bennett.yaml, bicycle.yaml, bouncing_ball.yaml" in again.stderr


@pytest.mark.parametrize("drawn", [False, pytest.param(True, marks=pytest.mark.full)])
def test_paper_draws_its_eight_figures_and_says_what_is_not_converged(drawn, request, tmp_path):
    if not drawn:
        request.getfixturevalue("undrawn")
    done = mbproj("paper", "--output", "figures", "--duration", "0.1", "--format", "svg", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    names = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert names == [f"paper-fig{number:02d}.svg" for number in (2, 3, 4, 5, 7, 8, 9, 10)]
    assert "RK4 + GPOPM at 0.01 s against DOP853 at 1e-11:\n  converged to 1 mm: the largest error is " in done.stdout
    assert ("GPOPM" in (tmp_path / "figures" / "paper-fig04.svg").read_text()) is drawn


def test_help_names_every_command_and_the_methods(tmp_path):
    text = mbproj("--help", folder=tmp_path).stdout
    for name in COMMANDS:
        assert f"\n  {name} " in text
    assert "gpopm-pinv" in mbproj("run", "--help", folder=tmp_path).stdout


def test_check_says_what_a_run_has_to_be_told(tmp_path):
    body = "bodies: {ball: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n"
    (tmp_path / "ball.yaml").write_text(f"mbproj: 1\ngravity: [0, 0, 0]\n{body}", encoding="utf-8")
    done = mbproj("check", "ball.yaml", folder=tmp_path)
    assert done.stdout.endswith("  can run, given --duration and --step or --tolerance\n")
    assert mbproj("run", "ball.yaml", "--duration", "1", "--step", "0.1", folder=tmp_path).returncode == 0
