"""One-sided conditions: complementarity for any rows, and the impact of a loop against one coordinate."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.dynamics.contact.complementarity import one_sided


@given(st.integers(0, 10_000), st.integers(1, 8), st.integers(1, 6))
def test_pushes_and_openings_are_complementary(seed, rows, freedoms):
    rng = np.random.default_rng(seed)
    N, speeds = rng.normal(size=(rows, freedoms)), rng.normal(size=freedoms)
    N[rows // 2] = N[0]  # rows may depend on each other
    b = N @ speeds
    z = one_sided(N, b)
    assert z is not None  # x = -speeds fulfils all
    opening = N @ (N.T @ z) + b
    size = np.linalg.norm(N, axis=1) * np.linalg.norm(speeds)
    assert z.min() >= 0.0
    assert (opening / size).min() > -1e-9
    assert np.abs(z * opening).max() < 1e-8 * (speeds @ speeds)


def test_the_push_is_unique_in_what_it_does():
    """Two equal rows share one push, in any way; the change is that of one."""
    N = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    z = one_sided(N, np.array([-2.0, -2.0, 3.0]))
    assert N.T @ z == pytest.approx([2.0, 0.0])
    assert z[2] == 0.0


@pytest.mark.parametrize("N", [np.zeros((1, 1)), np.array([[1.0], [-1.0]])])
def test_what_cannot_open_has_no_push(N):
    assert one_sided(N, -np.ones(len(N))) is None
