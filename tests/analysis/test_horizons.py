"""Horizons of known errors, and growth laws that are known."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.results.analysis.trust import growth, horizons, settled

TIME = np.linspace(0.0, 10.0, 1001)


def test_horizons_of_an_exponential_are_where_it_crosses():
    error = 1e-9 * np.exp(2.0 * TIME)[:, None]
    found = horizons(TIME, error, 0.01 * error, np.array([1e-6, 1e-3, 1.0]))
    crossing = np.log(np.array([1e3, 1e6, 1e9])) / 2.0
    np.testing.assert_allclose(found.time[0, :2], crossing[:2], atol=0.01)
    assert found.time[0, 2] == np.inf
    assert np.all(found.low <= found.time)
    assert np.all(found.time <= found.high)
    assert np.all(found.high[0, :2] - found.low[0, :2] < 0.02)
    assert settled(found.low, found.high, TIME).all()


def test_an_error_within_its_uncertainty_leaves_the_horizon_open():
    error = np.full((1001, 1), 1e-6)
    found = horizons(TIME, error, 1e-7 * TIME[:, None], np.array([1.5e-6]))
    assert found.low[0, 0] == pytest.approx(5.0, abs=0.011)
    assert (found.time[0, 0], found.high[0, 0]) == (np.inf, np.inf)
    assert not settled(found.low, found.high, TIME).any()


def test_what_is_not_known_can_exceed_any_limit_but_need_not():
    error = np.where(TIME < 4.0, 1e-9, np.nan)[:, None]
    found = horizons(TIME, error, np.zeros((1001, 1)), np.array([1e-3]))
    assert found.low[0, 0] == pytest.approx(4.0)
    assert found.high[0, 0] == np.inf


@pytest.mark.parametrize(("law", "error"), [("exponential", 1e-9 * np.exp(1.3 * TIME)), ("power", 1e-7 * TIME**2.5)])
def test_growth_laws_are_told_apart_under_oscillations(law, error):
    found = growth(TIME, error * (1.0 + 0.5 * np.sin(9.0 * TIME)), np.zeros_like(TIME), 1e3)
    assert found.law == law
    if law == "exponential":
        assert found.rate == pytest.approx(1.3, rel=0.05)
    else:
        assert found.power == pytest.approx(2.5, rel=0.1)


def test_growth_stops_counting_where_the_error_is_as_large_as_the_motion():
    error = np.minimum(1e-6 * np.exp(3.0 * TIME), 2.0)
    assert growth(TIME, error, np.zeros_like(TIME), 5.0).rate == pytest.approx(3.0, rel=1e-3)


def test_an_error_that_does_not_grow_or_is_not_known_has_no_law():
    for error, unsure in ((np.full_like(TIME, 1e-9), 0.0), (1e-9 * np.exp(TIME), 1.0)):
        found = growth(TIME, error, np.full_like(TIME, unsure), 1.0)
        assert found.law == ""
        assert np.isnan(found.rate)
        assert np.isnan(found.power)
