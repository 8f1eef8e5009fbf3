"""Archimedes' trammel: a rod whose ends slide in two straight slots; its points draw ellipses."""

from __future__ import annotations

import numpy as np
import pytest

from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import scene
from tests.stops.runs import run

pytestmark = needs_kernel
LENGTH, RATE, START = 0.5, 3.0, 0.3
#: Free of gravity its centre goes round a circle, so that it turns at a constant rate.
TRAMMEL = f"""
curves: {{track: {{points: [[-1, 0], [-0.5, 0], [0.5, 0], [1, 0]]}}}}
bodies:
  rod:
    mass: 2
    inertia: [0.1, 0.1, 0.1]
    position: [{LENGTH / 2}*cos({START}), 0, {LENGTH / 2}*sin({START})]
    velocity: [-{RATE * LENGTH / 2}*sin({START}), 0, {RATE * LENGTH / 2}*cos({START})]
    angular_velocity: [0, {RATE}, 0]
joints:
  plane: {{type: planar, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
  level: {{type: slot, bodies: [ground, rod], curve: track, axis: [0, -1, 0], x_axis: [1, 0, 0],
    locations: [[0, 0, 0], [{LENGTH}*cos({START}), 0, 0]],
    limits: {{displacement: {{range: [0.1, 1.9], rigid: true}}}}}}
  upright: {{type: slot, bodies: [ground, rod], curve: track, axis: [0, -1, 0], x_axis: [0, 0, 1],
    locations: [[0, 0, 0], [0, 0, {LENGTH}*sin({START})]],
    limits: {{displacement: {{range: [0.1, 1.9], rigid: true}}}}}}
markers:
  pen: {{body: rod, location: {{rod: [0.25*{LENGTH}*cos({START}), 0, -0.25*{LENGTH}*sin({START})]}}}}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_trammel_draws_an_ellipse(formulation):
    text = scene(TRAMMEL, formulation, 2.5, "0.05 s").replace("[0, 0, -9.81]", "[0, 0, 0]")
    _, recorded = run(text)
    angle = START + RATE * recorded["time"]
    pen = recorded["markers/position"][:, 0]
    expected = [0.75 * LENGTH * np.cos(angle), 0.0 * angle, 0.25 * LENGTH * np.sin(angle)]
    np.testing.assert_allclose(pen.T, expected, atol=1e-11)
    along = recorded["joints/coordinate"][:, [3, 4]] - 1.0
    np.testing.assert_allclose(along.T, [LENGTH * np.cos(angle), LENGTH * np.sin(angle)], atol=1e-11)
