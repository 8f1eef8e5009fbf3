"""The planar and the spatial four-bar: closed-form transmission, and the exact motion from energy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanisms.closed_forms import planar_energy, spatial_energy, spatial_pose, time_to_reach
from tests.mechanisms.running import TIGHT, Run, assert_close, global_angular_velocity, run


@pytest.fixture(scope="module")
def planar() -> Run:
    return run("planar_four_bar", **TIGHT, duration=1.0, output_step=0.05)


@pytest.fixture(scope="module")
def spatial() -> Run:
    return run("spatial_four_bar", **TIGHT, duration=1.0, output_step=0.05)


def test_crank_goes_round_and_rocker_does_not(planar, spatial):
    for done in (planar, spatial):
        assert np.ptp(done.column("joints/coordinate", "A.angle")) > 2 * np.pi
        assert np.ptp(done.column("joints/coordinate", "D.angle")) < np.pi


def freudenstein(done: Run):
    """k1, k2, k3 of k1 cos χ - k2 cos φ + k3 = cos(φ - χ)."""
    a, b, c, d = (done.parameters[name] for name in ("crank", "coupler", "rocker", "frame"))
    return d / a, d / c, (a * a - b * b + c * c + d * d) / (2 * a * c)


def test_freudensteins_equation_and_its_derivative(planar):
    k1, k2, k3 = freudenstein(planar)
    φ = planar.parameters["start"] + planar.column("joints/coordinate", "A.angle")
    χ = planar.parameters["swing"] + planar.column("joints/coordinate", "D.angle")
    assert_close(k1 * np.cos(χ) - k2 * np.cos(φ) + k3, np.cos(φ - χ), 1e-12)
    φ_dot, χ_dot = (planar.column("joints/speed", name) for name in ("A.angle", "D.angle"))
    left = -k1 * np.sin(χ) * χ_dot + k2 * np.sin(φ) * φ_dot
    assert_close(left, -np.sin(φ - χ) * (φ_dot - χ_dot), 1e-11)


def test_planar_four_bar_stays_in_its_plane(planar):
    assert_close(planar["bodies/position"][..., 1], 0.0, 1e-13)
    assert_close(planar["bodies/angular_velocity"][..., [0, 2]], 0.0, 1e-12)


def test_planar_four_bar_moves_as_its_energy_demands(planar):
    """The time at which the crank has each recorded angle, by quadrature of the energy equation."""
    start, speed = planar.parameters["start"], planar.parameters["speed"]
    φ = start + planar.column("joints/coordinate", "A.angle")[1::4]
    times = [time_to_reach(angle, start, speed, *planar_energy(planar)) for angle in φ]
    assert_close(times, planar["time"][1::4], 1e-12)


def test_spatial_four_bar_transmits_in_closed_form(spatial):
    φ = spatial.column("joints/coordinate", "A.angle")
    χ = spatial.parameters["swing"] + spatial.column("joints/coordinate", "D.angle")
    exact = [spatial_pose(spatial, angle) for angle in φ]
    assert_close(χ, [pose[0] for pose in exact], 2e-12)
    rates = spatial.column("joints/speed", "A.angle") * [pose[-1] for pose in exact]
    assert_close(spatial.column("joints/speed", "D.angle"), rates, 1e-11)


def test_idle_spin_of_the_rod_is_conserved(spatial):
    """No moment acts about the axis of a rod with equal moments across it that hangs in two balls."""
    spin = spatial.column("bodies/angular_velocity", "rod")[:, 0]
    assert_close(spin, 30.0, 5e-10)


def test_spatial_four_bar_moves_as_its_energy_demands(spatial):
    φ = spatial.column("joints/coordinate", "A.angle")[1::4]
    times = [time_to_reach(angle, 0.0, spatial.parameters["speed"], *spatial_energy(spatial)) for angle in φ]
    assert_close(times, spatial["time"][1::4], 1e-12)


def test_rod_turns_as_its_ends_and_its_spin_say(spatial):
    """ω = n × n' + s n in global axes, with n along the rod."""
    poses = [spatial_pose(spatial, angle) for angle in spatial.column("joints/coordinate", "A.angle")]
    speed = spatial.column("joints/speed", "A.angle")
    n = np.array([C - B for _, B, C, *_ in poses]) / spatial.parameters["coupler"]
    n_dot = np.array([C_dot - B_dot for *_, B_dot, C_dot, _ in poses]) * speed[:, None] / spatial.parameters["coupler"]
    assert_close(global_angular_velocity(spatial, "rod"), np.cross(n, n_dot) + 30.0 * n, 5e-10)
