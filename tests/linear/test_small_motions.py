"""Runs of small amplitude follow the modes, on shipped mechanisms; a model that is wrong is found out."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbproj import Mechanism
from mbproj.base.mechanisms_folder import mechanism
from mbproj.linear.modes import modes
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.studies.verify import short_runs
from mbproj.studies.verify.case import Case, Finding
from mbproj.studies.verify.checks import CHECKS, _check
from tests.crossed import full
from tests.kernel.scenes import needs_kernel

RINGING = (
    "bennett",
    "bricard",
    "delta_robot",
    "double_pendulum",
    "five_bar",
    "locomotive",
    "massless_coupler",
    "physical_pendulum",
    "planar_four_bar",
    "spatial_four_bar",
)


def checked(name):
    return short_runs.small_motions(Case(Mechanism.of(read_scene(mechanism(name)))))


@pytest.mark.parametrize("name", [name if number % 4 == 0 else full(name) for number, name in enumerate(RINGING)])
def test_a_run_beside_the_equilibrium_follows_the_mode_that_it_begins_in(name):
    found = checked(name)
    assert isinstance(found, Finding), found
    assert found.measured < 1e-6


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("hooke_shaft", "no mode oscillates"),
        ("free_body", "there are no joint coordinates to compare"),
        full("stewart_platform", "there is nothing to linearise: there is no equilibrium"),
        ("inline_four", "there is nothing to linearise"),
    ],
)
def test_it_says_where_it_does_not_apply(name, why):
    assert why in checked(name)


CAM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, output_step: 0.1, tolerance: 1.0e-8}
bodies:
  wheel: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
  follower: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0.3]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [1, 0, 0], axis: [0, 1, 0], speed: 60 rpm}
  slide: {type: prismatic, bodies: [ground, follower], location: [1, 0, 0.3], axis: [0, 0, 1]}
  cam: {type: coupler, of: {pin: 0, slide: 1}, function: {rows: [ROWS], between: periodic}}
"""
KNOT = "[0 deg, 0 mm], [90 deg, 12 mm], [180 deg, 20 mm], [270 deg, 12 mm], [360 deg, 0 mm]"
BETWEEN = "[-45 deg, 3 mm], [45 deg, 3 mm], [180 deg, 20 mm], [315 deg, 3 mm]"


@needs_kernel
@pytest.mark.parametrize(("rows", "rests"), [(KNOT, True), full(BETWEEN, False)], ids=["knot", "between"])
def test_a_cam_that_rests_at_a_knot_has_no_motion_that_is_linear_on_both_sides(rows, rests):
    """The third derivative of its lift jumps there. Order and energy are told from motions that pass no knot."""
    case = Case(Mechanism.of(read_scene_text(CAM.replace("ROWS", rows))))
    found = {name: _check(name, CHECKS[name], case) for name in ("linear", "order", "energy")}
    assert (
        found["linear"].remark.startswith(
            "it rests at the edge of a law, and moves differently on its two sides: joint 'cam'"
        )
        == rests
    )
    assert found["linear"].verdict == ("does not apply" if rests else "passed")
    assert "failed" not in {each.verdict for each in found.values()}


def test_a_frequency_that_is_wrong_is_found_out(monkeypatch):
    """By a part in 10 000."""

    def wrong(reference):
        found = modes(reference)
        return replace(found, eigenvalues=found.eigenvalues * 1.0001)

    monkeypatch.setattr(short_runs, "modes", wrong)
    found = checked("physical_pendulum")
    assert not found.passed
    assert found.measured == pytest.approx(1e-4 * 3.14159 / 2, rel=0.1)
