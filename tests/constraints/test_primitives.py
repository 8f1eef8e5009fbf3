"""Every primitive: its gradient and curvature against the complex step on random vectors."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.constraints import PRIMITIVES

STEP = 1e-30


@pytest.fixture(params=sorted(PRIMITIVES))
def primitive(request):
    return PRIMITIVES[request.param]


@pytest.fixture
def vectors(primitive):
    """Points and vectors and their velocities, three instances: (3, s, 3) each."""
    return np.random.default_rng(7).normal(size=(2, 3, len(primitive.slots), 3))


def test_value_has_the_declared_rows(primitive, vectors):
    assert primitive.value(vectors[0]).shape == (3, primitive.rows)


def test_gradient_is_the_derivative_of_the_value(primitive, vectors):
    x, _ = vectors
    gradient = primitive.gradient(x)
    for slot in range(x.shape[1]):
        for axis in range(3):
            moved = x.astype(complex)
            moved[:, slot, axis] += 1j * STEP
            np.testing.assert_allclose(
                gradient[:, :, slot, axis], primitive.value(moved).imag / STEP, rtol=1e-13, atol=1e-13
            )


def test_curvature_is_the_derivative_of_the_rate_along_a_straight_motion(primitive, vectors):
    x, x_dot = vectors

    def rate(at):
        return np.einsum("krsa,ksa->kr", primitive.gradient(at), x_dot)

    derivative = rate(x + 1j * STEP * x_dot).imag / STEP
    np.testing.assert_allclose(primitive.curvature(x, x_dot), derivative, rtol=1e-12, atol=1e-12)


def test_leading_axes_are_samples(primitive, vectors):
    x, x_dot = vectors
    twice = np.stack([x, 2.0 * x])
    np.testing.assert_array_equal(primitive.value(twice)[1], primitive.value(2.0 * x))
    np.testing.assert_array_equal(primitive.gradient(twice)[1], primitive.gradient(2.0 * x))
    np.testing.assert_array_equal(
        primitive.curvature(twice, np.stack([x_dot, x_dot]))[1], primitive.curvature(2.0 * x, x_dot)
    )


def test_angle_counts_from_x_towards_y():
    angle = 2.5
    x = np.array([[[1.0, 0, 0], [0, 1, 0], [np.cos(angle), np.sin(angle), 0.3]]])
    np.testing.assert_allclose(PRIMITIVES["angle"].value(x), [[angle]], rtol=1e-15)


def test_along_is_the_displacement_from_point_1_to_point_2():
    x = np.array([[[0.0, 0, 1], [1, 1, 1], [5, 5, 4]]])
    np.testing.assert_array_equal(PRIMITIVES["along"].value(x), [[3.0]])
