"""Bodies in free flight against Jacobi's elliptic functions (Landau & Lifshitz, Mechanics, § 37)."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import Scene
from mbproj.scene import Body, Settings
from tests.mechanisms.closed_forms import racket_rates
from tests.mechanisms.running import TIGHT, angular_momentum, assert_close, run, run_scene
from tests.support import DATA, scene_of


def free(omega, duration, step, output_step) -> Scene:
    """A body with moments 1, 2, 3 kg m² and this angular velocity, in free flight."""
    body = Body("body", 1.0, ((1.0, 0, 0), (0, 2.0, 0), (0, 0, 3.0)), (0.0, 0, 0), angular_velocity=omega)
    settings = Settings(duration=duration, step=step, integrator="dop853", output_step=output_step)
    return scene_of([body], [], gravity=(0.0, 0.0, 0.0), settings=settings)


def table(name: str) -> tuple[np.ndarray, np.ndarray]:
    """The table and its angular velocities (T, 3)."""
    exact = np.genfromtxt(DATA / f"{name}.csv", delimiter=",", names=True)
    return exact, np.stack([exact[f"w{axis}_body"] for axis in (1, 2, 3)], axis=-1)


def test_handle_turns_over_as_jacobis_functions_say():
    """It comes within 1e-2 of the unstable axis, so errors grow each time that it turns over."""
    done = run("free_body", integrator="dop853", step="0.01", duration=5, output_step=0.1)
    (body,) = done.scene.bodies
    exact, _ = racket_rates(np.diag(np.array(body.inertia)), body.angular_velocity[:2], done["time"])
    assert_close(done["bodies/angular_velocity"][:, 0], exact, 5e-9)


def test_tip_of_the_handle_flips_and_flips_back_at_equal_times():
    """The spin about the stem is reversed one interval after the start, and restored after two."""
    _, interval = racket_rates((2.5e-4, 6.4e-4 / 1.5, 1.015e-3 / 1.5), (0.1, 10.0), np.zeros(1))
    assert interval == pytest.approx(2.345, abs=1e-3)
    done = run("free_body", integrator="dop853", step=interval / 250, duration=2 * interval, output_step=interval)
    assert_close(done["bodies/angular_velocity"][:, 0, 1], [10.0, -10.0, 10.0], 5e-12)


def test_angular_velocity_and_attitude_against_the_table():
    exact, rates = table("free_body_jacobi")
    done = run_scene(free((1.0, 0.0, 1.0), 20.0, 0.1, 2.0))
    assert_close(done["time"], exact["t"], 1e-14)
    assert_close(done["bodies/angular_velocity"][:, 0], rates, 2e-11)
    attitude = np.stack([exact[f"e{k}"] for k in range(4)], axis=-1)
    assert_close(done["bodies/orientation"][:, 0], attitude, 2e-11)


def test_tennis_racket_against_the_table():
    exact, rates = table("tennis_racket")
    done = run_scene(free((0.01, 1.0, 0.0), 40.0, 0.1, 4.0))
    assert_close(done["bodies/angular_velocity"][:, 0], rates, 2e-10)
    formula, interval = racket_rates((1.0, 2.0, 3.0), (0.01, 1.0), exact["t"])
    assert_close(rates, formula, 1e-12)
    assert interval == pytest.approx(20.75460976465357, rel=1e-12)


def test_angular_momentum_of_the_handle_stays_in_space():
    done = run("free_body", **TIGHT, duration=3, output_step=0.1)
    momentum = angular_momentum(done)
    size = np.linalg.norm(momentum[0])
    assert_close(momentum / size, momentum[0] / size, 2e-11)
