"""An elastic rope on a drum that turns: slack at first, then taut, as signals write it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.kernel.scenes import needs_kernel
from tests.ropes.scenes import G, scene
from tests.stops.runs import run

pytestmark = needs_kernel
WINCH = """
parameters: {stiffness: 4 kN/m, radius: 0.1 m, slack: 0.05 m}
bodies:
  drum: {mass: 5, inertia: [0.03, 0.03, 0.03], position: [0, 0, 0]}
  load: {mass: 2, inertia: [1, 1, 1], position: [0.1, 0, -1]}
joints:
  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: y}
  guide: {type: prismatic, bodies: [ground, load], location: [0.1, 0, -1], axis: z}
  rope:
    type: rope
    free: true
    normal: [0, -1, 0]
    path: [{drum: ground, at: [0, 0, 0], radius: radius, bends: right}, {point: load, at: [0.1, 0, -1]}]
signals:
  longer: rope.length - radius*axle.angle - (1 m + slack)
  pull: stiffness*max(0, longer)
forces:
  rope: {type: linear_spring_damper, joint: rope, coordinate: length, force: -pull}
  drum: {type: torsion_spring_damper, joint: axle, torque: radius*pull}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_it_falls_freely_and_then_swings(formulation):
    """x = g t²/2 by the slack, then e = g/ω² (1 - cos) + v/ω sin of the pull k e, ω² = k (1/m + r²/J)."""
    _, found = run(scene(WINCH, formulation, 0.15))
    t, taut = found["time"], np.sqrt(2.0 * 0.05 / G)
    ω, after = np.sqrt(4000.0 * (1.0 / 2.0 + 0.1**2 / 0.03)), np.maximum(t - taut, 0.0)
    longer = G / ω**2 * (1.0 - np.cos(ω * after)) + G * taut / ω * np.sin(ω * after)
    assert longer.min() >= 0.0 and after[-1] * ω > 2.0
    np.testing.assert_allclose(np.abs(found["forces/force"][:, 0]), 4000.0 * longer, atol=1e-6)
