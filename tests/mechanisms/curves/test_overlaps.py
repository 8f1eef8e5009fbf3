"""Curves that touch and overlap elsewhere: lobes on lobes, where the next pair meets."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import SimulationError, compile_system, initial_guess, read_scene_text
from mbproj.equations.curve_checks import overlapping
from mbproj.equations.kinematics import pose_of
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import scene
from tests.stops.runs import run

pytestmark = needs_kernel
ANGLES = 2.0 * np.pi * np.arange(64) / 64
RADII = 0.1 + 0.004 * np.cos(8.0 * ANGLES)
POINTS = [[float(r * np.cos(a)), float(r * np.sin(a))] for r, a in zip(RADII, ANGLES, strict=True)]
#: Two wheels of eight lobes each.
LOBES = f"""
curves: {{lobes: {{points: {POINTS}, closed: true}}, others: {{points: {POINTS}, closed: true}}}}
bodies:
  a: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}}
  b: {{mass: 2, inertia: [0.08, 0.08, 0.08], position: [0, 0, 0.2035], orientation: {{axis: [0, -1, 0], angle: TURN}}}}
joints:
  A: {{type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, -1, 0]}}
  B: {{type: revolute, bodies: [ground, b], location: [0, 0, 0.2035], axis: [0, -1, 0]}}
  T: {{type: curve_on_curve, bodies: [a, b], curves: [lobes, others], sides: [outside, outside],
      locations: {{a: [0, 0, 0], b: [0, 0, 0]}}, axis: {{a: [0, -1, 0], b: [0, -1, 0]}},
      x_axis: {{a: [1, 0, 0], b: [1, 0, 0]}}}}
"""


@pytest.mark.parametrize(("turn", "overlaps"), [(0.2, True), (0.3, False), (0.4, False), (0.6, True)])
def test_poses_that_overlap(turn, overlaps):
    """A hollow before a lobe leaves them apart; a turn by a quarter of a pitch makes them meet."""
    parsed = read_scene_text(scene(LOBES.replace("TURN", f"{turn}")))
    system = compile_system(parsed)
    found = overlapping(system, pose_of(initial_guess(parsed, system).q))
    assert found == ("T" if overlaps else None)


#: A flat bar that lies on a wheel of eight lobes, and is lifted by it.
BAR = f"""
curves: {{lobes: {{points: {POINTS}, closed: true}}, bar: {{ellipse: [0.15, 0.02]}}}}
bodies:
  wheel: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}}
  bar: {{mass: 2, inertia: [0.08, 0.08, 0.08], position: [0, 0, 0.124]}}
joints:
  A: {{type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, -1, 0]}}
  B: {{type: prismatic, bodies: [ground, bar], location: [0, 0, 0.124], axis: z}}
  T: {{type: curve_on_curve, bodies: [wheel, bar], curves: [lobes, bar], sides: [outside, outside],
      locations: [[0, 0, 0], [0, 0, 0.124]], axis: [0, -1, 0], x_axis: [1, 0, 0]}}
motions: {{spin: {{joint: A, angle: {{expression: SPEED*t}}}}}}
"""


@pytest.mark.parametrize(("formulation", "speed"), [("planar", 1.0), ("reduced", -1.0), full("full", 6.0)])
def test_a_run_stops_where_the_next_lobe_meets_the_bar(formulation, speed):
    """At half a pitch two lobes bear the bar; beyond, the one that bore it at first would draw the other into it."""
    with pytest.raises(SimulationError, match="joint 'T': its curves overlap away from where they touch") as caught:
        run(scene(BAR.replace("SPEED", f"{speed}"), formulation, 1.0, "0.1 s"))
    assert 1.0 < caught.value.time * abs(speed) / (np.pi / 8.0) < 1.25
