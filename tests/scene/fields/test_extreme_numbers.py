"""Numbers at the ends of the doubles are refused where their products or quotients would be none."""

from __future__ import annotations

import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text
from tests.cli.commands import mbproj
from tests.scene.scenes import GOOD, changed, errors

SCENES = [
    (changed("duration: 10", "duration: 1e-308"), "'duration' is 1e-308: numbers below 1e-50"),
    (changed("step: 0.01\n  integrator", "step: 5e-324\n  integrator"), "'step' is 4.94066e-324: numbers below 1e-50"),
    (changed("mass: 0.12", "mass: 1e300"), "'mass' is 1e+300: numbers beyond 1e+50"),
    (
        changed("    mass: 0.12\n", "    mass: 0.12\n    appearance: {mesh: {file: crank.stl, scale: 1e300}}\n"),
        "'scale' is 1e+300: numbers beyond 1e+50",
    ),
]


@pytest.mark.parametrize(("text", "message"), SCENES)
def test_a_scene(text: str, message: str) -> None:
    (error,) = errors(text)
    assert message in error and "in SI units overflow when" in error


OPTIONS = [
    ("threshold", "--thresholds", "1e305,1e-3", "'--thresholds' is 1e+305: numbers beyond 1e+50"),
    ("stability", "--from", "5e-324", "'--from' is 4.94066e-324: numbers below 1e-50"),
    ("stability", "--to", "1e308", "'--to' is 1e+308: numbers beyond 1e+50"),
]


@pytest.mark.parametrize(("command", "option", "value", "message"), OPTIONS)
def test_an_option(tmp_path, command: str, option: str, value: str, message: str) -> None:
    (tmp_path / "f.yaml").write_text(GOOD, encoding="utf-8")
    done = mbproj(command, "f.yaml", f"{option}={value}", folder=tmp_path)
    assert done.returncode == 2 and message in done.stderr, done.stderr


@pytest.mark.parametrize("command", ["plot", "animate"])
@pytest.mark.parametrize("option", ["--from", "--to"])
def test_times_that_are_no_number(tmp_path, command: str, option: str) -> None:
    done = mbproj(command, "none.h5", f"{option}=nan", folder=tmp_path)
    assert done.returncode == 2 and f"{option}: error: numbers must be finite" in done.stderr, done.stderr


PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.01, step: 1 ms}
bodies: {bob: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, -1], velocity: [0, 0, 3e11]}}
joints: {A: {type: spherical, bodies: [ground, bob], location: [0, 0, 0]}}
"""


def test_round_off_of_huge_velocities_asks_no_joint_for_its_speed() -> None:
    """What the joints leave of them is small beside them, and no joint has asked for a speed."""
    scene = read_scene_text(PENDULUM)
    system = compile_system(scene)
    assert abs(assemble(system, initial_guess(scene, system)).v[2]) < 1.0
