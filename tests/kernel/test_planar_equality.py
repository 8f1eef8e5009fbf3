"""In the plane: the kernel's three coordinates a body against mbproj.dynamics' seven, joints open where that is one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from mbproj.arrays import Array
from mbproj.dynamics import constraint, gamma, generalised_force, jacobian, mass_matrix, pose_of, twist_of
from mbproj.integrate import InPlane
from mbproj.kernel import core
from mbproj.model import Plane, System, matrix_E, planar_reduction
from mbproj.scene import ProjectionSettings, read_scene
from tests.kernel.scenes import assembled, needs_kernel, parallelogram
from tests.model.planar_scenes import (
    CLOSED_ONLY,
    SCENES,
    Drawing,
    chain,
    planar_constraint,
    planar_gamma,
    planar_jacobian,
)
from tests.support import MECHANISMS, with_flywheels

pytestmark = needs_kernel
ROUND_OFF = 1e-13
FLAT = ("double_pendulum", "five_bar", "physical_pendulum", "planar_four_bar")
BUILD = {
    **{f"{name} 1": (lambda name=name: SCENES[name](Drawing(1))) for name in SCENES},
    **{f"{name} 2": (lambda name=name: SCENES[name](Drawing(2))) for name in SCENES},
    **{path.stem: (lambda path=path: read_scene(path)) for path in MECHANISMS if path.stem in FLAT},
    "long chain": lambda: chain(Drawing(3), ["revolute"] * 12),
    "parallelogram": parallelogram,
    **{f"with flywheels, {name} 1": (lambda name=name: with_flywheels(SCENES[name](Drawing(1)))) for name in SCENES},
}


def kind(name: str) -> str:
    """What is drawn, without the number of the drawing, and with flywheels or without."""
    return name.rsplit(", ", 1)[-1].rsplit(" ", 1)[0]


#: Those that are planar where their joints are open, too, and of these the ones without a row that is redundant outside
#: of the plane.
OPEN = [name for name in BUILD if kind(name) not in CLOSED_ONLY]
REDUNDANT_OUTSIDE = ("cylinder on a plane", "four-bar", "rods and a slot", "parallelogram")
REGULAR = [name for name in OPEN if kind(name) not in REDUNDANT_OUTSIDE]


class Case(NamedTuple):
    """A planar system, the kernel's view of it, and a state in the plane: p, u (3n,), and q, v, q'' at p'' = 0."""

    system: System
    plane: Plane
    flat: InPlane
    p: Array
    u: Array
    q: Array
    v: Array
    bias: Array
    closed: bool

    @property
    def y(self) -> Array:
        return np.hstack([self.p.reshape(-1, 3), self.u.reshape(-1, 3)])

    @property
    def columns(self) -> Array:
        """∂q/∂p, (7n, 3n)."""
        unit = np.eye(len(self.p))
        return self.plane.expand(np.tile(self.p, (len(self.p), 1)), unit, np.zeros_like(unit))[1].T


@pytest.fixture(scope="module", params=BUILD)
def case(request):
    """Open by a few hundredths of the size, but for those that are planar only where they are closed."""
    system, state = assembled(BUILD[request.param]())
    plane = planar_reduction(system, state.q)
    assert isinstance(plane, Plane)
    rng = np.random.default_rng(5)
    p = plane.reduce(state.q, state.v)[0]
    u = rng.normal(size=len(p)) * np.tile([system.length, system.length, 1.0], system.bodies)
    closed = kind(request.param) in CLOSED_ONLY
    if closed:
        C_p = planar_jacobian(plane, p)
        u = u - np.linalg.pinv(C_p) @ C_p @ u
    else:
        p = p + 0.03 * rng.normal(size=len(p)) * np.tile([system.length, system.length, 1.0], system.bodies)
    q, v, bias = plane.expand(p, u, np.zeros_like(u))
    return Case(system, plane, InPlane(core(), system, plane), p, u, q, v, bias, closed)


def condition(case: Case) -> float:
    """The condition of S = G W⁻¹ Gᵀ in the plane."""
    G = planar_jacobian(case.plane, case.p)
    return float(np.linalg.cond(G / weights(case) @ G.T)) if len(G) else 1.0


def weights(case: Case) -> Array:
    mass = np.repeat(case.plane.mass, 3)
    mass[2::3] = case.plane.inertia
    return mass


def assert_equal(found: Array, expected: Array, condition: float) -> None:
    """To round-off times the condition, relative to the largest number."""
    size = max(1.0, np.abs(expected).max(initial=0.0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUND_OFF * max(1.0, condition) * size)


def test_constraints_and_their_derivatives(case):
    """C, C', γ and G of the kernel's own primitives are those of mbproj.constraints on vectors (x, y, 0)."""
    equations, plane = case.flat.equations(), case.plane
    G = planar_jacobian(plane, case.p)
    for found, expected in (
        (equations.constraint(case.y), planar_constraint(plane, case.p)),
        (equations.jacobian(case.y).reshape(len(G), -1), G),
        (equations.constraint_velocity(case.y), G @ case.u),
        (equations.gamma(case.y), planar_gamma(plane, case.p, case.u)),
    ):
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * max(1.0, np.abs(expected).max(initial=0.0)))


