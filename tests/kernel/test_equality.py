"""The formulations are one where joints are closed, and the kernel does what mbproj.equations does, also by penalty."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from mbproj.base.arrays import Array
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.constraints import constraint, constraint_velocity, gamma, jacobian
from mbproj.equations.forces import applied, generalised
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.of_motion import SOLVERS, generalised_force, mass_matrix
from mbproj.kernel import core
from mbproj.model.euler_parameters import matrix_E, matrix_L
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.model.system import System
from mbproj.motion.formulations.reduced import InPlane, space_acceleration
from mbproj.motion.projection import make_method
from mbproj.scene.scene import read_scene
from tests.kernel.scenes import SCENES, Case, loops, needs_kernel, opened, parallelogram, star, tree
from tests.model.planar_scenes import CLOSED_ONLY, Drawing, chain, planar_constraint, planar_gamma, planar_jacobian
from tests.model.planar_scenes import SCENES as PLANAR_SCENES
from tests.support import MECHANISMS, assembled, with_flywheels

pytestmark = needs_kernel


# Rows of the full formulation in tangent coordinates, as the reduced one has them.


def tangent_jacobian(system: System, q: Array) -> Array:
    """G of the joints' rows in (δr, δθ global), (m, n, 6): C_Λ = 2 G_θ E at unit Λ, but for the radial part."""
    C_q = jacobian(system, pose_of(q))[system.bodies :].reshape(-1, system.bodies, 7)
    turning = 0.5 * np.einsum("mnp,nip->mni", C_q[..., 3:], matrix_E(q.reshape(-1, 7)[:, 3:]))
    return np.concatenate([C_q[..., :3], turning], axis=-1)


# At states with |Λ| = 1 and ΛᵀΛ' = 0, joints open, the formulations are one: design, section 3.

#: What round-off may be, times the condition of S = G W⁻¹ Gᵀ; the design allows a hundred times more.
ROUND_OFF = 1e-13
METHODS = ["gopm", "gpopm"]


@pytest.fixture(scope="module", params=SCENES)
def case(request):
    return opened(SCENES[request.param]())


def condition(system: System, q: Array, *, mass: bool = True) -> float:
    """The condition of S with the masses, or the coordinates, as weights."""
    Λ = q.reshape(-1, 7)[:, 3:]
    A = matrix_E(Λ) @ np.swapaxes(matrix_L(Λ), -1, -2)
    G = tangent_jacobian(system, q)
    weights = np.zeros((system.bodies, 6, 6))
    weights[:, :3, :3] = np.eye(3) * (system.mass[:, None, None] if mass else 1.0)
    weights[:, 3:, 3:] = A @ system.inertia @ np.swapaxes(A, -1, -2) if mass else 0.25 * np.eye(3)
    return float(np.linalg.cond(np.einsum("mni,nij,knj->mk", G, np.linalg.inv(weights), G))) if len(G) else 1.0


def assert_equal(found: Array, expected: Array, condition: float) -> None:
    """To round-off times the condition, relative to the largest number."""
    size = max(1.0, np.abs(expected).max(initial=0.0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUND_OFF * max(1.0, condition) * size)


def test_constraints_and_their_derivatives(case):
    """C, C', γ and G of the kernel's own primitives are those of mbproj.joints.primitives.table."""
    system, n = case.system, case.system.bodies
    pose, equations = pose_of(case.q), case.reduced.equations()
    twist = twist_of(pose, case.v)
    at, rate = (part.reshape(-1, 7).copy() for part in (case.q, case.v))
    at[:, :3], at[:, 3:] = 0.0, -np.sum(rate[:, 3:] ** 2, axis=1, keepdims=True) * at[:, 3:]  # Λ'' without ω'
    for found, expected in (
        (equations.constraint(case.y), constraint(system, pose)[n:]),
        (equations.constraint_velocity(case.y), constraint_velocity(system, pose, twist)[n:]),
        (equations.gamma(case.y), (gamma(system, pose, twist) - jacobian(system, pose) @ at.ravel())[n:]),
        (equations.jacobian(case.y), tangent_jacobian(system, case.q)),
    ):
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * max(1.0, np.abs(expected).max(initial=0.0)))
    if system.at_positions.joints.size:
        assert np.abs(equations.constraint(case.y)).max() > 1e-4 * system.length  # open indeed


