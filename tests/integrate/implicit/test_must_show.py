"""Stiff mechanisms at dials at which explicit steps are held up: few steps, small errors, closed joints."""

from __future__ import annotations

from math import asin, cos, sqrt

import numpy as np
import pytest

from scripts.beside.stiff_scenes import CASES, belt, chain, governor
from tests.integrate.implicit.stiff_run import run

IMPLICIT = ("esdirk4", "radau5")


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_mass_sticks_on_a_belt(integrator):
    """It slips, x'' = 5 - 100 x, until it is as fast as the belt, 0.1 m/s, and then sticks but for a part of the width
    of the law, 5e-5 m/s. DOP853 takes 1,300 steps."""
    found = run(belt(1e5), 0.2, integrator, 1e-5)
    sticks = asin(0.2) / 10.0
    assert found.q[-1, 0] == pytest.approx(0.05 * (1.0 - sqrt(1.0 - 0.2**2)) + 0.1 * (0.2 - sticks), abs=5e-6)
    assert found.steps <= 25


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_a_chain_of_stiff_torsion_springs_falls_as_a_bar(integrator):
    """Four links of 0.2 m and 0.1 kg, springs of 1e6 N m/rad: θ'' = 0.4 m M g cos θ / I, and θ is ½ θ'' t². DOP853
    takes 60,000 steps."""
    found = run(chain(1e6), 0.05, integrator, 1e-4)
    inertia, moment = 4 * 3.4e-4 + 0.1 * (0.1**2 + 0.3**2 + 0.5**2 + 0.7**2), 0.4 * 9.81 * 0.4
    angle = 0.5 * moment / inertia * 0.05**2
    assert found.q[-1, 0] == pytest.approx(0.1 * cos(angle), abs=1e-7)
    assert found.q[-1, 21] == pytest.approx(0.7 * cos(angle), abs=1e-6)
    assert found.steps <= 6
    assert found.closure <= 1e-13


def test_a_governor_whose_spring_and_damper_hardly_give_way():
    """1e8 N/m and 1e5 N s/m: two methods that differ agree in a few steps."""
    found = [run(governor(1e8), 0.05, name, 1e-4) for name in IMPLICIT]
    assert np.abs(found[0].q - found[1].q).max() < 2e-4
    assert max(each.steps for each in found) <= 20
    assert max(each.closure for each in found) <= 1e-13


@pytest.mark.parametrize("case", ["rsup", "elastic-rod"])
def test_rods_that_stiff_bushings_hold_together(case):
    """Two halves in space, ten pieces in the plane, at 1e10 N/m: two methods that differ agree in a few steps, where
    DOP853 takes thousands."""
    found = [run(CASES[case](1e10), 0.05, name, 1e-4) for name in IMPLICIT]
    assert found[0].off(found[1]) < 1e-4
    assert max(each.steps for each in found) <= 20
    assert max(each.closure for each in found) <= 1e-13
