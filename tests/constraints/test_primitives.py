"""Every primitive: its gradient and curvature against the complex step on random vectors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj.constraints import PRIMITIVES
from mbproj.constraints.coupling import Coupling
from mbproj.constraints.curves.face import Face, FacePlace, FaceSlip
from mbproj.constraints.curves.in_space import BesideFirst, BesideSecond, SpaceArc
from mbproj.constraints.curves.profile import Arc, Lap, Profile
from mbproj.constraints.curves.two_curves import Gap, PlaceOnFirst, PlaceOnSecond, SlipOfTwo
from mbproj.constraints.rope import Rope
from mbproj.joints import mesh, thread
from tests.support import ON_CURVES, made

STEP = 1e-30


COUPLINGS = {
    "screw": Coupling(("along", "angle"), *thread(0.7)),
    "gear": Coupling(("angle", "angle"), *mesh((20.0, -35.0))),
    "three": Coupling(("angle", "along", "angle"), (0.3, -1.0, 0.2), 0.1),
}
OTHERS = (Coupling, Profile, Arc, Lap, Face, FacePlace, FaceSlip, Rope, Gap, PlaceOnFirst, PlaceOnSecond, SlipOfTwo)
OTHERS += (BesideFirst, BesideSecond, SpaceArc)
#: Over a point, two sheaves and a drum; and with the angle of a drum.
ROPE = Rope((0.0, 0.005, -0.008, 0.01), (0.3, 1.0, -2.0), (1.0, 1.0, 1.0), (-0.005, 0.013, -0.018), 0.02)
#: What has slipped on its first sheave, and what lies there.
SLIP = replace(ROPE, by_length=(0.5, -0.5, -0.5), by_angle=(-0.0025, -0.0065, 0.009))
LYING = Rope((0.0, 0.005, -0.008), (0.3, 1.0), (0.0, 0.0), (-0.005, 0.005))
ROPES = {
    "rope": ROPE,
    "slip of a rope": SLIP,
    "rope on a sheave": LYING,
    "wound rope": Coupling(("rope", "angle"), (1.0, 0.1), 0.2, other=ROPE),
}
EACH = {
    **{name: made(kind) for name, kind in PRIMITIVES.items() if kind not in OTHERS},
    **COUPLINGS,
    **ON_CURVES,
    **ROPES,
}


@pytest.fixture(params=sorted(EACH))
def primitive(request):
    return EACH[request.param]


@pytest.fixture
def vectors(primitive):
    """Points and vectors and their velocities, three instances: (3, s, 3) each."""
    return np.random.default_rng(7).normal(size=(2, 3, len(primitive.slots), 3))


def test_value_has_the_declared_rows(primitive, vectors):
    assert primitive.value(vectors[0]).shape == (3, primitive.rows)


def test_gradient_is_the_derivative_of_the_value(primitive, vectors):
    x, _ = vectors
    gradient = primitive.gradient(x)
    if not primitive.integrable:
        assert not primitive.value(x).any()
        return
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


def test_rates_and_forces_are_products_with_the_gradient(primitive, vectors):
    x, x_dot = vectors
    gradient = primitive.gradient(x)
    np.testing.assert_allclose(primitive.rate(x, x_dot), np.einsum("krsa,ksa->kr", gradient, x_dot), atol=1e-13)
    multipliers = np.random.default_rng(8).normal(size=(3, primitive.rows))
    expected = np.einsum("krsa,kr->ksa", gradient, multipliers)
    np.testing.assert_allclose(primitive.forces(x, multipliers), expected, atol=1e-13)


def test_leading_axes_are_samples(primitive, vectors):
    x, x_dot = vectors
    twice = np.stack([x, 2.0 * x])
    np.testing.assert_array_equal(primitive.value(twice)[1], primitive.value(2.0 * x))
    np.testing.assert_array_equal(primitive.gradient(twice)[1], primitive.gradient(2.0 * x))
    same = np.stack([x_dot, x_dot])
    np.testing.assert_array_equal(primitive.rate(twice, same)[1], primitive.rate(2.0 * x, x_dot))
    np.testing.assert_array_equal(primitive.curvature(twice, same)[1], primitive.curvature(2.0 * x, x_dot))
    multipliers = np.random.default_rng(8).normal(size=(2, 3, primitive.rows))
    forces = primitive.forces(twice, multipliers)
    np.testing.assert_array_equal(forces[1], primitive.forces(2.0 * x, multipliers[1]))


def test_angle_counts_from_x_towards_y():
    angle = 2.5
    x = np.array([[[1.0, 0, 0], [0, 1, 0], [np.cos(angle), np.sin(angle), 0.3]]])
    np.testing.assert_allclose(PRIMITIVES["angle"]().value(x), [[angle]], rtol=1e-15)


def test_along_is_the_displacement_from_point_1_to_point_2():
    x = np.array([[[0.0, 0, 1], [1, 1, 1], [5, 5, 4]]])
    np.testing.assert_array_equal(PRIMITIVES["along"]().value(x), [[3.0]])


def test_distance_is_a_length_not_its_square():
    x = np.array([[[1.0, 2, 3], [1, 5, 7]]])
    np.testing.assert_array_equal(PRIMITIVES["distance"]().value(x), [[5.0]])


@pytest.mark.parametrize("turns", [-1.75, -0.2, 0.0, 0.3, 1.4, 12.3])
def test_a_screw_advances_its_pitch_a_turn(turns):
    """z1, p1, p2 of the displacement, x1, y1, x2 of the angle: on the thread the row is zero, whatever the turn."""
    screw = Coupling(("along", "angle"), *thread(0.25))
    angle = 2.0 * np.pi * turns
    turned = [np.cos(angle), np.sin(angle), 0.0]
    x = np.array([[[0.0, 0, 1], [0, 0, 0], [0, 0, 0.25 * turns], [1, 0, 0], [0, 1, 0], turned]])
    np.testing.assert_allclose(screw.value(x), 0.0, atol=1e-15)
    x[0, 2, 2] += 0.01
    np.testing.assert_allclose(screw.value(x), 0.01, rtol=1e-12)


@pytest.mark.parametrize("teeth", [(20.0, 40.0), (20.0, -35.0), (17.0, 5.0)])
def test_gears_mesh_over_any_number_of_turns(teeth):
    gear = Coupling(("angle", "angle"), *mesh(teeth))
    for first in np.linspace(-20.0, 20.0, 41):
        second = -first * teeth[0] / teeth[1]
        vectors = [[1.0, 0, 0], [0, 1, 0], [np.cos(first), np.sin(first), 0]]
        vectors += [[1.0, 0, 0], [0, 1, 0], [np.cos(second), np.sin(second), 0]]
        np.testing.assert_allclose(gear.value(np.array([vectors])), 0.0, atol=1e-13)
