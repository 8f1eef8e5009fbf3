"""Bodies in free flight against Jacobi's elliptic functions (Landau & Lifshitz, Mechanics, § 37)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from mbproj.scene.records import Body, Scene, Settings
from tests.mechanisms.running import TIGHT, angular_momentum, run, run_scene
from tests.support import DATA, scene_of


def racket_rates(moments, start, t):
    """ω (T, 3) in body axes for A < B < C and ω(0) = (p, q, 0) with L² < 2EB: ω = (a dn, b sn, c cn)(n t + K | m).

    n² = (B - A)(2EC - L²)/(ABC), m = (C - B)(L² - 2EA)/((B - A)(2EC - L²)): Landau's solution, A and C exchanged.
    """
    A, B, C = moments
    energy2 = A * start[0] ** 2 + B * start[1] ** 2
    momentum2 = (A * start[0]) ** 2 + (B * start[1]) ** 2
    n = np.sqrt((B - A) * (energy2 * C - momentum2) / (A * B * C))
    m = (C - B) * (momentum2 - energy2 * A) / ((B - A) * (energy2 * C - momentum2))
    sn, cn, dn, _ = ellipj(n * t + ellipk(m), m)
    a = np.sqrt((energy2 * C - momentum2) / (A * (C - A)))
    b = np.sqrt((momentum2 - energy2 * A) / (B * (B - A)))
    c = np.sqrt((momentum2 - energy2 * A) / (C * (C - A)))
    return np.stack([a * dn, b * sn, c * cn], axis=-1), 2.0 * ellipk(m) / n


def free(omega, duration, output_step) -> Scene:
    """A body with moments 1, 2, 3 kg m² and this angular velocity, in free flight."""
    body = Body("body", 1.0, ((1.0, 0, 0), (0, 2.0, 0), (0, 0, 3.0)), (0.0, 0, 0), angular_velocity=omega)
    settings = Settings(duration=duration, tolerance=1e-12, integrator="dop853", output_step=output_step)
    return scene_of([body], [], gravity=(0.0, 0.0, 0.0), settings=settings)


def test_handle_turns_over_as_jacobis_functions_say():
    done = run("free_body", **TIGHT, duration=10, output_step=0.25)
    (body,) = done.scene.bodies
    moments = np.diag(np.array(body.inertia))
    exact, interval = racket_rates(moments, body.angular_velocity[:2], done["time"])
    np.testing.assert_allclose(done["bodies/angular_velocity"][:, 0], exact, atol=3e-8)
    assert 1.0 < interval < 5.0  # it does turn over in these 10 s


def test_tip_of_the_handle_comes_back_after_two_flips():
    """The spin about the stem is -q at one flip's interval after the start, and q again at two."""
    _, interval = racket_rates((2.5e-4, 4.266666666666667e-4, 6.766666666666667e-4), (0.1, 10.0), np.zeros(1))
    done = run("free_body", **TIGHT, duration=2 * interval, output_step=interval)
    np.testing.assert_allclose(done["bodies/angular_velocity"][:, 0, 1], [10.0, -10.0, 10.0], atol=1e-8)


def test_angular_velocity_and_attitude_against_the_table():
    exact = np.genfromtxt(DATA / "free_body_jacobi.csv", delimiter=",", names=True)
    done = run_scene(free((1.0, 0.0, 1.0), 20.0, 2.0))
    np.testing.assert_allclose(done["time"], exact["t"], atol=1e-14)
    rates = np.stack([exact[f"w{axis}_body"] for axis in (1, 2, 3)], axis=-1)
    np.testing.assert_allclose(done["bodies/angular_velocity"][:, 0], rates, atol=3e-11)
    attitude = np.stack([exact[f"e{k}"] for k in range(4)], axis=-1)
    np.testing.assert_allclose(done["bodies/orientation"][:, 0], attitude, atol=3e-11)


def test_tennis_racket_against_the_table():
    """It comes within 1e-2 of the unstable axis, so errors grow until it turns over."""
    exact = np.genfromtxt(DATA / "tennis_racket.csv", delimiter=",", names=True)
    done = run_scene(free((0.01, 1.0, 0.0), 40.0, 4.0))
    rates = np.stack([exact[f"w{axis}_body"] for axis in (1, 2, 3)], axis=-1)
    np.testing.assert_allclose(done["bodies/angular_velocity"][:, 0], rates, atol=1e-8)
    formula, interval = racket_rates((1.0, 2.0, 3.0), (0.01, 1.0), exact["t"])
    np.testing.assert_allclose(rates, formula, atol=1e-11)
    assert interval == pytest.approx(20.75460976465357, rel=1e-12)


def test_angular_momentum_of_the_handle_stays_in_space():
    done = run("free_body", **TIGHT, duration=3, output_step=0.1)
    momentum = angular_momentum(done)
    size = np.linalg.norm(momentum[0])
    np.testing.assert_allclose(momentum / size, np.broadcast_to(momentum[0] / size, momentum.shape), atol=1e-11)
