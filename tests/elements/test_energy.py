"""What elements keep and lose, in the energy account of a run."""

from __future__ import annotations

import numpy as np
import pytest

from tests.elements.scenes import FORMULATIONS, at, brief, motor, run, spring


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_spring_that_is_an_element_does_no_work(formulation):
    """A slide of 3 kg that swings with 2 m/s at the start: T + V is 6 J all the time."""
    system, found, report = run([spring("coil", "rail.displacement", 48.0)], slide=2.0, **brief(formulation))
    t, s = found["time"], at(found, "rail.displacement", system.names.coordinates)
    np.testing.assert_allclose(s, 0.5 * np.sin(4.0 * t), atol=1e-9)
    weight = 3 * 9.81 * 0.3
    np.testing.assert_allclose(found["diagnostics/potential_energy"], weight + 24.0 * s**2, atol=1e-9)
    np.testing.assert_allclose(found["diagnostics/total_energy"], weight + 6.0, atol=1e-8)
    np.testing.assert_allclose(found["diagnostics/work"], 0.0, atol=1e-8)
    assert abs(report.energy.work) < 1e-8
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-8


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_account_of_a_motor_is_electric(formulation):
    """J ω = k ∫i, so that W = ∫U i = U J ω/k; of it the winding keeps ½ L i² and loses ∫R i²."""
    U, R, L, k, J = 12.0, 0.8, 0.05, 0.3, 0.1
    system, found, report = run([motor("motor", "pin.angle", U, (R, L), k)], **brief(formulation))
    rate = found["joints/speed"][:, system.names.coordinates.index("pin.angle")]
    current, heat = found["states/value"].T
    exact = np.array([[0.0, k / J], [-k / L, -R / L]])
    values, vectors = np.linalg.eig(exact)
    steady = np.array([U / k, 0.0])
    moved = np.real(np.exp(np.outer(found["time"], values)) * np.linalg.solve(vectors, -steady) @ vectors.T)
    np.testing.assert_allclose(np.column_stack([rate, current]), steady + moved, atol=1e-7)
    np.testing.assert_allclose(found["diagnostics/work"], U * J * rate / k, atol=1e-7)
    np.testing.assert_allclose(found["diagnostics/dissipation"], heat, atol=1e-12)
    kept = 3 * 9.81 * 0.3 + 0.5 * J * rate**2 + 0.5 * L * current**2
    np.testing.assert_allclose(found["diagnostics/total_energy"], kept, atol=1e-10)
    assert heat[-1] > 1.0
    assert report.energy.dissipation == pytest.approx(heat[-1], abs=1e-12)
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-7
