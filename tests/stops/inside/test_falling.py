"""What falls freely presses nothing, though limits are touched: round-off of accelerations is no force."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.scene import read_scene_text
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import run_scene


def falling(limbs: int = 8) -> str:
    """A trunk of 50 kg with light limbs in chains of up to three, all at a limit of theirs, at rest."""
    rng = np.random.default_rng(0)
    bodies, joints = "  trunk: {mass: 50, inertia: [1, 2, 1.5], position: [0.1, 0.2, 1.3]}\n", ""
    for k in range(limbs):
        at, axis, arm = rng.normal(size=(3, 3))
        place = (at + 0.3 * arm).tolist()
        bodies += f"  l{k}: {{mass: {rng.uniform(0.1, 3.0)}, inertia: [0.01, 0.02, 0.015], position: {place}}}\n"
        parent, limits = f"l{k - 3}" if k >= 3 else "trunk", "limits: {angle: {range: [-1, 0], rigid: true}}"
        where = f"location: {at.tolist()}, axis: {axis.tolist()}"
        joints += f"  J{k}: {{type: revolute, bodies: [{parent}, l{k}], {where}, {limits}}}\n"
    return f"mbproj: 1\ngravity: [0, 0, -9.81]\nbodies:\n{bodies}joints:\n{joints}"


@needs_kernel
@pytest.mark.parametrize("formulation", ["reduced", "full"])
def test_nothing_happens_at_limits_that_are_touched(formulation):
    """Noise would press and release them without end: "met and released again and again"."""
    settings = {"duration": 0.5, "tolerance": 1e-8, "integrator": "dopri5", "formulation": formulation}
    done = run_scene(read_scene_text(falling(), "s.yaml", {}, {**settings, "output_step": 0.1}))
    assert done.report.events == 0
    assert np.abs(done["stops/force"]).max() == 0.0
    fallen = done["bodies/position"][-1] - done["bodies/position"][0]
    np.testing.assert_allclose(fallen, np.broadcast_to([0.0, 0.0, -0.5 * 9.81 * 0.25], fallen.shape), atol=1e-12)