def test_accelerations_and_multipliers_are_those_of_the_full_equations(case):
    system, q, v = case.system, case.q, case.v
    pose = pose_of(q)
    twist = twist_of(pose, v)
    force = generalised_force(system, pose, twist)
    if not system.forces.is_empty:
        loads = applied(Instant(system, pose, twist, 0.0, coordinate_values(system, pose)))
        force = force + generalised(pose, loads.force, loads.torque)
    expected, multipliers = SOLVERS["bordered"](
        mass_matrix(system, pose), jacobian(system, pose), force, gamma(system, pose, twist)
    )
    acceleration, own = case.reduced.equations().accelerations(case.y)
    number = condition(system, q)
    assert number < 1e8
    assert_equal(space_acceleration(case.y[None], acceleration[None])[0], expected, number)
    assert_equal(own, multipliers[system.bodies :], number)


def test_smallest_multipliers_of_many_states_are_those_of_each(case):
    """To the bit, whatever stands before; where no row is redundant they are the multipliers, and not numbers where the
    accelerations are not unique, as where all bodies have come to one point."""
    equations, there = case.reduced.equations(), coordinate_values(case.system, pose_of(case.q))
    states, places = np.stack([np.zeros_like(case.y), case.y]), np.stack([there] * 2)
    nowhere, found = equations.smallest_multipliers(states, np.zeros(2), places)
    (alone,) = equations.smallest_multipliers(states[1:], np.zeros(1), places[1:])
    np.testing.assert_array_equal(found, alone)
    if not case.reduced.model.rows.redundant:
        np.testing.assert_array_equal(found, equations.accelerations(case.y, 0.0, there.tolist())[1])
    if equations.accelerations(states[0], 0.0, there.tolist()) is None:
        assert np.isnan(nowhere).all()


@pytest.mark.parametrize("name", METHODS)
def test_one_exact_newton_correction_is_that_of_the_full_equations(case, name):
    """Δr, and Λ + ΔΛ normalised: ΔΛ of the full correction has no radial part where |Λ| = 1. Velocities stay."""
    system, q = case.system, case.q
    settings, pose = ProjectionSettings(method=name), pose_of(q)
    change = make_method(settings).correction(
        mass_matrix(system, pose), jacobian(system, pose), constraint(system, pose)
    )
    expected = (q + change).reshape(-1, 7)
    expected[:, 3:] /= np.linalg.norm(expected[:, 3:], axis=1, keepdims=True)
    moved = case.reduced.equations(settings).newton(case.y)
    number = condition(system, q, mass=name == "gpopm")
    assert_equal(moved[:, :7], expected, number)
    np.testing.assert_array_equal(moved[:, 7:], case.y[:, 7:])
    if system.at_positions.joints.size:
        assert np.abs(change).max() > 1e-4 * system.length


@pytest.mark.parametrize("name", METHODS)
def test_the_correction_closes_joints_and_velocities(case, name):
    """To the default tolerance, which is 1e-13 for coordinates below 100, even from joints that are wide open; a
    second correction finds nothing to do."""
    equations = case.reduced.equations(ProjectionSettings(method=name))
    closed = equations.corrected(case.y)
    assert np.abs(case.q).max() < 100.0
    assert np.abs(equations.constraint(closed)).max(initial=0.0) <= 1e-13
    fastest = max(1.0, np.abs(closed[:, 7:]).max())
    assert np.abs(equations.constraint_velocity(closed)).max(initial=0.0) <= 1e-13 * fastest
    np.testing.assert_array_equal(equations.corrected(closed)[:, :3], closed[:, :3])


