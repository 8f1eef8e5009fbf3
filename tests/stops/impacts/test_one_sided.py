"""One-sided conditions: complementarity for any rows, and the energy of impacts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.kernel.scenes import needs_kernel
from tests.laws import one_sided, strike

pytestmark = needs_kernel


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


@given(st.integers(0, 10_000), st.integers(1, 6), st.integers(1, 6), st.floats(0.0, 1.0))
def test_equal_restitutions_create_no_energy(seed, rows, freedoms, e):
    rng = np.random.default_rng(seed)
    speeds = rng.normal(size=freedoms)
    N = rng.normal(size=(rows, freedoms))
    N *= -np.sign(N @ speeds)[:, None]  # all are struck
    found = strike("newton", N, speeds, np.full(rows, e))
    energy = 0.5 * speeds @ speeds
    assert found.lost >= -1e-9 * energy
    assert found.taken.sum() == pytest.approx(found.lost, abs=1e-8 * energy)


def test_unequal_restitutions_may_create_energy_and_that_is_seen():
    """Three planes whose normals nearly balance: one asks for what the others leave hardly room for."""
    N = np.array(
        [[0.7611379, -0.54606341, -0.34997693], [0.42011854, 0.89911651, -0.12284096], [-0.74977728, -0.6, 0.27846724]]
    )
    speeds = np.array([0.23854459, 0.72664687, -0.64426765])
    found = strike("newton", N, speeds, [0.0, 0.0, 1.0])
    assert found.lost < -1.0
