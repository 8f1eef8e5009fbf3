"""Tops in steady precession, and the spherical pendulum's path, against exact solutions."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanisms.running import TIGHT, angular_momentum, assert_close, run
from tests.support import DATA

STEADY = np.genfromtxt(DATA / "top_steady.csv", delimiter=",", names=True)


@pytest.fixture(scope="module", params=STEADY, ids=["slow", "fast", "horizontal"])
def precession(request):
    """The row of the table and its run."""
    row = request.param
    parameters = {"nutation": f"{row['nutation']} deg", "precession": repr(float(row["precession"]))}
    return row, run("heavy_top", parameters, **TIGHT, duration=0.4, output_step=0.02)


def test_scene_finds_the_spin_of_steady_precession(precession):
    row, done = precession
    assert done.parameters["steady"] == pytest.approx(row["spin"], rel=1e-12)


def test_axis_goes_round_at_the_exact_rate_without_nodding(precession):
    row, done = precession
    θ, turn = np.radians(row["nutation"]), row["precession"] * done["time"]
    exact = np.stack([-np.sin(θ) * np.sin(turn), np.sin(θ) * np.cos(turn), np.full_like(turn, np.cos(θ))], axis=-1)
    assert_close(done["markers/position"][:, 0], exact, 5e-12)


def test_spin_and_vertical_angular_momentum_are_conserved(precession):
    row, done = precession
    assert_close(done["bodies/angular_velocity"][:, 0, 2], row["spin"], 1e-11 * row["spin"])
    about_the_ball = angular_momentum(done, "origin")[:, 2]
    assert_close(about_the_ball, about_the_ball[0], 1e-11 * 0.46875 * row["spin"])


def test_reaction_of_the_ball_carries_the_weight_and_turns_the_centre():
    """Steady precession: the centre of mass moves on a circle, so the force is the weight, and m Ω² ρ to its axis."""
    done = run("heavy_top", **TIGHT, duration=0.05, output_step=0.01)
    centre, mass = done["markers/position"][:, 0], done.parameters["mass"]
    exact = -mass * done.parameters["precession"] ** 2 * centre * [1.0, 1.0, 0.0] + [0.0, 0.0, mass * 9.81]
    assert_close(done["joints/reaction_force"][:, 0], exact, 1e-9)


def test_wrong_spin_nods():
    """What the tests above could not fail without."""
    done = run("heavy_top", {"excess": "-50"}, **TIGHT, duration=0.3, output_step=0.02)
    assert np.ptp(done["markers/position"][:, 0, 2]) > 0.01


def test_spherical_pendulum_against_the_table():
    exact = np.genfromtxt(DATA / "spherical_pendulum.csv", delimiter=",", names=True)
    done = run("spherical_pendulum", **TIGHT, duration=5, output_step=0.5)
    path = np.stack([exact["x_num"], exact["y_num"], exact["z_exact"]], axis=-1)
    assert_close(done["markers/position"][:, 0], path, 2e-11)