def test_eq_75_popm_is_gpopm_bit_for_bit(case):
    """M₆ is definite: the two methods of the paper are one."""
    results = [
        case.reduced.equations(ProjectionSettings(method=name)).corrected(case.y).tobytes()
        for name in ("popm", "gpopm")
    ]
    assert results[0] == results[1]


# In the plane: the kernel's three coordinates a body against NumPy's seven, joints open where that is one.

FLAT = ("double_pendulum", "five_bar", "physical_pendulum", "planar_four_bar")
BUILD_IN_PLANE = {
    **{f"{name} 1": (lambda name=name: PLANAR_SCENES[name](Drawing(1))) for name in PLANAR_SCENES},
    **{f"{name} 2": (lambda name=name: PLANAR_SCENES[name](Drawing(2))) for name in PLANAR_SCENES},
    **{path.stem: (lambda path=path: read_scene(path)) for path in MECHANISMS if path.stem in FLAT},
    "long chain": lambda: chain(Drawing(3), ["revolute"] * 12),
    "parallelogram": parallelogram,
    **{
        f"with flywheels, {name} 1": (lambda name=name: with_flywheels(PLANAR_SCENES[name](Drawing(1))))
        for name in PLANAR_SCENES
    },
}


def kind(name: str) -> str:
    """What is drawn, without the number of the drawing, and with flywheels or without."""
    return name.rsplit(", ", 1)[-1].rsplit(" ", 1)[0]


#: Those that are planar where their joints are open, too, and of these the ones without a row that is redundant outside
#: of the plane.
OPEN = [name for name in BUILD_IN_PLANE if kind(name) not in CLOSED_ONLY]
REDUNDANT_OUTSIDE = ("cylinder on a plane", "four-bar", "rods and a slot", "parallelogram")
REGULAR = [name for name in OPEN if kind(name) not in REDUNDANT_OUTSIDE]


class PlanarCase(NamedTuple):
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


@pytest.fixture(scope="module", params=BUILD_IN_PLANE)
def planar_case(request):
    """Open by a few hundredths of the size, but for those that are planar only where they are closed."""
    system, state = assembled(BUILD_IN_PLANE[request.param]())
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
    return PlanarCase(system, plane, InPlane(core(), system, plane), p, u, q, v, bias, closed)


def planar_condition(case: PlanarCase) -> float:
    """The condition of S = G W⁻¹ Gᵀ in the plane."""
    G = planar_jacobian(case.plane, case.p)
    return float(np.linalg.cond(G / weights(case) @ G.T)) if len(G) else 1.0


def weights(case: PlanarCase) -> Array:
    mass = np.repeat(case.plane.mass, 3)
    mass[2::3] = case.plane.inertia
    return mass


def test_planar_constraints_and_their_derivatives(planar_case):
    """C, C', γ and G of the kernel's own primitives are those of `joints.primitives` on vectors (x, y, 0)."""
    equations, plane = planar_case.flat.equations(), planar_case.plane
    G = planar_jacobian(plane, planar_case.p)
    for found, expected in (
        (equations.constraint(planar_case.y), planar_constraint(plane, planar_case.p)),
        (equations.jacobian(planar_case.y).reshape(len(G), -1), G),
        (equations.constraint_velocity(planar_case.y), G @ planar_case.u),
        (equations.gamma(planar_case.y), planar_gamma(plane, planar_case.p, planar_case.u)),
    ):
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * max(1.0, np.abs(expected).max(initial=0.0)))


