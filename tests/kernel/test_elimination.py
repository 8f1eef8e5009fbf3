"""The elimination in the kernel: block Cholesky, dependent rows, least-norm multipliers, light bodies and uneven
masses."""

from __future__ import annotations

import dataclasses
from decimal import Decimal, localcontext

import numpy as np
import pytest

import mbproj
from mbproj import Scene, mobility, read_scene_text
from mbproj.base.arrays import Array
from mbproj.equations.assembly.assemble import State, assemble, coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import gamma, jacobian
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.equations.of_motion import SOLVERS, generalised_force, mass_matrix
from mbproj.kernel import core
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.reduced import InPlane, Reduced, space_acceleration
from mbproj.motion.formulations.redundant_rows import count_redundant, settle_rows
from mbproj.scene.scene import read_scene
from tests.kernel.scenes import (
    Case,
    ladder,
    loops,
    mechanism,
    needs_kernel,
    opened,
    parallelogram,
    rails,
    shaft,
    shared_four_bars,
    star,
    tree,
)
from tests.mechanisms.running import run_scene
from tests.support import MECHANISMS, REDUNDANT, assembled, random_body, random_chain, random_joint, scene_of

pytestmark = needs_kernel


# The elimination, seen through the equations: residuals of M a + Gᵀλ = f and G a = γ at any size, fill, pivots.

