"""The order that `verify` sees in errors: through the next power of the step, and never below what they show."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.studies.verify import case


@pytest.mark.parametrize("order", [1, 4, 8])
def test_an_order_is_seen_through_the_next_power_of_the_step(order):
    """Steps that begin coarse show 3 less at first, as a bicycle does."""
    steps = np.array(case.STEPS[:10], dtype=float)
    errors = 2.0 * steps**-order / (1.0 + 4.0 / steps) ** 3
    assert -np.diff(np.log2(errors))[0] / np.diff(np.log2(steps))[0] < order - 1.5
    found = case.order_of(steps[-6:], errors[-6:])
    assert found is not None and abs(found.value - order) < 0.3


def test_an_order_is_not_bent_below_what_is_seen():
    """The dopri5 of locomotive.yaml: coarse steps show more than 5, and a bent line would fall to 4.3."""
    errors = np.array([1.14e-08, 2.1e-09, 2.31e-10, 5.34e-11, 7.59e-12, 1.96e-12])
    found = case.order_of(np.array(case.STEPS[1:7]), errors)
    assert found is not None and found.value == pytest.approx(5.16, abs=0.01)