def test_accelerations_are_those_of_the_full_equations_and_reactions_load_the_plane_alike(planar_case):
    """q'' of Eq. 14; of λ the forces in the plane, as rows that hold the bodies in it may be redundant."""
    system, plane, number = planar_case.system, planar_case.plane, planar_condition(planar_case)
    pose = pose_of(planar_case.q)
    twist = twist_of(pose, planar_case.v)
    M, C_q = mass_matrix(system, pose), jacobian(system, pose)
    matrix = np.block([[M, C_q.T], [C_q, np.zeros((len(C_q), len(C_q)))]])
    rhs = np.concatenate([generalised_force(system, pose, twist), gamma(system, pose, twist)])
    solution, _, _, values = np.linalg.lstsq(matrix, rhs, rcond=1e-11)
    number = max(number, values[0] / values[values > 1e-11 * values[0]][-1])
    acceleration, own = planar_case.flat.equations().accelerations(planar_case.y)
    spread = planar_case.columns @ acceleration.ravel() + planar_case.bias
    assert_equal(spread, solution[: len(M)], number)
    in_plane = (C_q[system.bodies :] @ planar_case.columns).T
    assert_equal(
        in_plane @ plane.joints.source.multipliers(own, system.joints.size),
        in_plane @ solution[len(M) + system.bodies :],
        number,
    )


@pytest.mark.parametrize("planar_case", REGULAR, indirect=True)
def test_where_nothing_is_redundant_multipliers_in_the_plane_are_the_full_ones(planar_case):
    system, pose = planar_case.system, pose_of(planar_case.q)
    twist, C_q = twist_of(pose, planar_case.v), jacobian(system, pose)
    M, m = mass_matrix(system, pose), len(C_q)
    matrix = np.block([[M, C_q.T], [C_q, np.zeros((m, m))]])
    number = float(np.linalg.cond(matrix))
    assert number < 1e9
    own = planar_case.flat.equations().accelerations(planar_case.y)[1]
    full = np.linalg.solve(matrix, np.concatenate([generalised_force(system, pose, twist), gamma(system, pose, twist)]))
    assert_equal(own, planar_case.plane.joints.source.rows(full[len(M) + system.bodies :]), number)


@pytest.mark.parametrize("planar_case", OPEN, indirect=True)
@pytest.mark.parametrize("name", ["gopm", "gpopm"])
def test_one_exact_newton_correction_is_that_of_the_full_coordinates(planar_case, name):
    """The shortest Δq of q = (r, Λ) in the metric, which stays in the plane: Δr and δθ = 2 n·E ΔΛ."""
    system, pose = planar_case.system, pose_of(planar_case.q)
    C_q, n = jacobian(system, pose), system.bodies
    metric = mass_matrix(system, pose) if name == "gpopm" else np.eye(7 * n)
    # Eq. 67 as least squares, for rows that may be redundant: [A C_qᵀ; C_q 0] (Δ, μ) = (0, -C).
    matrix = np.block([[metric, C_q.T], [C_q, np.zeros((len(C_q), len(C_q)))]])
    rhs = np.concatenate([np.zeros(7 * n), -constraint(system, pose)])
    solution, _, _, values = np.linalg.lstsq(matrix, rhs, rcond=1e-11)
    number = max(planar_condition(planar_case), values[0] / values[values > 1e-11 * values[0]][-1])
    change = solution[: 7 * n].reshape(-1, 7)
    turn = (
        2.0
        * (matrix_E(planar_case.q.reshape(-1, 7)[:, 3:]) @ change[:, 3:, None])[..., 0]
        @ planar_case.plane.axes[:, 2]
    )
    expected = np.column_stack([change[:, :3] @ planar_case.plane.axes[:, :2], turn])
    moved = planar_case.flat.equations(ProjectionSettings(method=name)).newton(planar_case.y)
    step = moved[:, :3] - planar_case.p.reshape(-1, 3)
    step[:, 2] = np.angle(np.exp(1j * step[:, 2]))
    assert np.abs(change[:, :3] @ planar_case.plane.axes[:, 2]).max() <= ROUND_OFF * number
    assert_equal(step, expected, number)
    np.testing.assert_array_equal(moved[:, 3:], planar_case.y[:, 3:])


