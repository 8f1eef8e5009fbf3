"""Rows that the kernel leaves out because they follow from the others: as many as G lacks of full rank by its singular
values, and such that those held have that rank."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.arrays import Array
from mbproj.equations.assembly.assemble import State
from mbproj.equations.kinematics import pose_of
from mbproj.kernel import core
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.reduced import InPlane, Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows
from mbproj.scene.scene import read_scene
from tests.kernel.scenes import assembled, loops, needs_kernel, parallelogram, star
from tests.support import MECHANISMS, REDUNDANT

pytestmark = needs_kernel
#: Singular values below this part of the largest are none, and squares of distances below this are.
NONE, SQUARE = 1e-9, 1e-10


def mechanism(name: str) -> Scene:
    return read_scene(next(path for path in MECHANISMS if path.stem == name))


def dead() -> Scene:
    """Crank, coupler and rocker in one line, at rest."""
    scene = parallelogram(np.pi / 2)
    return dataclasses.replace(scene, joints=tuple(dataclasses.replace(joint, speed={}) for joint in scene.joints))


#: By name: the scene, and how many rows follow from the others in space.
SCENES = {
    **{name: (lambda name=name: mechanism(name), count) for name, count in REDUNDANT.items()},
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
    system, state = assembled(mechanism(name))
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
