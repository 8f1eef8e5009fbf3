"""The front by its definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.studies.tradeoff import cheapest, excess, front

VALUES = st.sampled_from([0.0, 1.0, 2.0, 3.0, 4.0, float("inf")]) | st.floats(min_value=1e-12, max_value=1e12)
CLOUDS = st.lists(st.tuples(VALUES, VALUES), max_size=30)


def dominates(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return a[0] <= b[0] and a[1] <= b[1] and a != b


@given(CLOUDS)
def test_front(cloud):
    costs, errors = [each[0] for each in cloud], [each[1] for each in cloud]
    found = front(costs, errors)
    on = [cloud[index] for index in found]
    finite = [each for each in cloud if np.isfinite(each).all()]
    assert set(on) == {each for each in finite if not any(dominates(other, each) for other in finite)}
    assert on == sorted(on)
    assert len(set(on)) == len(on)
    assert [error for _, error in on] == sorted((error for _, error in on), reverse=True)


@given(CLOUDS.filter(bool), st.floats(min_value=1e-12, max_value=1e12))
def test_cheapest_and_excess(cloud, limit):
    costs, errors = (np.array([each[axis] + 1e-3 for each in cloud]) for axis in (0, 1))
    able = costs[(errors <= limit) & np.isfinite(costs)]
    index = cheapest(costs, errors, limit)
    assert (index is None) == (len(able) == 0)
    if index is not None:
        assert errors[index] <= limit
        assert costs[index] == able.min()
    ratios = excess(costs, errors)
    assert np.all(ratios >= 1.0)
    assert ratios[front(costs, errors)] == pytest.approx(1.0)
