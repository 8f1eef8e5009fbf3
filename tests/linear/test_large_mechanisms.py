"""Linear models, modes and equilibria of large mechanisms: above 150 bodies, and long chains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

from mbproj import read_scene_text
from mbproj.base.errors import InputError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.derivatives import MotionAtTime, constraint_rows
from mbproj.equations.tangent_space import tangent_space
from mbproj.linear.bordered import along_tangent_space, independent_rows, tangent_space_of
from mbproj.linear.equilibrium.find import equilibrium, other_equilibria
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space import linear_model
from tests.crossed import full
from tests.kernel.scenes import shared_four_bars
from tests.linear.closed_forms import HEAD, chain, chain_frequencies, g, turning
from tests.support import assembled

# Linear models, steady turns and modes of mechanisms above 150 bodies, whose tangent space is found by sparse factors:
# against the dense tangent space and against closed forms.


@pytest.fixture(scope="module")
def four_bars():
    """80 four-bars that share their rockers, with 240 redundant rows: the system, its pose and its rows."""
    system, state = assembled(read_scene_text(shared_four_bars(80)))
    assert system.bodies > THRESHOLDS.large
    still = np.zeros(6 * system.bodies)
    motion = MotionAtTime(state.t, state.q, still, still, np.zeros(system.coordinates.size), state.x)
    return system, motion.pose, constraint_rows(system, motion)


def test_rows_of_a_long_loop_are_as_many_as_its_rank_and_span_all(four_bars):
    system, pose, G = four_bars
    found, dense = independent_rows(system, pose, G), G.dense()
    assert len(found) == np.linalg.matrix_rank(dense) == len(dense) - 3 * 80
    assert np.linalg.matrix_rank(dense[found]) == len(found)


def test_it_is_the_dense_one_where_rows_depend_on_each_other(four_bars):
    """The projections, and the smallest multipliers."""
    system, pose, G = four_bars
    dense, found = tangent_space(system, G.dense()), tangent_space_of(system, pose, G)
    assert found.freedom == dense.freedom == 1
    np.testing.assert_allclose(found.N @ found.N.T, dense.N @ dense.N.T, atol=1e-13)
    force = np.random.default_rng(3).normal(size=(6 * system.bodies, 2))
    expected, multipliers = dense.pseudoinverse.T @ force, found.pseudoinverse.T @ force
    np.testing.assert_allclose(multipliers, expected, atol=1e-8 * np.abs(expected).max())
    np.testing.assert_allclose(G.dense().T @ (multipliers - expected), 0.0, atol=1e-12 * np.abs(expected).max())
    reached = G.dense() @ force
    expected = dense.pseudoinverse @ reached
    np.testing.assert_allclose(found.pseudoinverse @ reached, expected, atol=1e-10 * np.abs(expected).max())
    expected = (force.T @ dense.N) @ (dense.N.T @ force)
    left = along_tangent_space(system, G, force.T)
    np.testing.assert_allclose(left @ left.T, expected, rtol=1e-10)


@pytest.mark.full
def test_displacements_along_the_tangent_space_of_a_long_chain_leave_its_joints_closed():
    """Rows that give way a little leave 1e-7 of it in chains as long as this one."""
    system, state = assembled(read_scene_text(chain(500)))
    still = np.zeros(6 * system.bodies)
    motion = MotionAtTime(state.t, state.q, still, still, np.zeros(system.coordinates.size), state.x)
    G = constraint_rows(system, motion)
    found = tangent_space_of(system, motion.pose, G)
    assert found.freedom == 500
    scale = system.row_scale[system.bodies :, np.newaxis]
    np.testing.assert_allclose(G.times(found.N) / scale, 0.0, atol=1e-14)


def test_a_linear_model_of_a_long_chain_has_its_frequencies_and_bears_its_weight():
    """A force across the end bar turns each bar until its weight balances it; the pin bears what pulls down."""
    links = 160
    text = chain(links) + "forces:\n  pull: {type: force, body: b159, force: [0, 0, 0]}\n"
    text += "markers:\n  end: {body: b159, location: {b159: [0, 0, 0]}}\n"
    scene = read_scene_text(text)
    system = compile_system(scene)
    reference = reference_at(system, assembled_start(scene, system), "start")
    outputs = ["end.x", "end.velocity_x", "j0.force_z", "j0.angle"]
    model = linear_model(reference, ["pull.x", "pull.z"], outputs)
    own = np.linalg.eigvals(model.A)
    own = np.sort(own.imag[own.imag > 0.0])
    np.testing.assert_allclose(own, chain_frequencies(links), rtol=1e-6)
    np.testing.assert_allclose(model.D[2], [0.0, -1.0], atol=1e-9)
    # At rest the bar k has the slope F / (weight below its middle).
    weight = g * (links - 0.5 - np.arange(links)) / links
    still = -np.linalg.solve(model.A, model.B)
    part = np.where(np.arange(links) < links - 1, 1.0, 0.5) / links
    np.testing.assert_allclose((model.C @ still + model.D)[0, 0], np.sum(part * part * links / weight), rtol=1e-9)
    np.testing.assert_allclose((model.C @ still + model.D)[3, 0], -1.0 / weight[0], rtol=1e-9)


def governor(arms):
    """Weights that hang on arms of 0.25 m from one point of a shaft."""
    bodies = "".join(f"  w{k}: {{mass: 1, inertia: [0, 0, 0], position: [0.15, 0, -0.2]}}\n" for k in range(arms))
    shaft = "  shaft: {mass: 2, inertia: [0.1, 0.1, 0.05], position: [0, 0, 0]}\n"
    arm = "type: revolute, bodies: [shaft, w%d], location: [0, 0, 0], axis: [0, 1, 0]"
    joints = "".join(f"  j{k}: {{{arm % k}}}\n" for k in range(arms))
    turns = "  A: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, 0, 1]}\n"
    return f"{HEAD}bodies:\n{shaft}{bodies}joints:\n{turns}{joints}"


@pytest.mark.full
def test_a_governor_of_many_arms_opens_and_rings_as_each():
    """cos θ = g / (Ω² l), and λ² = -Ω² sin² θ where it is held at its speed."""
    text = governor(155) + "motions:\n  turn: {joint: A, angle: {constant_speed: 9}}\n"
    found = turning(text, 9.0)
    opening = np.arccos(g / (81 * 0.25))
    position = found.reference.motion.pose.position[1:-1]
    np.testing.assert_allclose(position[:, 2], -0.25 * np.cos(opening), atol=1e-10)
    np.testing.assert_allclose(modes(found.reference, 20).eigenvalues, 1j * 9.0 * np.sin(opening), rtol=1e-8)
    assert found.stable


def test_a_long_chain_that_swings_has_the_modes_of_that_instant():
    """In the bars' angles φ, M_jk cos(φ_j - φ_k) φ_k'' + M_jk sin(φ_j - φ_k) φ_k'² = 0; about one that turns as one."""
    links, speed = 155, 2.0
    text = chain(links).replace("gravity: [0, 0, -9.81]", "gravity: [0, 0, 0]")
    turned = text.replace("axis: [0, 1, 0]}", f"axis: [0, 1, 0], speed: {speed!r}}}", 1)
    scene = read_scene_text(turned.replace("axis: [0, 1, 0]}", "axis: [0, 1, 0], speed: 0}"))
    system = compile_system(scene)
    found = modes(reference_at(system, assembled_start(scene, system), "start"), 4)
    M = links - 0.5 - np.maximum.outer(np.arange(links), np.arange(links))
    np.fill_diagonal(M, links - 1 - np.arange(links) + 1 / 3)
    expected = speed * np.sqrt(eigh(np.diag(M.sum(axis=1)) - M, M, eigvals_only=True)[1:3])
    np.testing.assert_allclose(found.eigenvalues, [0.0, 0.0, *(1j * expected)], rtol=1e-8)  # as one, at any speed
    assert found.turns


def test_what_is_too_free_is_refused_with_the_limit(monkeypatch):
    monkeypatch.setattr("mbproj.linear.bordered.THRESHOLDS", replace(THRESHOLDS, most_dense=100))
    scene = read_scene_text(chain(160))
    system = compile_system(scene)
    reference = reference_at(system, assembled_start(scene, system), "start")
    with pytest.raises(InputError, match="for up to 100 degrees of freedom, and this mechanism has 160") as refused:
        linear_model(reference, ["j0.angle"], ["j0.angle"])
    assert refused.value.problems[0].key == ("bodies",)


# Chains between two supports: from a crooked start they find the discrete catenary, and ring about it as their own
# equations say.


def hung(angles):
    """Bars of 1 m and 1 kg in all, at these angles below the horizontal, on parallel pins; and the span."""
    part = 1.0 / len(angles)
    inertia = part**3 / 12
    ends = np.vstack([np.zeros(3), np.cumsum(ways(angles), axis=0)])
    bodies, joints = [], []
    for i, (angle, (x, _, z)) in enumerate(zip(angles.tolist(), (0.5 * (ends[1:] + ends[:-1])).tolist(), strict=True)):
        place = f"position: [{x!r}, 0, {z!r}], orientation: {{axis: [0, 1, 0], angle: {angle!r}}}"
        bodies.append(f"  b{i}: {{mass: {part!r}, inertia: [1.0e-12, {inertia!r}, {inertia!r}], {place}}}\n")
    names = ["ground", *(f"b{i}" for i in range(len(angles))), "ground"]
    for i, (x, _, z) in enumerate(ends.tolist()):
        pair = f"bodies: [{names[i]}, {names[i + 1]}], location: [{x!r}, 0, {z!r}]"
        joints.append(f"  j{i}: {{type: revolute, {pair}, axis: [0, 1, 0]}}\n")
    return HEAD + "bodies:\n" + "".join(bodies) + "joints:\n" + "".join(joints), ends[-1, 0]


def ways(angles):
    """From pin to pin."""
    return np.array([np.cos(angles), 0.0 * angles, -np.sin(angles)]).T / len(angles)


def crooked(links):
    """An arch with waves on it."""
    along = np.arange(links // 2) / (links // 2)
    left = -0.9 + 1.5 * along + 0.4 * np.sin(23.0 * along) + 0.1 * np.sin(101.0 * along)
    return np.concatenate([left, -left[::-1]])


def catenary(links, span):
    """The angles at which bars carry the weight that hangs on them, and the horizontal force that pulls on all."""
    hangs = g * (0.5 * (links - 1) - np.arange(links)) / links

    def excess(pull):
        return np.cos(np.arctan2(hangs, pull)).mean() - span

    pull = brentq(excess, 1e-3, 1e3, xtol=1e-15)
    return np.arctan2(hangs, pull), pull


def chain_equations(angles, pull):
    """Angular frequencies about the catenary, from the bars' angles with the span as two constraints."""
    links = len(angles)
    part = weight = 1.0 / links
    first = np.maximum.outer(np.arange(links), np.arange(links))
    M = weight * part**2 * (links - 1 - first + 0.5) * np.cos(angles[:, None] - angles)
    np.fill_diagonal(M, weight * part**2 * (links - 1 - np.arange(links) + 1 / 3))
    K = np.diag(part * pull / np.cos(angles))  # what pulls along each bar
    Z = null_space(np.array([np.sin(angles), np.cos(angles)]))
    return np.sqrt(eigh(Z.T @ K @ Z, Z.T @ M @ Z, eigvals_only=True))


