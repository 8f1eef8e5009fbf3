"""info --steps: which bodies make the error of the smaller steps, and which force holds them."""

from __future__ import annotations

import json

import pytest

from tests.cli.commands import mbproj
from tests.integrate.stiff_scenes import CREEP

#: Two masses on springs: one swings with 20 rad/s, one with 1 rad/s.
TWO = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1.0e-8, integrator: dop853, output_step: 0.05}
bodies:
  slow: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  fast: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, slow], location: [0, 0, 0], axis: [1, 0, 0]}
  wire: {type: prismatic, bodies: [ground, fast], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  soft: {type: linear_spring_damper, joint: rail, force: "-(displacement + 0.1)"}
  hard: {type: linear_spring_damper, joint: wire, force: "-400*(displacement + 0.1)"}
"""


def steps_of(folder, text, *options):
    (folder / "scene.yaml").write_text(text)
    done = mbproj("run", "scene.yaml", *options, folder=folder)
    assert done.returncode == 0, done.stderr
    done = mbproj("info", "results.h5", "--steps", "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["steps"]


def test_the_faster_mass_makes_the_error(tmp_path):
    """Its error is 20⁸ times the other's."""
    found = steps_of(tmp_path, TWO)
    for each in found:
        assert each["shares"]["fast"] > 0.999
        assert each["reason"] == ""
    assert 0.01 < max(each["error"] for each in found) <= 1.01
    shown = mbproj("info", "results.h5", "--steps", folder=tmp_path).stdout
    assert "fast 100 %" in shown
    assert "accuracy" in shown


@pytest.mark.full
def test_the_picture_of_the_steps_says_it_too(tmp_path):
    steps_of(tmp_path, TWO)
    done = mbproj("plot", "results.h5", "--kind", "steps", "--format", "svg", folder=tmp_path)
    assert (done.returncode, done.stdout.split()) == (0, ["results-steps.svg"])
    shown = mbproj("info", "results.h5", "--steps", folder=tmp_path).stdout
    assert done.stderr == shown
    assert "steps limited by body 'fast' at " in (tmp_path / "results-steps.svg").read_text(encoding="utf-8")


def test_a_stiff_force_holds_them(tmp_path):
    found = steps_of(tmp_path, CREEP, "--integrator", "dop853", "--duration", "0.3", "--output-step", "0.01")
    held = [each for each in found if each["reason"].startswith("force 'bush': c h / m = ")]
    assert len(held) >= len(found) / 2


def test_fixed_steps_have_no_limit(tmp_path):
    (tmp_path / "scene.yaml").write_text(TWO)
    assert mbproj("run", "scene.yaml", "--step", "0.05", "--duration", "0.5", folder=tmp_path).returncode == 0
    done = mbproj("info", "results.h5", "--steps", folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "its steps are fixed, and nothing limits them; run it with a --tolerance" in done.stderr
    assert mbproj("info", "--steps", folder=tmp_path).returncode == 2
