"""The `expect` block: what is read from it, and which times are sampled."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.observables import OBSERVABLES
from mbproj.scene.records import Expectation, Settings
from mbproj.scene.sampling import nearest_samples, output_times
from tests.scene.scenes import GOOD, changed, errors, read


def expectation(text: str, blocks: str = "", **given: object) -> Expectation:
    (found,) = read(f"{GOOD}{blocks}expect:\n  e: {text}\n", **given).expectations
    return found


def test_a_value_with_units_and_parameters() -> None:
    found = expectation(
        "{marker: tip, quantity: position, at: 3000 ms, value: [2 * crank_length, 1 mm, 0], absolute: 1 mm, source: me}"
    )
    assert found == Expectation(
        "e", "marker", "tip", "position", "m", "", 3.0, "me", value=(0.16, 0.001, 0.0), tolerance=0.001
    )


def test_a_relative_tolerance_is_that_of_the_largest_component() -> None:
    found = expectation("{body: rod, quantity: velocity, at: end, value: [3, -4, 0], relative: 1e-3, source: me}")
    assert found.tolerance == pytest.approx(0.004, rel=1e-15)


def test_a_bound_of_a_diagnostic() -> None:
    found = expectation("{diagnostic: kinetic_energy, at: maximum, below: 3 J, source: me}")
    assert (found.of, found.quantity, found.unit, found.below, found.value) == (
        "diagnostic",
        "kinetic_energy",
        "J",
        3.0,
        None,
    )


SPRING = "forces:\n  k: {type: spring_damper, points: {ground: [0, 0, 0], rod: [0, 0, 1]}, stiffness: 1}\n"
TORSION = "forces:\n  k: {type: torsion_spring_damper, joint: A, stiffness: 1}\n"
FRICTION = "forces:\n  k: {type: friction, joint: D, coefficient: 1}\n"
MOTION = "motions:\n  k: {joint: D, displacement: t}\n"


@pytest.mark.parametrize(
    ("blocks", "of", "units"),
    [
        (SPRING, "force", ("m", "N")),
        (TORSION, "force", ("rad", "N*m")),
        (FRICTION, "force", ("m", "N")),
        (MOTION, "motion", ("m", "N")),
    ],
    ids=["spring", "torsion", "friction", "motion"],
)
def test_units_follow_what_a_force_acts_along(blocks: str, of: str, units: tuple[str, str]) -> None:
    coordinate = "coordinate" if of == "force" else "value"
    for quantity, unit in zip((coordinate, "force"), units, strict=True):
        found = expectation(f"{{{of}: k, quantity: {quantity}, at: end, below: 1 {unit}, source: x}}", blocks)
        assert (found.unit, found.below) == (unit, 1.0)


def test_a_point_force_needs_no_joints() -> None:
    joints = GOOD[GOOD.index("joints:") : GOOD.index("markers:")]
    text = changed(joints, SPRING)
    assert read(f"{text}expect:\n  e: {{force: k, quantity: rate, at: end, below: 1, source: x}}").expectations
    wrong = f"{text}expect:\n  e: {{force: k, quantity: rates, at: end, below: 1, source: x}}"
    assert "unknown quantity 'rates'; did you mean 'rate'?" in errors(wrong)[0]


LATE = "{joint: A, quantity: angle, at: 3 s, value: 0, absolute: 1, source: x}"


def test_the_command_line_may_cut_the_run_short_or_sample_it_otherwise() -> None:
    for options in ({"duration": "1"}, {"output_step": "0.07"}, {"step": "0.004", "output_step": "0.004"}):
        assert expectation(LATE, simulation=options).at == 3.0


def test_a_scene_that_leaves_its_duration_open_may_expect_at_any_time() -> None:
    (found,) = read(changed("  duration: 10\n", "") + f"expect:\n  e: {LATE}\n").expectations
    assert found.at == 3.0


def test_fixed_without_reaction_has_nothing_to_expect() -> None:
    text = changed("{type: spherical, bodies: [crank, rod]", "{type: fixed, bodies: [crank, rod]")
    wrong = f"{text}expect:\n  e: {{joint: B, quantity: reaction_force, component: x, at: end, below: 1, source: x}}\n"
    assert errors(wrong) == [
        "f.yaml:31:14: error: joint 'B' merges its bodies, and nothing of it is recorded; give it reaction: true"
    ]


@pytest.mark.parametrize(
    ("settings", "time", "near"),
    [
        (Settings(duration=10, step=0.01), 0.07, ()),
        (Settings(duration=10, step=0.01, output_step=0.05), 0.07, (0.05, 0.1)),
        (Settings(duration=1, step=0.3), 1.0, ()),  # a shorter last step
        (Settings(duration=1, step=0.3), 0.95, (0.9, 1.0)),
        (Settings(duration=1, step=0.3, output_step=0.6), 0.9, (0.6, 1.0)),
        (Settings(duration=2, tolerance=1e-6), 0.002, ()),
        (Settings(duration=2, tolerance=1e-6), 0.003, (0.002, 0.004)),
        (Settings(duration=1, tolerance=1e-6, output_step=0.4), 0.8, ()),
        (Settings(step=0.1), 0.55, None),
        (Settings(duration=1), 0.55, None),
    ],
)
def test_nearest_samples(settings: Settings, time: float, near: tuple[float, ...] | None) -> None:
    found = nearest_samples(settings, time)
    assert found == (None if near is None else pytest.approx(near, abs=1e-15))


def test_every_output_time_is_a_sample_and_what_lies_between_is_not() -> None:
    settings = Settings(duration=5, tolerance=1e-9, output_step=5 / 299)
    times = output_times(settings, 0.0)
    assert all(nearest_samples(settings, time) == () for time in times)
    between = [0.5 * (a + b) for a, b in pairwise(times)]
    assert all(nearest_samples(settings, time) for time in between)
    assert math.isclose(sum(nearest_samples(settings, between[7]) or ()), times[7] + times[8], rel_tol=1e-14)


def test_coordinates_of_all_joints_are_observable_with_their_speeds() -> None:
    for name, unit in COORDINATES.items():
        assert (OBSERVABLES["joint"][name].unit, OBSERVABLES["joint"][f"{name}_speed"].unit) == (unit, f"{unit}/s")


def test_a_time_is_no_further_mistake_where_the_steps_cannot_be_counted() -> None:
    text = changed("step: 0.01\n  integrator", "step: 1e-40\n  integrator").replace("  output_step: 0.01\n", "")
    text += "expect:\n  e: {diagnostic: energy_drift, at: 3 s, below: 1, source: me}\n"
    (message,) = errors(text)
    assert message.startswith("f.yaml:7:9: error: 'step' of 1e-40 s: 16 digits cannot tell so many steps apart")
