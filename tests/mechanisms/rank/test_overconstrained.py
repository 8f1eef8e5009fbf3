"""Linkages in space that move although their joints have more rows than they need, against their closed forms:
redundant joints change no motion, and the rows that are left out stay closed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene, simulate
from tests.crossed import some
from tests.mechanisms.closed_forms import Linkage, bennett_poses, bennett_ratio, bricard_poses
from tests.mechanisms.running import TIGHT, Run, assert_close, run
from tests.support import ROOT


@pytest.mark.parametrize(("name", "redundant"), [("bennett", 3), ("bricard", 1), ("n_four_bar", 6), ("locomotive", 7)])
def test_the_full_formulation_has_the_same_motion_and_the_same_smallest_reactions(name, redundant):
    """Independent combinations of all rows, against rows that are left out in the kernel."""
    settings = {"integrator": "dop853", "step": "5 ms", "duration": "50 ms", "output_step": "25 ms"}
    full, reduced = (run(name, **settings, formulation=formulation) for formulation in ("full", "reduced"))
    assert full.report.redundant_rows == reduced.report.redundant_rows == redundant
    for path, tolerance in (
        ("bodies/position", 1e-12),
        ("bodies/velocity", 1e-11),
        ("bodies/acceleration", 1e-9),
        ("joints/reaction_force", 1e-8),
        ("joints/reaction_torque", 1e-8),
    ):
        assert_close(full[path], reduced[path], tolerance * max(1.0, np.abs(reduced[path]).max()))
    assert full.report.position_violation.value <= 2e-13


class Blocks(list):
    """Takes the blocks of samples of a run."""

    def write(self, block):
        self.append(block.samples)

    def joined(self, quantity: str) -> np.ndarray:
        return np.concatenate([getattr(samples, quantity) for samples in self])


@pytest.mark.parametrize("name", some(["bricard", "bennett", "stewart_platform", "n_four_bar", "locomotive"], 5))
def test_a_full_run_that_starts_at_a_recorded_state_is_the_long_one(name):
    """To the bit. The kernel's runs: tests/kernel/test_row_policy.py."""
    step, steps, long = 1.0 / 128.0, 40, Blocks()
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    system, rk4 = compile_system(scene), replace(scene.settings, formulation="full", integrator="rk4", tolerance=None)
    settings = replace(rk4, duration=steps * step, step=step, output_step=step)
    simulate(system, assemble(system, initial_guess(scene, system)), settings, long)
    states = [samples.state(k) for samples in long for k in range(len(samples.t))]
    for at in (9, 31):
        again = Blocks()
        simulate(system, states[at], replace(settings, duration=(steps - at) * step), again)
        for quantity in ("q", "v", "acceleration"):
            np.testing.assert_array_equal(again.joined(quantity), long.joined(quantity)[at:])


def test_the_rows_that_are_held_are_changed_before_they_depend_on_each_other():
    """The linkage is as far from singular all round, any 17 of its 20 rows are not: on the constraints they say the
    same, and in the stages of a step that comes near such a pose they do not. Where they were kept until the smallest
    pivot of all was 1e-2 of what it had been, 34 of 154 steps were rejected."""
    settings = {"integrator": "dopri5", "tolerance": "1e-8", "duration": "0.4", "output_step": "0.1"}
    full, reduced = (run("bennett", **settings, formulation=which).report.counters for which in ("full", "reduced"))
    assert reduced["rejected_steps"] <= 5
    assert reduced["projection_failures"] == 0
    assert reduced["evaluations"] < 1.5 * full["evaluations"]


@pytest.fixture(scope="module")
def bennett() -> Run:
    return run("bennett", **TIGHT, duration=1.0, output_step=0.02)


def test_bennetts_relation_between_the_angles(bennett):
    θ1, θ2, θ3, θ4 = bennett_angles(bennett)
    assert np.ptp(θ1) > 2 * np.pi
    assert_close(np.sin(θ1 / 2) * np.sin(θ2 / 2), bennett_ratio(bennett) * np.cos(θ1 / 2) * np.cos(θ2 / 2), 1e-12)
    assert_close(θ3, -θ1, 1e-12)
    assert_close(θ4, -θ2, 1e-12)


def bennett_angles(done: Run) -> list[np.ndarray]:
    """θ1 to θ4, up to full turns: the rocker's joint angle is that of the frame from the rocker, taken backwards."""
    first, second = done.parameters["start"], done.parameters["next"]
    A, B, C, D = (done.column("joints/coordinate", f"{joint}.angle") for joint in "ABCD")
    return [first + A, second + B, C - first, -D - second]


def test_bennetts_linkage_is_where_its_closed_form_and_its_energy_have_it(bennett):
    linkage = Linkage(bennett, lambda u: bennett_poses(bennett, u))
    θ, speed = bennett_angles(bennett)[0], bennett.column("joints/speed", "A.angle")
    linkage.assert_poses(θ, 1e-12)
    linkage.assert_velocities(θ, speed, 1e-11)
    linkage.assert_accelerations(θ, speed, 1e-8)
    linkage.assert_times(θ, bennett.parameters["speed"], 1e-10)
    assert bennett.report.energy_drift_relative < 1e-11


@pytest.fixture(scope="module")
def bricard() -> Run:
    return run("bricard", **TIGHT, duration=1.0, output_step=0.02)


def bricard_coordinate(done: Run) -> tuple[np.ndarray, np.ndarray]:
    """u and u', where x = tan(45° + β/2) = √3 sin u and y = tan(45° + α/2) = √3 cos u / w with w² = 1 + x²: the closed
    curve of (α, β), once round in 2π. u is the inclination of the pins B to the plane that the axis of symmetry is
    normal to."""
    (x, x_rate), (y, y_rate) = (
        (
            np.tan(np.pi / 4 + done.column("joints/coordinate", f"{joint}1.angle") / 2),
            done.column("joints/speed", f"{joint}1.angle") / 2,
        )
        for joint in "BA"
    )
    w = np.sqrt(1 + x * x)
    sine, cosine = x / np.sqrt(3), y * w / np.sqrt(3)
    x_rate, y_rate = (1 + x * x) * x_rate, (1 + y * y) * y_rate
    rate = (cosine * x_rate - sine * (y_rate * w + y * x * x_rate / w)) / np.sqrt(3)
    return np.unwrap(np.arctan2(sine, cosine)), rate


def test_the_invertible_cube_turns_every_second_pin_alike(bricard):
    α, β = (bricard.column("joints/coordinate", f"{joint}1.angle") for joint in "AB")
    assert_close((1 - np.sin(α)) * (1 - np.sin(β)), 1.0, 1e-11)
    for k in "23":
        assert_close(bricard.column("joints/coordinate", f"A{k}.angle"), α, 1e-11)
        assert_close(bricard.column("joints/coordinate", f"B{k}.angle"), β, 1e-11)
    assert np.ptp(bricard_coordinate(bricard)[0]) > 2 * np.pi, "it has not turned inside out and back"


def test_the_invertible_cube_is_where_its_closed_form_and_its_energy_have_it(bricard):
    linkage = Linkage(bricard, lambda u: bricard_poses(bricard, u))
    u, rate = bricard_coordinate(bricard)
    linkage.assert_poses(u, 1e-11)
    linkage.assert_velocities(u, rate, 1e-10)
    linkage.assert_accelerations(u, rate, 1e-7)
    linkage.assert_times(u, rate[0], 1e-10)
    assert bricard.report.energy_drift_relative < 1e-11
