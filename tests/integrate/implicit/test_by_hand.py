"""A stiff four-bar and a governor beside Lagrange's equations in their angles, the reference for other programs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import Mechanism
from mbproj.base.settings import Settings
from mbproj.motion.simulate import simulate
from scripts.beside.lagrange import CRANK, HALF, FourBar, Governor
from scripts.beside.stiff_scenes import four_bar, governor
from tests.integrate.implicit.stiff_run import run
from tests.support import Recorder


@pytest.mark.parametrize("k", [1e4, 1e7])
def test_the_motion_is_that_of_the_angles(k):
    """At 1e7 N/m, too, the two methods, neither of which knows the other's coordinates, agree to what both leave."""
    bar, end = FourBar(k), 0.1
    exact = solve_ivp(bar.slope, (0.0, end), bar.start, method="DOP853", rtol=1e-10, atol=1e-12).y[:4, -1]
    q = run(four_bar(k), end, "radau5", 1e-9).q[-1].reshape(4, 7)
    near = q[1, [0, 2]] + HALF / 2 * np.array([np.cos(exact[1]), np.sin(exact[1])])
    assert near == pytest.approx(bar.watched(exact)[0, [0, 2]], abs=1e-8)
    crank = CRANK / 2 * np.array([np.cos(exact[0]), np.sin(exact[0])])
    assert q[0, [0, 2]] == pytest.approx(crank, abs=1e-8)


def test_the_accelerations_at_the_start_are_the_same():
    """By them each program is seen to have the same mechanism."""
    bar, mechanism, recorder = FourBar(1e6), Mechanism.of(four_bar(1e6)), Recorder()
    simulate(mechanism.system, mechanism.state, Settings(duration=1e-6, step=1e-6, integrator="rk4"), recorder)
    about_y = recorder["bodies/angular_acceleration"][0, :, 1]
    assert -about_y == pytest.approx(bar.slope(0.0, bar.start)[4:], rel=1e-9)


@pytest.mark.parametrize("k", [1e4, 1e7])
def test_the_governor_turns_and_opens_as_its_angles(k):
    made, end = Governor(k), 0.1
    exact = solve_ivp(made.slope, (0.0, end), made.start, method="DOP853", rtol=1e-11, atol=1e-13).y[:2, -1]
    q = run(governor(k), end, "radau5", 1e-9).q[-1].reshape(4, 7)
    ball, collar = made.watched(exact)
    assert [*q[1, :2], q[3, 2]] == pytest.approx([*ball[:2], collar[2]], abs=1e-8)
