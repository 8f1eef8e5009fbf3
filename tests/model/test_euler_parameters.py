"""Identities of Euler parameters, for any Λ (hypothesis)."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj.model.euler_parameters import E_times_L, matrix_E, matrix_L, product, rotation_matrix, turning

NUMBERS = st.floats(-2.0, 2.0, allow_subnormal=False)
QUATERNIONS = st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS).filter(lambda q: sum(x * x for x in q) > 0.01).map(np.array)


@given(QUATERNIONS)
@settings(derandomize=True, deadline=None)
def test_L_and_E_are_orthogonal_to_their_parameters(quaternion):
    norm2 = quaternion @ quaternion
    for matrix in (matrix_L(quaternion), matrix_E(quaternion)):
        np.testing.assert_allclose(matrix @ quaternion, 0.0, atol=1e-15 * norm2)
        np.testing.assert_allclose(matrix @ matrix.T, norm2 * np.eye(3), atol=4e-15 * norm2)


@given(QUATERNIONS)
@settings(derandomize=True, deadline=None)
def test_A_is_the_squared_norm_times_a_rotation(quaternion):
    norm2 = quaternion @ quaternion
    A = rotation_matrix(quaternion)
    np.testing.assert_allclose(A @ A.T, norm2**2 * np.eye(3), atol=1e-14 * norm2**2)
    assert np.linalg.det(A) > 0.0


@given(QUATERNIONS, QUATERNIONS)
@settings(derandomize=True, deadline=None)
def test_rate_of_A_is_twice_E_times_the_rate_of_L(quaternion, rate):
    derivative = rotation_matrix(quaternion + 1e-30j * rate).imag / 1e-30
    np.testing.assert_allclose(2.0 * matrix_E(quaternion) @ matrix_L(rate).T, derivative, atol=1e-14)


@given(QUATERNIONS, NUMBERS, NUMBERS, NUMBERS)
@settings(derandomize=True, deadline=None)
def test_body_rates_turn_body_vectors(quaternion, x, y, z):
    """d/dt(A s) = A (ω × s) with ω = 2 L Λ' for a unit Λ and Λ'ᵀΛ = 0."""
    unit = quaternion / np.linalg.norm(quaternion)
    omega, s = np.array([x, y, z]), np.array([0.3, -0.2, 0.9])
    rate = 0.5 * matrix_L(unit).T @ omega
    derivative = 2.0 * matrix_E(unit) @ matrix_L(rate).T @ s
    np.testing.assert_allclose(derivative, rotation_matrix(unit) @ np.cross(omega, s), atol=1e-14)
    np.testing.assert_allclose(2.0 * matrix_L(unit) @ rate, omega, atol=1e-14)


@given(QUATERNIONS, QUATERNIONS)
@settings(derandomize=True, deadline=None)
def test_entry_by_entry_is_as_with_the_matrices(first, second):
    np.testing.assert_allclose(turning(first, second), 2.0 * matrix_L(first) @ second, atol=1e-14)
    turns = rotation_matrix(first) @ rotation_matrix(second)
    np.testing.assert_allclose(rotation_matrix(product(first, second)), turns, atol=1e-12)


@given(st.lists(st.tuples(QUATERNIONS, QUATERNIONS), min_size=1, max_size=3))
@settings(derandomize=True, deadline=None)
def test_samples_entry_by_entry_are_as_with_the_matrices(pairs):
    """Of three bodies alike, one sample after another."""
    first, second = (np.array([[pair[side]] * 3 for pair in pairs]) for side in (0, 1))
    expected = matrix_E(first) @ np.swapaxes(matrix_L(second), -1, -2)
    np.testing.assert_allclose(E_times_L(first, second), expected, atol=1e-14)


def test_parameters_of_a_turn_about_z():
    angle = 0.7
    A = rotation_matrix(np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)]))
    expected = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    np.testing.assert_allclose(A, expected, atol=1e-15)
