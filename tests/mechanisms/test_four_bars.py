"""The planar and the spatial four-bar: closed-form transmission, and the exact motion from energy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanisms.one_degree import Of, time_to_reach
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


def planar_pose(done: Run, φ: float):
    """Angles of coupler and rocker by the intersection of two circles, and their rates for φ' = 1."""
    a, b, c, d = (done.parameters[name] for name in ("crank", "coupler", "rocker", "frame"))
    diagonal = d - a * np.exp(1j * φ)
    ψ = np.angle(diagonal) + np.arccos((b * b + abs(diagonal) ** 2 - c * c) / (2 * b * abs(diagonal)))
    χ = np.angle(b * np.exp(1j * ψ) - diagonal)
    # a e^iφ + b ψ' e^iψ = c χ' e^iχ, each part without the other unknown
    return ψ, χ, a * np.sin(φ - χ) / (b * np.sin(χ - ψ)), a * np.sin(φ - ψ) / (c * np.sin(χ - ψ))


def planar_energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the crank, and potential energy, of the crank's angle φ."""
    a, b, c = (done.parameters[name] for name in ("crank", "coupler", "rocker"))
    crank, coupler, rocker = done.scene.bodies

    def moment(φ: float) -> float:
        ψ, _, ψ_rate, χ_rate = planar_pose(done, φ)
        velocity = a * np.exp(1j * φ) + b / 2 * ψ_rate * np.exp(1j * ψ)
        turning = crank.inertia[1][1] + coupler.inertia[1][1] * ψ_rate**2 + rocker.inertia[1][1] * χ_rate**2
        return turning + crank.mass * a**2 / 4 + coupler.mass * abs(velocity) ** 2 + rocker.mass * (c / 2 * χ_rate) ** 2

    def potential(φ: float) -> float:
        ψ, χ, _, _ = planar_pose(done, φ)
        heights = a / 2 * np.sin(φ), a * np.sin(φ) + b / 2 * np.sin(ψ), c / 2 * np.sin(χ)
        return 9.81 * sum(m * z for m, z in zip((crank.mass, coupler.mass, rocker.mass), heights, strict=True))

    return moment, potential


def test_planar_four_bar_moves_as_its_energy_demands(planar):
    """The time at which the crank has each recorded angle, by quadrature of the energy equation."""
    start, speed = planar.parameters["start"], planar.parameters["speed"]
    φ = start + planar.column("joints/coordinate", "A.angle")[1::4]
    times = [time_to_reach(angle, start, speed, *planar_energy(planar)) for angle in φ]
    assert_close(times, planar["time"][1::4], 1e-12)


def spatial_pose(done: Run, φ: float):
    """Ends B, C of the rod and their velocities for φ' = 1, with 2cx sin χ - 2ac sin φ cos χ = k."""
    a, b, c, x, y = (done.parameters[name] for name in ("crank", "coupler", "rocker", "x", "y"))
    k = b * b - c * c - x * x - y * y - a * a + 2 * a * y * np.cos(φ)
    p, q = 2 * c * x, -2 * a * c * np.sin(φ)
    χ = np.arctan2(p, q) - np.arccos(k / np.hypot(p, q))
    B, C = a * np.array([0.0, np.cos(φ), np.sin(φ)]), np.array([x + c * np.sin(χ), y, c * np.cos(χ)])
    B_dot, C_χ = a * np.array([0.0, -np.sin(φ), np.cos(φ)]), c * np.array([np.cos(χ), 0.0, -np.sin(χ)])
    χ_rate = (C - B) @ B_dot / ((C - B) @ C_χ)
    return χ, B, C, B_dot, C_χ * χ_rate, χ_rate


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


def spatial_energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the crank, and potential energy, of the crank's angle φ. The idle spin does no work on the
    rest: its energy is constant, and the gyroscopic moment is normal to ω."""
    a, b, c = (done.parameters[name] for name in ("crank", "coupler", "rocker"))
    crank, rod, rocker = done.scene.bodies

    def moment(φ: float) -> float:
        *_, B_dot, C_dot, χ_rate = spatial_pose(done, φ)
        tilting = np.sum((C_dot - B_dot) ** 2) / b**2
        turning = crank.inertia[0][0] + rod.inertia[1][1] * tilting + rocker.inertia[1][1] * χ_rate**2
        moving = rod.mass * np.sum((B_dot + C_dot) ** 2) / 4 + rocker.mass * (c / 2 * χ_rate) ** 2
        return turning + crank.mass * a**2 / 4 + moving

    def potential(φ: float) -> float:
        _, B, C, *_ = spatial_pose(done, φ)
        return 9.81 / 2 * (crank.mass * B[2] + rod.mass * (B[2] + C[2]) + rocker.mass * C[2])

    return moment, potential


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
