"""Chains between two supports: from a crooked start they find the discrete catenary, and ring about it as their own
equations say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.find import equilibrium, other_equilibria
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.modes import modes
from mbproj.scene.scene import read_scene_text
from tests.crossed import full
from tests.linear.closed_forms import HEAD, chain, g


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
    monkeypatch.setattr("mbproj.base.thresholds.THRESHOLDS", replace(THRESHOLDS, large=8))
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
