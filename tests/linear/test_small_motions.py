"""Runs of small amplitude follow the modes, on shipped mechanisms; a model that is wrong is found out."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbproj.linear.modes import modes
from mbproj.mechanisms_folder import mechanism
from mbproj.scene import read_scene
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.verify import small_motions
from mbproj.studies.verify.case import Case
from mbproj.studies.verify.finding import Finding

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
    return small_motions.small_motions(Case(Mechanism.of(read_scene(mechanism(name)))))


@pytest.mark.parametrize("name", RINGING)
def test_a_run_beside_the_equilibrium_follows_the_mode_that_it_begins_in(name):
    found = checked(name)
    assert isinstance(found, Finding), found
    assert found.measured < 1e-6


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("hooke_shaft", "no mode oscillates"),
        ("free_body", "there are no joint coordinates to compare"),
        ("stewart_platform", "there is nothing to linearise: there is no equilibrium"),
        ("inline_four", "there is nothing to linearise"),
    ],
)
def test_it_says_where_it_does_not_apply(name, why):
    assert why in checked(name)


def test_a_frequency_that_is_wrong_is_found_out(monkeypatch):
    """By a part in 10 000."""

    def wrong(reference):
        found = modes(reference)
        return replace(found, eigenvalues=found.eigenvalues * 1.0001)

    monkeypatch.setattr(small_motions, "modes", wrong)
    found = checked("physical_pendulum")
    assert not found.passed
    assert found.measured == pytest.approx(1e-4 * 3.14159 / 2, rel=0.1)
