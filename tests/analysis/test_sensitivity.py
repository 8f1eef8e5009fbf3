"""Sobol' indices and rank correlations, against the analytic ones of the Ishigami function and against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import spearmanr

from mbproj.results.analysis.sensitivity import rank_correlation, rank_interval, sobol_indices
from mbproj.studies.sweep.spec import saltelli

A, B = 7.0, 0.1
#: sin x + A sin² y + B z⁴ sin x of uniform x, y, z in ±π (Ishigami and Homma 1990): parts of its variance.
OF_X, OF_Y, OF_XZ = (1.0 + B * np.pi**4 / 5.0) ** 2 / 2.0, A**2 / 8.0, B**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
WHOLE = OF_X + OF_Y + OF_XZ
FIRST = np.array([OF_X, OF_Y, 0.0]) / WHOLE
TOTAL = np.array([OF_X + OF_XZ, OF_Y, OF_XZ]) / WHOLE


def ishigami(samples: int, seed: int = 0) -> np.ndarray:
    x, y, z = np.pi * (2.0 * saltelli(3, samples, seed) - 1.0).T
    return np.sin(x) + A * np.sin(y) ** 2 + B * z**4 * np.sin(x)


@pytest.mark.parametrize(("samples", "error"), [(256, 0.15), (4096, 0.015)])
def test_the_indices_are_those_of_the_ishigami_function(samples, error):
    found = sobol_indices(ishigami(samples), samples)
    assert np.abs(found.first - FIRST).max() < error
    assert np.abs(found.total - TOTAL).max() < error
    assert found.samples == samples


def test_the_intervals_hold_the_truth_as_often_as_they_say_and_shrink_with_the_root_of_the_samples():
    few, many = ([sobol_indices(ishigami(count, seed), count) for seed in range(12)] for count in (128, 2048))
    for found in (few, many):
        first, total = (np.array([getattr(each, f"{name}_between") for each in found]) for name in ("first", "total"))
        held = [(low <= true) & (true <= high) for of, true in ((first, FIRST), (total, TOTAL)) for low, high in of]
        assert np.mean(held) > 0.9
    widths = [np.mean([np.ptp(each.total_between, axis=0) for each in found], axis=0) for found in (few, many)]
    assert widths[0] / widths[1] == pytest.approx(4.0, rel=0.15)


def test_a_sample_with_a_failed_case_is_left_out_and_a_shift_changes_nothing():
    values = ishigami(1024)
    failed = values.copy()
    failed[[5, 1024 + 9, 4 * 1024 + 9]] = np.nan
    found = sobol_indices(failed, 1024)
    assert found.samples == 1022
    assert np.abs(found.first - FIRST).max() < 0.03
    shifted = sobol_indices(values + 1e6, 1024)
    assert shifted.first == pytest.approx(sobol_indices(values, 1024).first, abs=1e-6)


def test_what_does_not_vary_and_what_all_failed_have_no_indices():
    for values in (np.ones(40), np.full(40, np.nan)):
        found = sobol_indices(values, 8)
        assert np.isnan([found.first, found.total]).all()


def test_rank_correlations_are_scipys_with_equal_values_too():
    draw = np.random.default_rng(1)
    x = draw.integers(0, 8, 60).astype(float)
    y = np.exp(x) + draw.normal(0.0, 40.0, 60).round()
    assert rank_correlation(x, y) == pytest.approx(spearmanr(x, y).statistic, abs=1e-14)
    assert rank_correlation(x, np.exp(x)) == pytest.approx(1.0, abs=1e-15)
    assert np.isnan(rank_correlation(x, np.ones(60)))


def test_the_interval_of_a_rank_correlation_holds_it_as_often_as_it_says():
    """Samples of two normal quantities with a correlation of 0.5, whose rank correlation is 6/π asin(0.25)."""
    draw, true, held = np.random.default_rng(2), 6.0 / np.pi * np.arcsin(0.25), 0
    for _ in range(400):
        x, noise = draw.normal(size=(2, 50))
        low, high = rank_interval(rank_correlation(x, 0.5 * x + np.sqrt(0.75) * noise), 50)
        held += low <= true <= high
    assert held / 400 == pytest.approx(0.95, abs=0.03)
