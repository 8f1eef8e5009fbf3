"""A rope that rubs on a sheave: half a turn around a light wheel whose pin rubs, T2 = T1 e^{μπ}."""

from __future__ import annotations

import numpy as np
import pytest

from tests.kernel.scenes import needs_kernel
from tests.stops.runs import DOP853, run

pytestmark = needs_kernel
HALF_TURN = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {SETTINGS, duration: 0.5}
parameters: {heavy: 3.0, mu: 0.3}
bodies:
  wheel: {mass: 1.0e-6, inertia: [1.0e-9, 1.0e-9, 1.0e-9], position: [0, 0, 0]}
  left: {mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [-0.1, 0, -1]}
  right: {mass: heavy, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.1, 0, -1]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0]}
  one: {type: prismatic, bodies: [ground, left], location: [-0.1, 0, -1], axis: [0, 0, 1]}
  other: {type: prismatic, bodies: [ground, right], location: [0.1, 0, -1], axis: [0, 0, 1]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: left, at: [-0.1, 0, -1]}
      - {wheel: wheel, radius: 0.1, bends: right}
      - {point: right, at: [0.1, 0, -1]}
forces:
  rubs: {type: friction, joint: pin, coulomb: {coefficient: tanh(0.5*mu*pi), radius: 0.1}}
""".replace("SETTINGS", DOP853)


@pytest.mark.parametrize("heavy", [3.0, 4.5])
def test_it_slips_with_the_ratio_of_the_capstan_equation(heavy):
    """a = g (m2 - m1 e^{μπ}) / (m2 + m1 e^{μπ}), and the tensions are as 1 to e^{μπ}."""
    _, found = run(HALF_TURN, heavy=heavy)
    ratio = np.exp(0.3 * np.pi)
    fall = 10.0 * (heavy - ratio) / (heavy + ratio)
    way = found["joints/coordinate"][:, 2]
    np.testing.assert_allclose(way, -0.5 * fall * found["time"] ** 2, atol=2e-5)
    first, second = found["ropes/tension"][1:].T
    np.testing.assert_allclose(second / first, ratio, rtol=1e-5)


@pytest.mark.parametrize("heavy", [0.45, 2.5])
def test_it_holds_below(heavy):
    """e^{0.3 π} = 2.566: the heavier weight hangs, whichever side it is on, and the tensions are the weights."""
    _, found = run(HALF_TURN, heavy=heavy)
    np.testing.assert_allclose(found["joints/coordinate"][:, 1:3], 0.0, atol=1e-9)
    np.testing.assert_allclose(found["ropes/tension"][-1], [10.0, 10.0 * heavy], rtol=1e-8)
