"""The kernel's own sine and cosine, for one double and for four at once."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.functions.program import TIME, Op, Program, apply, variable
from mbproj.functions.program_set import flatten
from mbproj.kernel import core
from mbproj.kernel.models import programs
from tests.kernel.scenes import needs_kernel

pytestmark = needs_kernel
#: Units in the last place: the polynomials' and the last rounding; beside a multiple of π/2 the reduction's, too.
MOST_OFF, BESIDE = 0.9, 1.1


def values(x: np.ndarray) -> np.ndarray:
    """Sine and cosine of each number as functions of a scene have them, (2, n)."""
    own = core().Programs(functions=programs(flatten([Program(apply(op, variable(TIME))) for op in (Op.SIN, Op.COS)])))
    return np.array([[own.run(number, float(t), 0.0, 0.0)[0] for t in x] for number in (0, 1)])


def off(x: np.ndarray) -> float:
    """The largest error, in units in the last place of what is right."""
    right = np.array([np.sin(x.astype(np.longdouble)), np.cos(x.astype(np.longdouble))])
    return float((np.abs(values(x) - right) / np.spacing(np.abs(right).astype(float))).max())


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="needs numbers longer than doubles")
def test_they_are_right_to_the_last_place_but_for_rounding():
    rng = np.random.default_rng(0)
    for size in (1e-9, 0.8, 3.0, 50.0, 1e4, 5e5):
        assert off(rng.uniform(-size, size, 2000)) < MOST_OFF
    turns = np.concatenate([np.arange(1, 500), rng.integers(500, 300_000, 500)]) * (0.5 * np.pi)
    assert off(np.concatenate([turns, np.nextafter(turns, 0.0), np.nextafter(turns, 1e9)])) < BESIDE


def test_beyond_its_reduction_they_are_those_of_the_standard_library():
    x = np.random.default_rng(1).uniform(1e6, 1e15, 500)
    np.testing.assert_allclose(values(x), [np.sin(x), np.cos(x)], rtol=0, atol=2e-16)
    assert np.isnan(values(np.array([np.inf, np.nan]))).all()


def test_zeros_keep_their_signs():
    sine, cosine = values(np.array([0.0, -0.0]))
    assert np.signbit(sine).tolist() == [False, True] and cosine.tolist() == [1.0, 1.0]
