"""What `check` says of fast forces: whose they are, what they move, and steps that runs hold to."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import SimulationError
from mbproj.commands.python.check import facts, lines
from mbproj.motion.formulations.choice import choose
from mbproj.motion.stiffness import fastest_at, stable_steps
from mbproj.scene.scene import read_scene, read_scene_text
from tests.integrate.stiff_scenes import WHEEL, held_by
from tests.kernel.scenes import assembled
from tests.mechanisms.running import run_scene
from tests.support import ROOT

LINE = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
  b: {mass: 4, inertia: [1, 1, 1], position: [2, 0, 0], velocity: [0.01, 0, 0]}
joints:
  A: {type: prismatic, bodies: [ground, a], location: [0, 0, 0], axis: [1, 0, 0]}
  B: {type: prismatic, bodies: [ground, b], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  hard: {type: spring_damper, points: {ground: [0, 0, 0], a: [1, 0, 0]}, stiffness: 1.0e6}
  soft: {type: spring_damper, points: {ground: [0, 0, 0], b: [2, 0, 0]}, stiffness: 400}
"""


def found(text):
    scene = read_scene_text(text)
    system, state = assembled(scene)
    return fastest_at(choose(system, state, scene.settings), system, state)


def test_forces_and_bodies_by_a_formula():
    """√(k / m): 1000 rad/s of one, 10 rad/s of the other."""
    modes = found(LINE)
    assert [(mode.forces, mode.bodies) for mode in modes] == [(("hard",), ("a",)), (("soft",), ("b",))]
    np.testing.assert_allclose([mode.time_constant for mode in modes], [1e-3, 0.1], rtol=1e-6)
    assert facts(modes, {})["fast_modes"][0]["frequency"] == pytest.approx(1000.0 / (2.0 * np.pi), rel=1e-6)
    assert lines(modes, {"rk4": 2.84e-3})[1:] == [
        "    'hard' on 'a' vibrates with 159 Hz, time constant 1 ms",
        "    'soft' on 'b' vibrates with 1.59 Hz, time constant 100 ms",
        "  stable up to steps of",
        "    rk4  2.84 ms",
    ]


def test_what_only_decays_is_said_to():
    (mode,) = fastest_at(*_wheel("{type: torsion_spring_damper, joint: pin, damping: 30}"))
    assert mode.time_constant == pytest.approx(0.5 / 30.0, rel=1e-9)
    assert lines([mode], {})[1].endswith("decays, time constant 16.7 ms")


def _wheel(force):
    scene = held_by(force, WHEEL)
    system, state = assembled(scene)
    return choose(system, state, scene.settings), system, state


def test_a_scene_without_forces_along_coordinates_has_none():
    scene = read_scene(str(ROOT / "mechanisms" / "double_pendulum.yaml"))
    system, state = assembled(scene)
    assert fastest_at(choose(system, state, scene.settings), system, state) == []
    assert (stable_steps([]), lines([], {})) == ({}, [])


@pytest.mark.parametrize("integrator", ["rk4", "dopri5", "dop853"])
def test_runs_are_stable_up_to_these_steps(integrator):
    """A spring that starts off its length by a millimetre, over 100 steps: `stable_slack` lets each grow by 1 %."""
    text = LINE.replace("stiffness: 1.0e6}", "stiffness: 1.0e6, free_length: 1.001}")
    step = stable_steps(found(text))[integrator]
    largest = []
    for h in (0.98 * step, 1.3 * step):
        scene = read_scene_text(text, "s.yaml", {}, {"integrator": integrator, "step": h, "duration": 100 * h})
        try:
            done = run_scene(scene)
            largest.append(float(np.abs(done["bodies/position"][:, 0, 0] - 1.0).max()))
        except SimulationError:
            largest.append(np.inf)
    assert largest[0] < 0.002 * 1.01**100
    assert largest[1] > 1.0
