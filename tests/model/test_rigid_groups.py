"""Bodies that fixed joints make one, and those that stay two."""

from __future__ import annotations

import numpy as np

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from tests.crossed import crossed
from tests.kernel.scenes import needs_kernel
from tests.support import Recorder

#: A pendulum in the plane normal to [0.6, 0, 0.8] of two bodies welded together, which a ball joins once more.
WELDED = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {{duration: 0.1, step: 2 ms, output_step: 20 ms, formulation: {formulation}}}
bodies:
  a: {{mass: 1, inertia: [0.1, 0.2, 0.15], position: [0.5, 0, 0]}}
  b: {{mass: 60, inertia: [9, 8, 7], position: [1, 0, 0.3], orientation: {{axis: [1, 2, 3], angle: 0.4}}}}
  c: {{mass: 2, inertia: [0.1, 0.2, 0.15], position: [0.2, 1, 0]}}
joints:
  slide: {{type: planar, bodies: [ground, a], location: [0.2, 0.1, 0.7], axis: [0.6, 0, 0.8]}}
  weld: {{type: fixed, bodies: [a, b], location: [0.7, 0, 0.1]}}
  end: {{type: fixed, bodies: [a, c], location: [0.7, 0, 0.1]}}
{ball}
"""
BALL = "  ball: {type: spherical, bodies: [%s, b], location: [0.83, -0.11, -0.87]}"


def run(formulation: str, ball: str) -> tuple[Recorder, int, int]:
    """What was recorded, bodies that move, and degrees of freedom."""
    scene, recorder = read_scene_text(WELDED.format(formulation=formulation, ball=ball)), Recorder()
    system = compile_system(scene)
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    return recorder, system.bodies, report.degrees_of_freedom


@needs_kernel
@crossed("end, formulation", ["a", "c"], ["full", "reduced", "planar"], dear=["full"])
def test_a_joint_across_a_weld_changes_nothing(formulation, end):
    """Its rows would hold one body to itself: the welded bodies stay apart, and the rows are redundant for good."""
    one, bodies, freedom = run(formulation, "")
    assert (bodies, freedom) == (1, 3)
    several, bodies, freedom = run(formulation, BALL % end)
    assert (bodies, freedom) == (3, 3)
    for path in ("bodies/position", "bodies/velocity", "bodies/acceleration"):
        np.testing.assert_allclose(several[path], one[path], rtol=0, atol=1e-11)
