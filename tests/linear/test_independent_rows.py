"""Which rows of large mechanisms are independent, beside the rank of the dense matrix."""

from __future__ import annotations

import numpy as np

from mbproj import read_scene_text
from mbproj.dynamics import assemble
from mbproj.dynamics.derivatives.linear_equations import Motion, constraint_rows
from mbproj.linear.independent_rows import independent_rows
from mbproj.model import compile_system, initial_guess
from mbproj.thresholds import THRESHOLDS
from tests.kernel.scenes import shared_four_bars


def test_rows_of_a_long_loop_are_as_many_as_its_rank_and_span_all():
    scene = read_scene_text(shared_four_bars(80))
    system = compile_system(scene)
    assert system.bodies > THRESHOLDS.dense_modes
    state = assemble(system, initial_guess(scene, system))
    still = np.zeros(6 * system.bodies)
    motion = Motion(state.t, state.q, still, still, np.zeros(system.coordinates.size), state.x)
    G = constraint_rows(system, motion)
    found = independent_rows(system, motion.pose, G)
    dense = G.dense()
    assert len(found) == np.linalg.matrix_rank(dense) == len(dense) - 3 * 80
    assert np.linalg.matrix_rank(dense[found]) == len(found)
