"""The smallest multipliers of large mechanisms with redundant rows: λ in the range of G, by a sparse factor of GᵀG."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import read_scene_text
from mbproj.equations.assembly.assemble import assemble, coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.kernel import core
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.formulations.redundant_rows import count_redundant
from tests.kernel.scenes import needs_kernel, shared_four_bars

pytestmark = needs_kernel


@pytest.mark.parametrize("loops", [1, 40])
def test_smallest_multipliers_are_the_part_in_the_range_of_the_rows(loops):
    scene = read_scene_text(shared_four_bars(loops))
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
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