def at_rest(text):
    scene = read_scene_text(text)
    system = compile_system(scene)
    return equilibrium(system, assembled_start(scene, system))


@pytest.mark.parametrize("links", [10, 40, full(200)])
def test_a_chain_finds_its_catenary(links):
    """Dense, sparse, and with sparse modes; its pins leave three rows of the loop redundant."""
    text, span = hung(crooked(links))
    found = at_rest(text)
    angles, pull = catenary(links, span)
    ends = np.vstack([np.zeros(3), np.cumsum(ways(angles), axis=0)])
    position = found.reference.motion.pose.position[:-1]
    np.testing.assert_allclose(position, 0.5 * (ends[1:] + ends[:-1]), atol=1e-10)
    assert found.reference.imbalance.relative < 1e-12
    assert found.stable
    assert found.steps < 30
    ringing = modes(found.reference, 5)
    assert ringing.freedom == links - 2
    np.testing.assert_allclose(ringing.eigenvalues.imag, chain_equations(angles, pull)[:5], rtol=1e-9)


def test_upright_a_long_chain_rests_too_but_is_not_stable():
    text = chain(160).replace("gravity: [0, 0, -9.81]", "gravity: [0, 0, 9.81]")
    found = at_rest(text)
    assert found.stable is False
    assert found.unstable.startswith("of j")


def test_from_other_starts_an_upright_chain_finds_where_it_hangs_by_sparse_matrices(monkeypatch):
    monkeypatch.setattr("mbproj.linear.equilibrium.find.THRESHOLDS", replace(THRESHOLDS, large=8))
    found = at_rest(chain(10).replace("gravity: [0, 0, -9.81]", "gravity: [0, 0, 9.81]"))
    assert not found.stable
    (hangs,) = other_equilibria(found.reference.system, found, 1)
    assert hangs.stable
    np.testing.assert_allclose(hangs.reference.motion.pose.position[:-1, 2], (np.arange(10) + 0.5) / 10, atol=1e-9)


@pytest.mark.full
def test_a_long_chain_that_falls_is_refused_with_the_force_that_is_left():
    """It hangs on nothing."""
    text = chain(160).replace("type: revolute, bodies: [ground, b0]", "type: planar, bodies: [ground, b0]")
    with pytest.raises(NoEquilibrium, match="there is no equilibrium: nothing balances"):
        at_rest(text)
