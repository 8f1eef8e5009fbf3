"""The gradient of a function has a symmetric derivative. A knife edge's has not, and its derivatives are its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.constraints import PRIMITIVES
from mbproj.constraints.coupling import Coupling
from mbproj.constraints.curves.face import Face, FacePlace, FaceSlip
from mbproj.constraints.curves.in_space import BesideFirst, BesideSecond, SpaceArc
from mbproj.constraints.curves.profile import Arc, Lap, Profile
from mbproj.constraints.curves.two_curves import Gap, PlaceOnFirst, PlaceOnSecond, SlipOfTwo
from mbproj.constraints.primitive import Primitive
from mbproj.constraints.rope import Rope
from mbproj.dynamics import second_derivatives, third_derivatives
from mbproj.joints import thread
from mbproj.model import Binding, bind, bindings
from tests.kernel.scenes import needs_kernel
from tests.support import ON_CURVES, Recorder, made

STEP = 1e-30


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


OTHERS = (Coupling, Profile, Arc, Lap, Face, FacePlace, FaceSlip, Rope, Gap, PlaceOnFirst, PlaceOnSecond, SlipOfTwo)
OTHERS += (BesideFirst, BesideSecond, SpaceArc)
EACH = {name: made(kind) for name, kind in PRIMITIVES.items() if kind not in OTHERS}
EACH |= {"coupling": Coupling(("along", "angle"), *thread(0.7)), "knife_edge": KnifeEdge(), **ON_CURVES}


def bent(primitive, x):
    """∂g/∂x by the complex step, (k, rows, 3s, 3s)."""
    size = x[0].size
    steps = 1j * STEP * np.eye(size).reshape(size, 1, -1, 3)
    found = np.moveaxis(primitive.gradient(x + steps).imag / STEP, 0, -1)
    return found.reshape(len(x), primitive.rows, size, size)


@pytest.mark.parametrize("name", EACH)
def test_a_gradient_is_that_of_a_function_where_it_says_so(name):
    primitive = EACH[name]
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
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
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
