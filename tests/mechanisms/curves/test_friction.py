"""Dry friction along slots and cams, against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import scene
from tests.stops.runs import run

pytestmark = needs_kernel
#: A bead in a slot that is straight, and then a quarter of a circle of 0.5 m.
BEAD = """
curves: {track: {polyline: [[0, 0], [1, 0], [1, 4]], fillet: 0.5}}
bodies: {bead: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.3, 0, 0], velocity: [2, 0, 0]}}
joints:
  K: {type: KIND, bodies: [ground, bead], curve: track, locations: [[0, 0, 0], [0.3, 0, 0]], axis: [0, -1, 0],
      x_axis: [1, 0, 0], limits: {displacement: {range: [0.1, 3.5], rigid: true}}}
  P: {type: planar, bodies: [ground, bead], location: [0, 0, 0], axis: [0, -1, 0], x_axis: [1, 0, 0]}
forces:
  rubs: {type: friction, joint: K, coulomb: {FRICTION}}
"""


def text(kind, formulation="auto", friction="force: 5 N", **how):
    body = BEAD.replace("KIND", kind).replace("FRICTION", friction)
    return scene(body, formulation, 1.0, "0.05 s", **how).replace("[0, 0, -9.81]", "[0, 0, 0]")


@pytest.mark.parametrize(
    ("kind", "formulation"), [("slot", "planar"), ("slot", "reduced"), ("cam, side: left", "planar")]
)
def test_friction_brings_a_bead_to_rest(kind, formulation):
    """By 5 N: s = v t - F t²/2m until it sticks, on the straight and on the arc alike."""
    _, recorded = run(text(kind, formulation))
    t = np.minimum(recorded["time"], 2.0 * 2.0 / 5.0)
    np.testing.assert_allclose(recorded["joints/coordinate"][:, 0], 0.3 + 2.0 * t - 1.25 * t**2, atol=1e-10)
    assert recorded["friction/state"][-1, 0] == 0.0
    np.testing.assert_allclose(recorded["friction/dissipation"][-1, 0], 4.0, atol=1e-9)


def test_what_a_slot_carries_is_no_measure_of_friction():
    with pytest.raises(InputError, match="friction along a curve does not go by what it carries yet"):
        read_scene_text(text("slot", friction="coefficient: 0.1"))
