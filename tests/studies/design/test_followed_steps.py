"""Runs that follow the steps of another: smooth functions of their numbers, to round-off."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import settings_to_run
from mbproj.base.errors import SimulationError
from mbproj.kernel import core
from mbproj.motion.kernel_run import FollowedSteps
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import SceneText
from mbproj.studies.measure.solve import Mechanism

pytestmark = pytest.mark.skipif(core() is None, reason="no compiled kernel")

#: A pendulum of two bars, which a force pushes from `begins` on.
SCENE = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {length: 1 m, begins: 0.4 s, push: 1 N}
bodies:
  upper: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [length/2, 0, 0]}
  lower: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [3*length/2, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [0, -1, 0]}
  B: {type: revolute, bodies: [upper, lower], location: [length, 0, 0], axis: [0, -1, 0]}
forces:
  wind: {type: force, body: lower, force: ["push*max(t - begins, 0 s)/(1 s)", 0, 0]}
simulation: {duration: 4 s, integrator: dopri5, tolerance: 1.0e-6, output_step: 0.1 s}
"""


class End:
    """The last state of a run."""

    def write(self, block):
        self.q = block["bodies/position"][-1]


def ran(steps, text=SCENE, **parameters):
    """The last positions of a run, and how many steps it took."""
    scene = SceneText(text, "scene").scene(parameters)
    mechanism, end = Mechanism.of(scene), End()
    report = simulate(mechanism.system, mechanism.state, settings_to_run(scene), end, steps=steps)
    end.steps = report.counters["steps"]
    return end


def test_the_same_numbers_give_the_same_run():
    steps = FollowedSteps()
    own = ran(steps)
    assert (len(steps.ends), steps.ends[-1]) == (own.steps, 4.0)
    again = ran(steps.of_another())
    np.testing.assert_allclose(again.q, own.q, rtol=1e-13)  # a size is a difference of times


def test_a_run_beside_it_is_smooth():
    """Fourth differences of a smooth function are of the order of h⁴: none at h = 1e-5. Among runs with steps of their
    own there are some in which a step more is rejected: they jump."""
    steps, text, lengths = FollowedSteps(), SCENE.replace("1.0e-6", "1.0e-3"), 1.0 + 1e-5 * np.arange(-8, 9)
    ran(steps, text)
    rough = {}
    for follows in (True, False):
        ends = [ran(steps.of_another() if follows else None, text, length=length) for length in lengths]
        rough[follows] = np.abs(np.diff([end.q for end in ends], 4, axis=0)).max()
        if follows:
            assert {end.steps for end in ends} == {len(steps.ends)}
    assert rough[True] < 1e-11 < 1e-4 < rough[False]


def test_other_breaks_are_not_followed():
    steps = FollowedSteps()
    ran(steps)
    other = steps.of_another()
    own, free = ran(other, begins=0.5), ran(None, begins=0.5)
    assert other.left
    assert own.q.tobytes() == free.q.tobytes()


@pytest.mark.parametrize("setting", ["step: 0.01 s", "integrator: esdirk4, tolerance: 1.0e-6"])
def test_fixed_steps_and_implicit_ones_are_not_recorded(setting):
    steps = FollowedSteps()
    ran(steps, SCENE.replace("integrator: dopri5, tolerance: 1.0e-6", setting))
    assert not steps.are_recorded


def test_a_step_that_cannot_be_followed_stops_the_run():
    """Far from the numbers that chose them the steps are too long: an angle turns untold."""
    steps = FollowedSteps()
    ran(steps, push=0.0)
    with pytest.raises(SimulationError):
        ran(steps.of_another(), push=1e7)
