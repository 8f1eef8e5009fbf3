"""Two shafts with Hooke's joint: the transmission, and the exact motion from energy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.mechanisms.closed_forms import energy, ratio, time_to_reach
from tests.mechanisms.running import TIGHT, Run, assert_close, global_angular_velocity, run


@pytest.fixture(scope="module")
def shafts() -> Run:
    """A light flywheel, so that the driving shaft does not turn evenly."""
    return run("hooke_shaft", {"flywheel": "0.02"}, **TIGHT, duration=1.0, output_step=0.02)


def axis(done: Run) -> np.ndarray:
    """Along the driven shaft."""
    return np.array([np.cos(done.parameters["bend"]), np.sin(done.parameters["bend"]), 0.0])


def driven_angle(done: Run) -> np.ndarray:
    """φ2 (T,) within (-π, π]: how far the driven shaft has turned about its own line."""
    turned = done.rotation("driven") @ done.rotation("driven")[0].T
    return np.arctan2(turned[:, 2, :] @ np.cross(axis(done), [0.0, 0.0, 1.0]), turned[:, 2, 2]) * -1.0


def test_angles_obey_hookes_formula(shafts):
    φ1 = shafts.column("joints/coordinate", "bearing.angle")
    assert np.ptp(φ1) > 2 * np.pi
    exact = np.arctan2(np.sin(φ1), np.cos(φ1) * np.cos(shafts.parameters["bend"]))
    difference = driven_angle(shafts) - exact
    assert_close(np.sin(difference), 0.0, 5e-13)


def test_speeds_obey_hookes_formula(shafts):
    ω2 = global_angular_velocity(shafts, "driven") @ axis(shafts)
    φ1, ω1 = (shafts.column(f"joints/{what}", "bearing.angle") for what in ("coordinate", "speed"))
    assert_close(ω2, ω1 * ratio(shafts, φ1), 1e-11)


def test_cross_turns_in_the_driving_fork_as_spherical_trigonometry_says(shafts):
    """tan of its angle is tan β sin φ1: Napier's rule for the right triangle of the shafts and the fork's axis."""
    φ1, β = shafts.column("joints/coordinate", "bearing.angle"), shafts.parameters["bend"]
    about_first = shafts.column("joints/coordinate", "hooke.angle_1")
    assert_close(np.tan(about_first), np.tan(β) * np.sin(φ1), 2e-13)


def test_floating_bearing_stays(shafts):
    assert_close(shafts.column("joints/coordinate", "floating.displacement"), 0.0, 1e-13)


def test_shafts_turn_as_their_energy_demands(shafts):
    φ1 = shafts.column("joints/coordinate", "bearing.angle")[1::10]
    times = [time_to_reach(angle, 0.0, shafts.parameters["speed"], *energy(shafts)) for angle in φ1]
    assert_close(times, shafts["time"][1::10], 1e-12)


def test_a_flywheel_of_1e6_keeps_the_driving_shaft_even():
    """But for the energy of the driven shaft, which is 5e-9 of the whole."""
    done = run("hooke_shaft", {"flywheel": "1e6"}, **TIGHT, duration=0.7, output_step=0.02)
    assert_close(done.column("joints/coordinate", "bearing.angle"), 10.0 * done["time"], 1e-8)
    ω2 = global_angular_velocity(done, "driven") @ axis(done)
    assert_close(ω2, 10.0 * ratio(done, 10.0 * done["time"]), 1e-7)
    assert ω2.max() == pytest.approx(10.0 / np.cos(np.radians(30.0)), abs=0.02)