def test_all_multipliers_of_a_sample_balance_the_forces(planar_case):
    """Reactions out of the plane too: M q'' + C_qᵀ λ = Q at a state that is closed, with the λ that a run records."""
    system, plane, flat = planar_case.system, planar_case.plane, planar_case.flat
    y = flat.equations().corrected(planar_case.y)
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


# The mass-orthogonal projection in the kernel (Eqs. 48-55): what a penalty α leaves, and its limit.

BUILD_PENALTY = {"tree": lambda: tree(1), "loops": lambda: loops(2), "star": lambda: star(0, 4)}


@pytest.fixture(scope="module", params=BUILD_PENALTY)
def penalty_case(request) -> Case:
    """Open by so little that a correction is linear in the violation, to 1e-6 of it."""
    return opened(BUILD_PENALTY[request.param](), size=1e-6)


def shift(case: Case, **settings: object) -> Array:
    """(δr, δθ global) of each body by one correction of the position, (6n,)."""
    moved = case.reduced.equations(ProjectionSettings(**settings)).newton(case.y)
    before, after = case.y[:, 3:7], moved[:, 3:7]
    turned = 2.0 * (matrix_E(before) @ (after - before)[..., None])[..., 0]
    return np.concatenate([moved[:, :3] - case.y[:, :3], turned], axis=1).ravel()


@pytest.mark.parametrize("alpha", [1e-1, 1e1, 1e3, 1e5])
def test_a_correction_is_that_of_eq_52(penalty_case, alpha):
    """(M + α GᵀG) δ = -α Gᵀ C."""
    system, Λ = penalty_case.system, penalty_case.y[:, 3:7]
    G = tangent_jacobian(system, penalty_case.q).reshape(-1, 6 * system.bodies)
    A = matrix_E(Λ) @ np.swapaxes(matrix_L(Λ), -1, -2)
    M = np.zeros((system.bodies, 6, system.bodies, 6))
    index = np.arange(system.bodies)
    M[index, :3, index, :3] = system.mass[:, None, None] * np.eye(3)
    M[index, 3:, index, 3:] = A @ system.inertia @ np.swapaxes(A, -1, -2)
    C = constraint(system, pose_of(penalty_case.q))[system.bodies :]
    expected = np.linalg.solve(M.reshape(len(G.T), -1) + alpha * G.T @ G, -alpha * G.T @ C)
    found = shift(penalty_case, method="mass-orthogonal", alpha=alpha)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())


def test_with_the_penalty_it_tends_to_gpopm(penalty_case):
    """By 1/α: ten times the penalty, a tenth of the difference."""
    limit = shift(penalty_case, method="gpopm")
    off = [
        np.linalg.norm(shift(penalty_case, method="mass-orthogonal", alpha=alpha) - limit) / np.linalg.norm(limit)
        for alpha in (1e4, 1e5, 1e6)
    ]
    assert off[0] < 1e-1
    assert off[0] / off[1] == pytest.approx(10.0, rel=0.1)
    assert off[1] / off[2] == pytest.approx(10.0, rel=0.1)


def test_iterated_it_closes_what_gpopm_closes(penalty_case):
    """Positions and velocities, for α = 1e7 kg in masses of about 1 kg."""
    soft, limit = (
        penalty_case.reduced.equations(ProjectionSettings(method=method, alpha=alpha)).corrected(penalty_case.y)
        for method, alpha in (("mass-orthogonal", 1e7), ("gpopm", None))
    )
    equations = penalty_case.reduced.equations()
    fastest = np.abs(limit[:, 7:]).max()
    assert np.abs(equations.constraint(soft)).max() <= 1e-13
    assert np.abs(equations.constraint_velocity(soft)).max() <= 1e-13 * fastest
    np.testing.assert_allclose(soft, limit, rtol=0, atol=1e-6 * fastest)
