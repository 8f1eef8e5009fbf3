"""The numbers in the `expect` blocks of mechanisms/*.yaml, against formulas and tables: none is mbproj's own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.mechanisms.closed_forms import (
    bare,
    expected,
    physical_angle,
    planar_energy,
    planar_pose,
    racket_rates,
    reached_at,
    scene,
    spatial_energy,
    spatial_pose,
)
from tests.mechanisms.closed_forms import energy as hooke_energy
from tests.mechanisms.running import assert_close
from tests.support import DATA, MECHANISMS


def table(name: str, time: float) -> np.void:
    rows = np.genfromtxt(DATA / f"{name}.csv", delimiter=",", names=True)
    (row,) = rows[np.abs(rows["t"] - time) < 1e-12]
    return row


def test_physical_pendulum_by_jacobis_function():
    φ = physical_angle(np.array([5.0]))[0]
    assert_close(expected("physical_pendulum", "end"), [np.sin(φ), 0.0, -np.cos(φ)], 1e-11)


@pytest.mark.parametrize("time", [3, 5])
def test_five_bar_by_its_table(time):
    row = table("five_bar", time)
    assert_close(expected("five_bar", f"tip_at_{time}_s"), [row["tip_x"], 0.0, row["tip_z"]], 1e-14)


@pytest.mark.parametrize("time", [1, 5, 10])
def test_slider_crank_by_its_table(time):
    row = table("slider_crank_comA", time)
    assert_close(expected("spatial_slider_crank", f"slider_at_{time}_s"), row["slider_x"], 1e-14)


def test_spherical_pendulum_by_its_table():
    row = table("spherical_pendulum", 5.0)
    assert_close(expected("spherical_pendulum", "bob"), [row["x_num"], row["y_num"], row["z_exact"]], 1e-12)


def test_free_body_by_jacobis_functions():
    (body,) = scene("free_body").bodies
    for entry, time in (("spin_at_3_s", 3.0), ("spin_at_10_s", 10.0)):
        exact, _ = racket_rates(np.diag(np.array(body.inertia)), body.angular_velocity[:2], np.array([time]))
        assert_close(expected("free_body", entry), exact[0], 1e-9)


def lagrange(t: float, y: np.ndarray) -> np.ndarray:
    """Two uniform bars of 1 m and 1 kg; a, b are their angles from hanging straight down:

    4/3 a'' + 1/2 cos(a - b) b'' = -1/2 sin(a - b) b'² - 3/2 g sin a,
    1/2 cos(a - b) a'' + 1/3 b'' = +1/2 sin(a - b) a'² - 1/2 g sin b.
    """
    a, b, a_dot, b_dot = y
    c, s = np.cos(a - b) / 2, np.sin(a - b) / 2
    force = [-s * b_dot**2 - 1.5 * 9.81 * np.sin(a), s * a_dot**2 - 0.5 * 9.81 * np.sin(b)]
    return np.concatenate([[a_dot, b_dot], np.linalg.solve([[4 / 3, c], [c, 1 / 3]], force)])


def test_double_pendulum_by_lagranges_equations():
    start = [np.radians(120.0)] * 2 + [0.0, 0.0]
    done = solve_ivp(lagrange, (0.0, 5.0), start, method="DOP853", rtol=1e-13, atol=1e-13, t_eval=[2.0, 5.0])
    for entry, (a, b) in zip(("end_at_2_s", "end_at_5_s"), done.y[:2].T, strict=True):
        exact = [np.sin(a) + np.sin(b), 0.0, -np.cos(a) - np.cos(b)]
        assert_close(expected("double_pendulum", entry), exact, 1e-9)


def test_planar_four_bar_by_energy_and_freudenstein():
    known = bare("planar_four_bar")
    start, swing = known.parameters["start"], known.parameters["swing"]
    φ = reached_at(2.0, start + 40.0, start, known.parameters["speed"], *planar_energy(known))
    assert_close(expected("planar_four_bar", "crank"), φ - start, 1e-10)
    assert_close(expected("planar_four_bar", "rocker"), planar_pose(known, φ)[1] - swing, 1e-10)


def test_spatial_four_bar_by_energy_and_its_transmission():
    known = bare("spatial_four_bar")
    φ = reached_at(2.0, 60.0, 0.0, known.parameters["speed"], *spatial_energy(known))
    assert_close(expected("spatial_four_bar", "crank"), φ, 1e-10)
    assert_close(expected("spatial_four_bar", "rocker"), spatial_pose(known, φ)[0] - known.parameters["swing"], 1e-10)


def test_hooke_shaft_by_energy_and_hookes_formula():
    known = bare("hooke_shaft")
    φ = reached_at(2.0, 30.0, 0.0, known.parameters["speed"], *hooke_energy(known))
    assert_close(expected("hooke_shaft", "driving_shaft"), φ, 1e-10)
    assert_close(expected("hooke_shaft", "fork"), np.arctan(np.tan(known.parameters["bend"]) * np.sin(φ)), 1e-10)


def test_every_mechanism_expects_its_joints_closed_and_its_energy_kept():
    for path in MECHANISMS:
        about = {each.quantity: each for each in scene(path.stem).expectations if each.of == "diagnostic"}
        assert about["position_violation"].below <= 2e-13, path
        assert about.keys() & {"energy_drift", "energy_drift_relative"}, path
