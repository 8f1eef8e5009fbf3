"""What is integrated along a kinematic motion: works, losses, states of elements; and the quadrature."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.integrate.steppers.tableau import ERROR_ORDER, ORDER, quadrature
from tests.crossed import crossed
from tests.integrate.kinematic.scenes import FORMULATIONS, FOUR_BAR, run
from tests.model.element_scenes import DRIVEN, T1, with_states

#: Behind the crank's motion goes nothing; x follows a sine, z follows x.
LAGS = (f"(sin({DRIVEN}*t) - x)/{T1}", "x")


def test_the_quadrature_is_exact_for_polynomials_of_its_order():
    rule = quadrature()
    for degree in range(ORDER):
        assert rule.b @ rule.c**degree == pytest.approx(1.0 / (degree + 1), abs=1e-13)
    assert rule.b @ rule.c**ORDER != pytest.approx(1.0 / (ORDER + 1), abs=1e-9)
    for degree in range(ERROR_ORDER):
        assert rule.error[0, :-1] @ rule.c**degree == pytest.approx(0.0, abs=1e-13)
    assert abs(rule.error[0, :-1] @ rule.c**ERROR_ORDER) > 1e-5


def test_its_extension_is_the_integral_to_any_part_of_a_step():
    rule, theta = quadrature(), 0.37
    for degree in range(7):
        found = theta ** np.arange(1, 8) @ (rule.dense[:-1].T @ rule.c**degree)
        assert found == pytest.approx(theta ** (degree + 1) / (degree + 1), abs=1e-13)


def test_a_stage_is_predicted_from_those_before():
    rule = quadrature()
    for stage in range(1, 7):
        for degree in range(stage):
            found = rule.a[stage, :stage] @ rule.c[:stage] ** degree
            assert found == pytest.approx(rule.c[stage] ** (degree + 1) / (degree + 1), rel=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_dampers_take_what_their_rate_says(formulation):
    """Of a damper at the driven pin: c ω² a second; and of the same with a sine, in closed form."""
    text = FOUR_BAR.replace("constant_speed: 60 rpm", "expression: '0.3*sin(5*t)'")
    text += "forces: {damper: {type: torsion_spring_damper, joint: A, damping: 0.4}}\n"
    report, found, _ = run(text, formulation=formulation, duration="0.6 s")
    t = found["time"]
    lost = 0.4 * 1.5**2 * (0.5 * t + np.sin(10.0 * t) / 20.0)
    np.testing.assert_allclose(found["diagnostics/dissipation"], lost, rtol=0, atol=1e-10)
    assert report.energy_drift < 1e-9


def test_dry_friction_at_a_driven_joint_loses_its_torque_times_the_way():
    text = FOUR_BAR + "forces: {rub: {type: friction, joint: D, coulomb: {torque: 2 N*m}}}\n"
    report, found, _ = run(text, duration="1 s", output_step="1 ms", kinematic="true")
    way = np.abs(np.diff(np.unwrap(found["joints/coordinate"][:, 3]))).sum()
    assert report.kinematic
    assert report.energy.dissipation == pytest.approx(2.0 * way, rel=1e-5)
    assert report.energy_drift_relative < 1e-9


@crossed(
    "settings, off, formulation",
    [
        pytest.param({"integrator": "dop853", "tolerance": 1e-9}, 1e-8),
        pytest.param({"integrator": "rk4", "step": "2.5 ms"}, 1e-6),
        pytest.param({"integrator": "radau5", "tolerance": 1e-6}, 1e-5),
        pytest.param({"integrator": "auto", "tolerance": 1e-8}, 1e-6),
    ],
    FORMULATIONS,
)
def test_states_are_integrated_by_the_scenes_integrator(formulation, settings, off):
    text = FOUR_BAR.replace("tolerance: 1e-3, integrator: dop853, ", "")
    options = {"formulation": formulation, "duration": "0.05 s", "output_step": "0.025 s", **settings}
    report, found, _ = run(text, change=lambda system: with_states(system, LAGS, start=(0.0, 0.0)), **options)
    assert report.kinematic
    t, ω = found["time"], DRIVEN
    x = (np.sin(ω * t) - ω * T1 * np.cos(ω * t) + ω * T1 * np.exp(-t / T1)) / (1.0 + (ω * T1) ** 2)
    np.testing.assert_allclose(found["states/value"][:, 0], x, rtol=0, atol=off)
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], 2.0 * np.pi * t, atol=1e-12)


@pytest.mark.full
def test_implicit_steps_integrate_them_in_full_too():
    test_states_are_integrated_by_the_scenes_integrator("full", {"integrator": "radau5", "tolerance": 1e-6}, 1e-5)
