"""An energy drift is the sum of the integrator's part and the projections' work."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.studies.compare import energy_split
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import sample_times, solve
from tests.crossed import where

TIMES = sample_times(1.0, 20)
SETTINGS = [
    Setting(step=0.01),
    Setting("gopm", step=0.005, every=3),
    Setting(step=0.01, threshold=1e-6),
    Setting(step=0.01, formulation="full"),
    Setting("gopm", "heun2", step=0.0125 / 2),
    Setting("gopm", "esdirk4", step=0.01, every=3),
    Setting(integrator="radau5", step=0.01),
]


@pytest.mark.parametrize(
    "setting", where(lambda setting: setting.formulation != "full", SETTINGS), ids=lambda setting: setting.label
)
def test_the_parts_sum_up_to_the_drift(slider_crank, setting):
    solution = solve(slider_crank, setting, TIMES)
    split = energy_split(slider_crank, solution)
    drift = solution.energy_balance
    assert np.abs(drift).max() > 1e-6
    assert split.integrator + split.projection == pytest.approx(drift, abs=1e-11)


@pytest.mark.parametrize("integrator", ["dopri5", "dop853"])
def test_of_an_error_controlled_run_too(slider_crank, integrator):
    """At the end, which is the end of a step: samples inside are of the continuous extension. Single steps project with
    the factor of another stage than steps under error control, which counts in the second order."""
    solution = solve(slider_crank, Setting(integrator=integrator, tolerance=1e-5), TIMES)
    split = energy_split(slider_crank, solution)
    assert abs(solution.energy_balance[-1]) > 1e-7
    assert split.integrator[-1] + split.projection[-1] == pytest.approx(solution.energy_balance[-1], rel=1e-3)


def test_without_projection_all_is_the_integrators(slider_crank):
    solution = solve(slider_crank, Setting("none", step=0.01), TIMES)
    split = energy_split(slider_crank, solution)
    assert np.array_equal(split.integrator, solution.energy_balance)
    assert not split.projection.any()


def test_a_velocity_projection_by_mass_takes_kinetic_energy_only(slider_crank):
    """v' is the M-orthogonal projection of v: T' = T - ½ Δvᵀ M Δv (Pythagoras). In GOPM's metric that is not so."""
    work = {}
    for method in ("gpopm", "gopm"):
        solution = solve(slider_crank, Setting(method, step=0.01, project_position=False), sample_times(1.0, 100))
        work[method] = np.diff(energy_split(slider_crank, solution).projection)
    assert np.all(work["gpopm"] <= 1e-15)
    assert work["gpopm"].min() < -1e-9
    assert work["gopm"].max() > 1e-7
