"""What falls freely presses nothing, though limits are touched: round-off of accelerations is no force."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.scene.scene import read_scene_text
from tests.crossed import full
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


LIFTED = """\
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 1, integrator: dop853, tolerance: 1e-10, output_step: 0.05}
bodies:
  lifted: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  falls: {mass: 1, inertia: [1, 1, 1], position: [5, 0, 3.2]}
forces:
  pull: {type: force, body: lifted, location: [0, 0, 0], force: [0, 0, 40 * t]}
  table: {type: stop, plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]},
          point: {body: lifted, location: [0, 0, 0]}, rigid: true}
  pad: {type: stop, plane: {body: ground, location: [5, 0, 0], normal: [0, 0, 1]},
        point: {body: falls, location: [5, 0, 3.2]}, stiffness: 1e6 N/m, restitution: 0.5}
"""


@needs_kernel
def test_a_soft_stop_is_met_where_no_rigid_one_touches_any_more():
    """What was round-off of rigid stops counts no longer: it was read for rows that are not there."""
    done = run_scene(read_scene_text(LIFTED, "s.yaml", {}, {}))
    assert done["bodies/position"][-1, 0, 2] == pytest.approx(40 * 0.75**3 / 6, abs=1e-9)
    assert done["bodies/velocity"][-1, 1, 2] == pytest.approx(4.0 - 10 * 0.2, abs=0.05)


CRADLE = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5, integrator: dop853, tolerance: 1e-10}
bodies:
  first: {mass: 1, inertia: [1, 1, 1], position: [-0.3, 0, 0], velocity: [1, 0, 0]}
  second: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  third: {mass: 1, inertia: [1, 1, 1], position: [0.2, 0, 0]}
forces:
  soft: {type: stop, points: {first: [-0.3, 0, 0], second: [0, 0, 0]}, shortest: 0.2, stiffness: 1e4, damping: 0}
  rests: {type: stop, points: {second: [0, 0, 0], third: [0.2, 0, 0]}, shortest: 0.2, stiffness: 1e8, damping: 0}
"""


@needs_kernel
@pytest.mark.parametrize("formulation", ["reduced", full("full")])
def test_balls_that_touch_pass_on_what_a_soft_stop_brings(formulation):
    """Where the one begins to push, neither rate nor acceleration closes the other's gap: the jerk does. The two that
    touch move off as nearly one body of twice the mass."""
    done = run_scene(read_scene_text(CRADLE, "s.yaml", {}, {"formulation": formulation}))
    speeds = done["bodies/velocity"][-1, :, 0]
    assert speeds.sum() == pytest.approx(1.0, abs=1e-9)
    assert (speeds**2).sum() == pytest.approx(1.0, abs=1e-7)
    assert speeds[0] == pytest.approx(-1 / 3, abs=1e-3)