def test_accelerations_are_those_of_the_full_equations_and_reactions_load_the_plane_alike(case):
    """q'' of Eq. 14; of λ the forces in the plane, as rows that hold the bodies in it may be redundant."""
    system, plane, number = case.system, case.plane, condition(case)
    pose = pose_of(case.q)
    twist = twist_of(pose, case.v)
    M, C_q = mass_matrix(system, pose), jacobian(system, pose)
    matrix = np.block([[M, C_q.T], [C_q, np.zeros((len(C_q), len(C_q)))]])
    rhs = np.concatenate([generalised_force(system, pose, twist), gamma(system, pose, twist)])
    solution, _, _, values = np.linalg.lstsq(matrix, rhs, rcond=1e-11)
    number = max(number, values[0] / values[values > 1e-11 * values[0]][-1])
    acceleration, own = case.flat.equations().accelerations(case.y)
    spread = case.columns @ acceleration.ravel() + case.bias
    assert_equal(spread, solution[: len(M)], number)
    in_plane = (C_q[system.bodies :] @ case.columns).T
    assert_equal(
        in_plane @ plane.joints.source.multipliers(own, system.joints.size),
        in_plane @ solution[len(M) + system.bodies :],
        number,
    )


@pytest.mark.parametrize("case", REGULAR, indirect=True)
def test_where_nothing_is_redundant_multipliers_in_the_plane_are_the_full_ones(case):
    system, pose = case.system, pose_of(case.q)
    twist, C_q = twist_of(pose, case.v), jacobian(system, pose)
    M, m = mass_matrix(system, pose), len(C_q)
    matrix = np.block([[M, C_q.T], [C_q, np.zeros((m, m))]])
    number = float(np.linalg.cond(matrix))
    assert number < 1e9
    own = case.flat.equations().accelerations(case.y)[1]
    full = np.linalg.solve(matrix, np.concatenate([generalised_force(system, pose, twist), gamma(system, pose, twist)]))
    assert_equal(own, case.plane.joints.source.rows(full[len(M) + system.bodies :]), number)


@pytest.mark.parametrize("case", OPEN, indirect=True)
@pytest.mark.parametrize("name", ["gopm", "gpopm"])
def test_one_exact_newton_correction_is_that_of_the_full_coordinates(case, name):
    """The shortest Δq of q = (r, Λ) in the metric, which stays in the plane: Δr and δθ = 2 n·E ΔΛ."""
    system, pose = case.system, pose_of(case.q)
    C_q, n = jacobian(system, pose), system.bodies
    metric = mass_matrix(system, pose) if name == "gpopm" else np.eye(7 * n)
    # Eq. 67 as least squares, for rows that may be redundant: [A C_qᵀ; C_q 0] (Δ, μ) = (0, -C).
    matrix = np.block([[metric, C_q.T], [C_q, np.zeros((len(C_q), len(C_q)))]])
    rhs = np.concatenate([np.zeros(7 * n), -constraint(system, pose)])
    solution, _, _, values = np.linalg.lstsq(matrix, rhs, rcond=1e-11)
    number = max(condition(case), values[0] / values[values > 1e-11 * values[0]][-1])
    change = solution[: 7 * n].reshape(-1, 7)
    turn = 2.0 * (matrix_E(case.q.reshape(-1, 7)[:, 3:]) @ change[:, 3:, None])[..., 0] @ case.plane.axes[:, 2]
    expected = np.column_stack([change[:, :3] @ case.plane.axes[:, :2], turn])
    moved = case.flat.equations(ProjectionSettings(method=name)).newton(case.y)
    step = moved[:, :3] - case.p.reshape(-1, 3)
    step[:, 2] = np.angle(np.exp(1j * step[:, 2]))
    assert np.abs(change[:, :3] @ case.plane.axes[:, 2]).max() <= ROUND_OFF * number
    assert_equal(step, expected, number)
    np.testing.assert_array_equal(moved[:, 3:], case.y[:, 3:])


def test_all_multipliers_of_a_sample_balance_the_forces(case):
    """Reactions out of the plane too: M q'' + C_qᵀ λ = Q at a state that is closed, with the λ that a run records."""
    system, plane, flat = case.system, case.plane, case.flat
    y = flat.equations().corrected(case.y)
    acceleration, carried = flat.equations().accelerations(y)
    block = {
        "t": np.zeros(1),
        "y": flat.layout.vector_of({"bodies": y.ravel()})[None],
        "acceleration": acceleration[None],
        "multipliers": carried[None],
        "step_size": np.zeros(1),
        "angles": np.zeros((1, plane.coordinates.size)),
    }
    sample = flat.samples(block, {})
    pose = pose_of(sample.q[0])
    C_q, force = jacobian(system, pose), generalised_force(system, pose, twist_of(pose, sample.v[0]))
    load = C_q[system.bodies :].T @ sample.multipliers[0]
    missing = force - mass_matrix(system, pose) @ sample.acceleration[0] - load
    Λ = sample.q[0].reshape(-1, 7)[:, 3:]
    left = missing.reshape(-1, 7)
    left[:, 3:] -= np.sum(left[:, 3:] * Λ, axis=1, keepdims=True) * Λ  # along Λ stand the norm rows
    assert np.abs(left).max() <= 1e-10 * max(1.0, np.abs(force).max(), np.abs(sample.multipliers).max(initial=0.0))
