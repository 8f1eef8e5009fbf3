"""Primitives of constraints: their gradients and curvatures against the complex step, and which of them are
derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import read_scene_text, settings_to_run, simulate
from mbproj.equations.derivatives import second_derivatives, third_derivatives
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.coupling import Coupling
from mbproj.joints.primitives.rope import Rope
from mbproj.joints.primitives.table import PRIMITIVES, name_of
from mbproj.joints.table import PRIMITIVE_TYPES, mesh, thread
from mbproj.model.primitive_set import Binding, bind, bindings
from tests.kernel.scenes import needs_kernel
from tests.support import ON_CURVES, Recorder, assembled, made

# Every primitive: its gradient and curvature against the complex step on random vectors.

STEP = 1e-30


COUPLINGS = {
    "screw": Coupling(("along", "angle"), *thread(0.7)),
    "gear": Coupling(("angle", "angle"), *mesh((20.0, -35.0))),
    "three": Coupling(("angle", "along", "angle"), (0.3, -1.0, 0.2), 0.1),
}
#: What `made` cannot make.
OTHERS = (Coupling, Rope)
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
EACH_PRIMITIVE = {
    **{name: made(kind) for name, kind in PRIMITIVES.items() if kind not in OTHERS},
    **COUPLINGS,
    **ON_CURVES,
    **ROPES,
}


@pytest.fixture(params=sorted(EACH_PRIMITIVE))
def primitive(request):
    return EACH_PRIMITIVE[request.param]


@pytest.fixture
def vectors(primitive):
    """Points and vectors and their velocities, three instances: (3, s, 3) each."""
    return np.random.default_rng(7).normal(size=(2, 3, len(primitive.slots), 3))


def test_value_has_the_declared_rows(primitive, vectors):
    assert primitive.value(vectors[0]).shape == (3, primitive.rows)


def test_the_table_says_the_unit_of_a_primitive(primitive):
    assert PRIMITIVE_TYPES[name_of(type(primitive))].unit in (primitive.unit, "")  # a coupling's follows from its parts


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


# The gradient of a function has a symmetric derivative. A knife edge's has not, and its derivatives are its own.


class KnifeEdge(Primitive):
    """A row of velocities alone, n·p' = 0: the point p does not slide along the vector n."""

    slots = ("vector", "point")
    rows = 1
    unit = "m"
    integrable = False

    def value(self, x):
        return np.zeros((*x.shape[:-2], 1))

    def gradient(self, x):
        return np.stack([np.zeros_like(x[..., 0, :]), x[..., 0, :]], axis=-2)[..., None, :, :]

    def curvature(self, x, x_dot):
        return np.sum(x_dot[..., 0, :] * x_dot[..., 1, :], axis=-1)[..., None]


EACH_FORCE = {name: made(kind) for name, kind in PRIMITIVES.items() if kind not in OTHERS}
EACH_FORCE |= {"coupling": Coupling(("along", "angle"), *thread(0.7)), "knife_edge": KnifeEdge(), **ON_CURVES}


def bent(primitive, x):
    """∂g/∂x by the complex step, (k, rows, 3s, 3s)."""
    size = x[0].size
    steps = 1j * STEP * np.eye(size).reshape(size, 1, -1, 3)
    found = np.moveaxis(primitive.gradient(x + steps).imag / STEP, 0, -1)
    return found.reshape(len(x), primitive.rows, size, size)


@pytest.mark.parametrize("name", EACH_FORCE)
def test_a_gradient_is_that_of_a_function_where_it_says_so(name):
    primitive = EACH_FORCE[name]
    x = np.random.default_rng(3).normal(size=(4, len(primitive.slots), 3))
    found = bent(primitive, x)
    skew = np.abs(found - np.swapaxes(found, -1, -2)).max()
    assert (skew < 1e-13 * max(1.0, np.abs(found).max())) == primitive.integrable


def test_derivatives_of_a_knife_edge_are_those_of_its_gradient():
    x, x_dot = np.random.default_rng(4).normal(size=(2, 3, 2, 3))
    edge = KnifeEdge()
    np.testing.assert_allclose(second_derivatives(edge, x), bent(edge, x), atol=1e-15)
    np.testing.assert_allclose(third_derivatives(edge, x, x_dot), 0.0, atol=1e-13)


class Bent(KnifeEdge):
    """The same, less the more the line from the origin to p points along n: its derivatives go on."""

    def gradient(self, x):
        n, p = x[..., 0, :], x[..., 1, :]
        along = np.sin(np.sum(n * p, axis=-1))[..., None]
        return np.stack([np.zeros_like(n), along * n], axis=-2)[..., None, :, :]


def test_third_derivatives_follow_the_gradient():
    x, x_dot = np.random.default_rng(5).normal(size=(2, 3, 2, 3))
    edge, h = Bent(), 1e-4
    ahead, behind = (bent(edge, x + sign * h * x_dot) @ x_dot.reshape(3, 1, -1, 1) for sign in (1.0, -1.0))
    expected = ((ahead - behind) / (2.0 * h))[..., 0]
    found = third_derivatives(edge, x, x_dot)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


SLED = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1, integrator: dop853, tolerance: 1e-12, output_step: 0.1}
bodies: {sled: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0, 0, 0]}}
joints:
  table:
    type: planar
    bodies: [ground, sled]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    speed: {displacement_x: 3, angle: 2}
"""


@needs_kernel
def test_a_primitive_without_a_kernel_form_runs_in_the_full_formulation_and_says_so():
    """A sled on an edge through its centre of mass keeps its speed and turns evenly: it goes round a circle."""
    scene = read_scene_text(SLED)
    system, state = assembled(scene)
    forward = state.v[:3] / np.linalg.norm(state.v[:3])
    across = np.cross([0.0, 0.0, 1.0], forward)
    edge = Binding(KnifeEdge(), 0, ((0, 2, across), (0, 2, np.zeros(3))))
    system = replace(system, joints=bind([*bindings(system.joints), edge]))
    record = Recorder()
    report = simulate(system, state, settings_to_run(scene), record)
    assert report.formulation == "full"
    assert "the primitive 'KnifeEdge' exists in the full formulation only" in report.why
    t = record["time"][:, None]
    circle = 1.5 * (np.sin(2.0 * t) * forward + (1.0 - np.cos(2.0 * t)) * across)
    np.testing.assert_allclose(record["bodies/position"][:, 0], circle, atol=1e-9)