KINDS = ["revolute", "spherical", "universal"]
SHAPES = {
    "chain": lambda size: random_chain(3, [KINDS[body % 3] for body in range(size)]),
    "floating tree": lambda size: tree(8, size),
    "ladder": lambda size: ladder(5, max(1, size // 2)),
    "star": lambda size: star(2, size - 1),
    "shaft": lambda size: shaft(2, size - 1),
    "rails": lambda size: rails(2, max(1, size // 4)),
}


def residuals(case: Case) -> tuple[float, float, float]:
    """What is left of Newton and Euler's equations, of G a = γ, and the largest number among a, λ and f."""
    system, y, equations = case.system, case.y, case.reduced.equations()
    acceleration, multipliers = equations.accelerations(y)
    A, omega = rotation_matrix(y[:, 3:7]), y[:, 10:13]
    G = equations.jacobian(y)
    gyroscopic = np.cross(omega, np.einsum("nij,nj->ni", system.inertia, omega))
    inertial = np.einsum("nij,nj->ni", system.inertia, acceleration[:, 3:]) + gyroscopic
    force = system.mass[:, None] * (acceleration[:, :3] - system.gravity)
    wrench = np.hstack([force, np.einsum("nij,nj->ni", A, inertial)]) + np.einsum("mni,m->ni", G, multipliers)
    a = np.hstack([acceleration[:, :3], np.einsum("nij,nj->ni", A, acceleration[:, 3:])])
    largest = max(np.abs(a).max(), np.abs(multipliers).max(initial=0.0), np.abs(inertial).max())
    return np.abs(wrench).max(), np.abs(np.einsum("mni,ni->m", G, a) - equations.gamma(y)).max(initial=0.0), largest


@pytest.mark.parametrize("size", [3, 30, 300])
@pytest.mark.parametrize("shape", SHAPES)
def test_both_equations_hold_to_round_off(shape, size):
    case = opened(SHAPES[shape](size), size=1e-3 / size)
    force, rows, largest = residuals(case)
    assert force <= 1e-12 * largest * size
    assert rows <= 1e-12 * largest * size


@pytest.mark.parametrize("seed", range(30))
def test_both_equations_hold_in_random_loops(seed):
    """Balls, slides, planes and rods that close a chain three times over; many orders of elimination."""
    case = opened(loops(seed, 4 + seed % 5))
    found = case.reduced.equations().accelerations(case.y)
    assert found is not None
    force, rows, largest = residuals(case)
    assert max(force, rows) <= 1e-10 * largest


@pytest.mark.parametrize("size", [3, 30, pytest.param(300, marks=pytest.mark.full)])
def test_trees_need_no_factor_at_all(size):
    """Leaves are eliminated one by one down to the root, which the ground holds or nothing does."""
    facts = topology(random_chain(3, [KINDS[body % 3] for body in range(size)]))
    assert facts == {
        "eliminated_bodies": size,
        "core_bodies": 0,
        "core_joints": 0,
        "core_numbers": 0,
        "core_fill": 0,
    }
    assert topology(tree(8, size))["eliminated_bodies"] >= size - 1
    assert topology(tree(8, size))["core_numbers"] == 0


def test_the_factor_of_a_ladder_grows_by_a_constant_per_loop():
    numbers = [topology(ladder(5, loops))["core_numbers"] for loops in (10, 20, 40, 80)]
    fill = [topology(ladder(5, loops))["core_fill"] for loops in (10, 20, 40, 80)]
    per_loop = np.diff(numbers) / (10, 20, 40)
    assert per_loop[0] == per_loop[1] == per_loop[2]
    # Of a loop: two balls and a rod, 7 rows that couple with the loop's own and the next one's.
    assert per_loop[0] <= 7 * 14
    assert all(part <= 0.5 * whole for part, whole in zip(fill, numbers, strict=True))


@pytest.mark.parametrize("arms", [3, 30, 100])
def test_the_factor_of_a_star_of_loops_holds_no_more_than_the_coupling_at_the_hub(arms):
    """Arms on balls (3 rows) around a hub, each tied to the ground by a rod (1 row). The balls all couple at the hub,
    a rod with its own ball alone: eliminated first, the rods cost nothing beyond."""
    rng = np.random.default_rng(arms)
    bodies = [random_body(rng, f"b{number}") for number in range(arms + 1)]
    balls = [random_joint(rng, f"J{arm}", "spherical", ("b0", f"b{arm}")) for arm in range(1, arms + 1)]
    rods = [random_joint(rng, f"R{arm}", "distance", ("ground", f"b{arm}")) for arm in range(1, arms + 1)]
    facts = topology(scene_of(bodies, [*balls, *rods]))
    assert facts["core_joints"] == 2 * arms
    assert facts["core_fill"] == 0
    assert facts["core_numbers"] == (1 + 3) * arms + 9 * arms * (arms + 1) // 2


def test_the_factor_of_loops_on_one_shaft_grows_by_a_constant_per_loop():
    """Of each arm a ball on the shaft (3 rows), a rod to the ground (1), and a weld to the shaft's next piece (1)."""
    numbers = [topology(shaft(5, arms, ["spherical"]))["core_numbers"] for arms in (10, 20, 40, 80)]
    per_arm = np.diff(numbers) / (10, 20, 40)
    assert per_arm[0] == per_arm[1] == per_arm[2] <= (3 + 1 + 1) * (3 + 1 + 1)


def test_joints_that_hinge_a_body_to_the_ground_have_no_rows_in_the_factor():
    """Of a slider-crank, 17 rows, those of the ball and of the universal joint are left: 3 and 4."""
    facts = topology(mechanism("spatial_slider_crank"))
    assert facts["core_joints"] == 2
    assert facts["core_numbers"] == 3 * 3 + 4 * 4 + 3 * 4


def test_rails_between_two_joints_have_no_rows_of_their_hinges_in_the_factor():
    """Of each loop's 16 rows, those of a ball and a universal joint are left, 7, which couple with the next loop's."""
    per_loop = np.diff([topology(rails(5, loops))["core_numbers"] for loops in (10, 20, 40)]) / (10, 20)
    assert per_loop[0] == per_loop[1] <= 7 * 14
    joints = [topology(rails(5, loops))["core_joints"] for loops in (10, 20)]
    assert joints == [2 * 10 + 1, 2 * 20 + 1]  # and the rod of the triangle


def topology(scene: Scene) -> dict[str, int]:
    return dict(Reduced(core(), compile_system(scene)).equations().topology)


# Rows that the kernel leaves out because they follow from the others: as many as G lacks of full rank by its singular
# values, and such that those held have that rank.

#: Singular values below this part of the largest are none, and squares of distances below this are.
NONE, SQUARE = 1e-9, 1e-10


def redundant_mechanism(name: str) -> Scene:
    return read_scene(next(path for path in MECHANISMS if path.stem == name))


def dead() -> Scene:
    """Crank, coupler and rocker in one line, at rest."""
    scene = parallelogram(np.pi / 2)
    return dataclasses.replace(scene, joints=tuple(dataclasses.replace(joint, speed={}) for joint in scene.joints))


#: By name: the scene, and how many rows follow from the others in space.
SCENES = {
    **{name: (lambda name=name: redundant_mechanism(name), count) for name, count in REDUNDANT.items()},
    "parallelogram": (parallelogram, 3),
    "parallelogram in line": (dead, 4),
    "regular loops": (lambda: loops(2), 0),
    "regular star": (lambda: star(1), 0),
}


def scaled_rows(compiled: Compiled, state: State) -> Array:
    """G (m, freedoms of all bodies) with unit rows and lengths in the mechanism's own."""
    G = compiled.equations().jacobian(compiled.state(state.q, state.v), state.t)
    shifts = 3 if compiled.name == "reduced" else 2
    weights = np.where(np.arange(G.shape[2]) < shifts, compiled.system.length, 1.0)
    rows = (G * weights).reshape(len(G), -1)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def deficiency(rows: Array) -> int:
    values = np.linalg.svd(rows, compute_uv=False)
    assert not np.any((values > NONE * values[0]) & (values < 1e3 * NONE * values[0]))  # a clear cut
    return len(rows) - int(np.count_nonzero(values > NONE * values[0]))


@pytest.mark.parametrize("name", SCENES)
def test_as_many_rows_depend_on_others_as_singular_values_vanish(name):
    build, count = SCENES[name]
    system, state = assembled(build())
    compiled = Reduced(core(), system)
    assert deficiency(scaled_rows(compiled, state)) == count
    assert compiled.equations().dependent_rows(compiled.state(state.q, state.v), state.t, SQUARE) == count


@pytest.mark.parametrize(("name", "count"), [("locomotive", 1), ("n_four_bar", 0), ("parallelogram in line", 1)])
def test_the_same_in_the_plane(name, count):
    """Where rows across the plane are no part of the equations."""
    system, state = assembled(SCENES[name][0]())
    plane = planar_reduction(system, state.q)
    assert isinstance(plane, Plane)
    compiled = InPlane(core(), system, plane)
    assert deficiency(scaled_rows(compiled, state)) == count
    assert compiled.equations().dependent_rows(compiled.state(state.q, state.v), state.t, SQUARE) == count


@pytest.mark.parametrize("name", REDUNDANT)
def test_the_rows_held_have_the_rank_of_all(name):
    """At velocities that open the joints the rows contradict each other: accelerations meet γ in those that are held,
    and these are far from dependent."""
    system, state = assembled(redundant_mechanism(name))
    compiled = Reduced(core(), system)
    settle_rows(compiled, state)
    thrown = state.v + np.random.default_rng(0).normal(size=len(state.v))
    y, equations = compiled.state(state.q, thrown), compiled.equations()
    solved = equations.accelerations(y, state.t)
    assert solved is not None
    acceleration, multipliers = solved
    rotation, gamma = pose_of(state.q).rotation[:-1], equations.gamma(y, state.t)
    acceleration[:, 3:] = (rotation @ acceleration[:, 3:, None])[..., 0]
    missed = np.abs(np.einsum("mnf,nf->m", equations.jacobian(y, state.t), acceleration) - gamma)
    held = missed <= 1e-9 * np.abs(gamma).max()
    assert np.count_nonzero(~held) == REDUNDANT[name]
    assert not np.any(multipliers[~held])
    rows = scaled_rows(compiled, state)
    all_values, values = (np.linalg.svd(some, compute_uv=False) for some in (rows, rows[held]))
    assert values[-1] > 1e-2 * all_values[len(values) - 1]


# The smallest multipliers of large mechanisms with redundant rows: λ in the range of G, by a sparse factor of GᵀG.


@pytest.mark.parametrize("loops", [1, 40])
def test_smallest_multipliers_are_the_part_in_the_range_of_the_rows(loops):
    system, state = assembled(read_scene_text(shared_four_bars(loops)))
    reduced = Reduced(core(), system)
    assert count_redundant(reduced, state) == 3 * loops
    equations, y, scale = reduced.equations(), reduced.state(state.q, state.v), reduced.row_scale
    _, carried = equations.accelerations(y)
    lengths = np.tile([system.length] * 3 + [1.0] * 3, system.bodies)
    G = equations.jacobian(y).reshape(len(carried), -1) * lengths / scale[:, None]
    U, size, _ = np.linalg.svd(G, full_matrices=False)
    U = U[:, size > 1e-9]
    smallest = U @ (U.T @ (carried * scale)) / scale
    unbalanced = np.random.default_rng(0).normal(size=len(carried))
    others = carried + 1e3 * (unbalanced - U @ (U.T @ unbalanced)) / scale
    found = equations.spread(np.stack([y, y]), np.zeros(2), np.stack([carried, others]))
    largest = np.abs(smallest).max()
    assert np.abs(others - smallest).max() > largest  # there is something to spread
    np.testing.assert_allclose(found[0], smallest, atol=1e-11 * largest)
    np.testing.assert_allclose(found[1], smallest, atol=1e-9 * largest)


def test_smallest_multipliers_along_a_motion_are_the_smallest_in_any_block():
    """To the bit: samples are observed in blocks, whose bounds depend on the clock. None is out of the range of G."""
    scene = read_scene_text(shared_four_bars(1))
    system = compile_system(scene)
    results = mbproj.run(scene, tolerance=1e-8, duration=0.6, output_step=0.02)
    bodies = [results[f"bodies/{name}"] for name in ("position", "orientation")]
    q = np.concatenate(bodies, axis=2).reshape(len(results["time"]), -1)
    reduced = Reduced(core(), system)
    assert count_redundant(reduced, assemble(system, initial_guess(scene, system))) == 3
    equations, y = reduced.equations(), np.stack([reduced.state(each, 0.0 * each) for each in q])
    t, places = np.zeros(len(y)), np.stack([coordinate_values(system, pose_of(each)) for each in q])
    together = equations.smallest_multipliers(y, t, places)
    for k in range(len(y)):
        (alone,) = equations.smallest_multipliers(y[k : k + 1], t[:1], places[k : k + 1])
        np.testing.assert_array_equal(together[k], alone)
    lengths = np.tile([system.length] * 3 + [1.0] * 3, system.bodies)
    scale = reduced.row_scale
    for own, smallest in zip(y, together, strict=True):
        G = equations.jacobian(own).reshape(len(scale), -1) * lengths / scale[:, None]
        U, size, _ = np.linalg.svd(G, full_matrices=False)
        beyond = smallest * scale - U[:, size > 1e-9] @ (U[:, size > 1e-9].T @ (smallest * scale))
        assert np.abs(beyond).max() < 1e-9 * np.abs(smallest * scale).max()


# A body without mass and inertia in loops, to which the kernel lends some: against Eq. 14, which needs none.

NOTHING = ((0.0, 0.0, 0.0),) * 3
#: The scene, and a body of it that no joint lets move without moving mass (Eq. 20).
LIGHT = {f"loops {seed}, body {body}": (loops, seed, body) for seed in range(6) for body in (0, 1, 3)}
LIGHT["the hub of a star"] = (star, 0, 0)


def with_nothing(scene: Scene, body: int) -> Scene:
    """The scene with neither mass nor inertia in one of its bodies."""
    bodies = list(scene.bodies)
    bodies[body] = dataclasses.replace(bodies[body], mass=0.0, inertia=NOTHING)
    return dataclasses.replace(scene, bodies=tuple(bodies))


@pytest.fixture(params=LIGHT)
def case(request) -> Case:
    build, seed, body = LIGHT[request.param]
    found = opened(with_nothing(build(seed), body))
    assert not mobility(found.system, pose_of(found.q)).massless
    assert found.reduced.equations().topology["core_bodies"] > 0
    return found


def test_accelerations_and_multipliers_hold_nothing_of_what_was_lent(case):
    """A millionth of the mean mass would show in the sixth digit."""
    system, pose = case.system, pose_of(case.q)
    twist = twist_of(pose, case.v)
    expected, multipliers = SOLVERS["bordered"](
        mass_matrix(system, pose),
        jacobian(system, pose),
        generalised_force(system, pose, twist),
        gamma(system, pose, twist),
    )
    acceleration, own = case.reduced.equations().accelerations(case.y)
    found = space_acceleration(case.y[None], acceleration[None])[0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    joints = multipliers[system.bodies :]
    np.testing.assert_allclose(own, joints, rtol=0, atol=1e-9 * np.abs(joints).max())


# Rods without inertia about their axis: planar coordinates do not ask for it, and the reactions are the full ones.

RODS = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 0.3, tolerance: 1e-11, integrator: dop853, output_step: 0.1}
bodies:
  a: {mass: 1, shape: {rod: {length: 1, axis: x}}, position: [0.5, 0, 0]}
  b: {mass: 2, shape: {rod: {length: 1, axis: x}}, position: [1.5, 0.2, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [a, b], location: [1, 0.1, 0], axis: [0, 1, 0]}
forces:
  side: {type: force, body: b, force: [1, 3, 0]}
"""


def test_thin_rods_are_planar_and_their_reactions_those_of_the_full_form():
    runs = [run_scene(read_scene_text(RODS, "r.yaml", {}, {"formulation": name})) for name in ("auto", "full")]
    planar, full = runs
    assert planar.report.formulation == "planar"
    for path in ("bodies/position", "joints/reaction_force", "joints/reaction_torque"):
        size = max(1.0, np.abs(full[path]).max())
        np.testing.assert_allclose(planar[path], full[path], rtol=0, atol=1e-8 * size, err_msg=path)


def test_in_space_thin_rods_run_reduced():
    text = RODS.replace("axis: [0, 1, 0]}\nforces", "axis: [0, 1, 1]}\nforces")
    done = run_scene(read_scene_text(text, "r.yaml"))
    assert done.report.formulation == "reduced"


# Loops of bodies whose masses leave the factor of S = G M⁻¹ Gᵀ few digits, or none: against decimals of 80 digits.

DIGITS = 80


def exactly(A: Array, b: Array) -> Array:
    """A⁻¹ b with the numbers as they are, by elimination with row pivots in decimals, rounded at the end."""
    with localcontext() as context:
        context.prec = DIGITS
        rows = [[Decimal(float(x)) for x in (*row, last)] for row, last in zip(A, b, strict=True)]
        for column in range(len(rows)):
            pivot = max(range(column, len(rows)), key=lambda row: abs(rows[row][column]))
            rows[column], rows[pivot] = rows[pivot], rows[column]
            for row in rows[column + 1 :]:
                if row[column]:
                    factor = row[column] / rows[column][column]
                    for entry in range(column, len(row)):
                        row[entry] -= factor * rows[column][entry]
        found = [Decimal(0)] * len(rows)
        for row in reversed(range(len(rows))):
            known = sum((rows[row][k] * found[k] for k in range(row + 1, len(rows))), Decimal(0))
            found[row] = (rows[row][-1] - known) / rows[row][row]
        return np.array([float(x) for x in found])


def uneven(seed: int, ratio: float) -> Case:
    """Five bodies in loops, every second one so many times as heavy as the others."""
    scene = loops(seed)
    bodies = tuple(
        dataclasses.replace(
            body, mass=factor * body.mass, inertia=tuple(tuple(factor * x for x in row) for row in body.inertia)
        )
        for body, factor in zip(scene.bodies, [1.0, ratio] * 3, strict=False)
    )
    return opened(dataclasses.replace(scene, bodies=bodies))


def reference(case: Case) -> tuple[Array, Array]:
    """(r'', ω' global) of each body, (6n,), and λ of [M Gᵀ; G 0] with the kernel's own G and γ."""
    system, pose, equations = case.system, pose_of(case.q), case.reduced.equations()
    A, omega = pose.rotation[:-1], body_rates(pose, twist_of(pose, case.v))[:-1]
    G = equations.jacobian(case.y).reshape(-1, 6 * system.bodies)
    size, rows = G.shape[1], len(G)
    bordered = np.zeros((size + rows, size + rows))
    blocks = bordered[:size, :size].reshape(system.bodies, 6, system.bodies, 6)
    index = np.arange(system.bodies)
    blocks[index, :3, index, :3] = system.mass[:, None, None] * np.eye(3)
    blocks[index, 3:, index, 3:] = A @ system.inertia @ np.swapaxes(A, -1, -2)
    bordered[size:, :size], bordered[:size, size:] = G, G.T
    torque = -np.cross(omega, (system.inertia @ omega[..., None])[..., 0])
    force = np.concatenate([system.mass[:, None] * system.gravity, (A @ torque[..., None])[..., 0]], axis=1)
    found = exactly(bordered, np.concatenate([force.ravel(), equations.gamma(case.y)]))
    return found[:size], found[size:]


def compared(case: Case) -> tuple[Array, Array, Array, Array]:
    """The kernel's accelerations (n, 6), global, and λ, and the reference's."""
    solved = case.reduced.equations().accelerations(case.y)
    assert solved is not None
    acceleration, multipliers = solved
    A = pose_of(case.q).rotation[:-1]
    found = np.concatenate([acceleration[:, :3], (A @ acceleration[:, 3:, None])[..., 0]], axis=1)
    expected, forces = reference(case)
    return found, expected.reshape(-1, 6), multipliers, forces


@pytest.mark.parametrize("ratio", [1e0, 1e4, 1e8, 1e12])
@pytest.mark.parametrize("seed", range(6))
def test_accelerations_and_multipliers_to_ten_digits(seed, ratio):
    """Where heavy bodies bear on each other through light ones, what these are left with is a difference of forces that
    are `ratio` times as large: ε times that, relative to the largest acceleration, is G's own round-off."""
    found, expected, multipliers, forces = compared(uneven(seed, ratio))
    atol = max(1e-10, 1e-17 * ratio) * np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol)
    np.testing.assert_allclose(multipliers, forces, rtol=0, atol=1e-10 * np.abs(forces).max())


@pytest.mark.parametrize("ratio", [1e16, 1e18, 1e20])
@pytest.mark.parametrize("seed", range(6))
def test_beyond_what_s_has_digits_for_heavy_bodies_and_forces_are_right(seed, ratio):
    """By an orthogonal factorisation of G itself; the rows hold for the light ones too."""
    case = uneven(seed, ratio)
    found, expected, multipliers, forces = compared(case)
    np.testing.assert_allclose(found[1::2], expected[1::2], rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(multipliers, forces, rtol=0, atol=1e-12 * np.abs(forces).max())
    equations = case.reduced.equations()
    gamma = equations.gamma(case.y)
    G = equations.jacobian(case.y).reshape(len(gamma), -1)
    np.testing.assert_allclose(G @ found.ravel(), gamma, rtol=0, atol=1e-12 * np.abs(gamma).max())
