"""No choice of rows depends on where a run begins: from any state that a run has reached the motion is the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import Scene, read_scene
from mbproj.base.settings import Settings
from mbproj.kernel import core
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene_text
from tests.kernel.scenes import assembled, needs_kernel
from tests.support import ROOT, Recorder

pytestmark = needs_kernel
FOREVER = 100.0
#: A crank and a rocker of 0.2 m, with two couplers beside each other in planes y = 0 and y = 0.1 m: hinges throughout.
TWO_COUPLERS = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 0.01}
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.002], position: [0, 0, 0.1]}
  rocker: {mass: 2, inertia: [0.02, 0.02, 0.002], position: [0.5, 0, 0.1]}
  near: {mass: 0.5, inertia: [0.001, 0.01, 0.01], position: [0.25, 0, 0.2]}
  far: {mass: 0.7, inertia: [0.001, 0.02, 0.02], position: [0.25, 0.1, 0.15]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: y, speed: 9}
  B: {type: revolute, bodies: [ground, rocker], location: [0.5, 0, 0], axis: y}
  C: {type: revolute, bodies: [crank, near], location: [0, 0, 0.2], axis: y}
  D: {type: revolute, bodies: [near, rocker], location: [0.5, 0, 0.2], axis: y}
  E: {type: revolute, bodies: [crank, far], location: [0, 0.1, 0.15], axis: y}
  F: {type: revolute, bodies: [far, rocker], location: [0.5, 0.1, 0.15], axis: y}
"""


def restarted(name: str) -> Scene:
    """A scene with redundant rows: a shipped mechanism, or the two couplers."""
    shipped = ROOT / "mechanisms" / f"{name}.yaml"
    return read_scene_text(TWO_COUPLERS) if name == "two couplers" else read_scene(shipped)


def compiled_of(scene: Scene):
    """In the kernel, with its usual rows, and its start."""
    system, state = assembled(scene)
    compiled = Reduced(core(), system)
    settle_rows(compiled, state)
    return compiled, state


@pytest.mark.parametrize("name", ["bricard", "bennett", "n_four_bar", "locomotive", "two couplers"])
def test_the_usual_rows_are_those_of_the_scene_wherever_it_starts(name):
    """Walks from other poses of the motion found other rows, or other pivots, by which a step takes other rows."""
    compiled, state = compiled_of(restarted(name))
    block = compiled.run(state, Settings(duration=0.5, step=1 / 128)).advance(1000, FOREVER)
    rows = compiled.model.rows
    assert rows.redundant > 0
    for at in (13, 40, 64):
        there = compiled.samples(block, {}).state(at)
        assert settle_rows(compiled, there) == rows.redundant
        now = compiled.model.rows
        assert (now.left_out, now.pivots, now.even) == (rows.left_out, rows.pivots, rows.even)


@pytest.mark.parametrize("name", ["bricard", "bennett", "two couplers"])
def test_a_run_from_a_state_that_a_run_has_reached_is_the_same_motion(name):
    """In everything that a user's restart does anew, by `simulate`. It went its own way after some steps, by 3e-5 m."""
    scene, step, steps = restarted(name), 0.01, 90
    system, state = assembled(scene)
    settings = replace(scene.settings, step=step, tolerance=None, integrator="rk4", formulation="reduced")
    settings = replace(settings, duration=steps * step, output_step=step)
    whole = Recorder()
    simulate(system, state, settings, whole)
    for at in (7, 23, 41, 58):
        reached = simulate(system, state, replace(settings, duration=at * step), Recorder()).state
        again = Recorder()
        simulate(system, reached, replace(settings, duration=(steps - at) * step), again)
        apart = np.abs(again["bodies/position"] - whole["bodies/position"][at:])
        assert apart.max() < 1e-12


def test_a_scene_whose_bodies_start_at_a_recorded_state_has_the_motion_of_the_run():
    scene, step, steps = restarted("bricard"), 0.01, 60
    system, state = assembled(scene)
    settings = replace(scene.settings, step=step, tolerance=None, integrator="rk4", formulation="reduced")
    whole = Recorder()
    simulate(system, state, replace(settings, duration=steps * step, output_step=step), whole)
    for at in (13, 37):
        place, turn, v, w = (
            whole[f"bodies/{each}"][at] for each in ("position", "orientation", "velocity", "angular_velocity")
        )
        bodies = tuple(
            replace(body, start=(tuple(r), tuple(q)), velocity=tuple(own), angular_velocity=tuple(spin))
            for body, r, q, own, spin in zip(scene.bodies, place, turn, v, w, strict=True)
        )
        joints = tuple(replace(joint, speed={}) for joint in scene.joints)
        system, state = assembled(replace(scene, bodies=bodies, joints=joints))
        again = Recorder()
        simulate(system, state, replace(settings, duration=(steps - at) * step, output_step=step), again)
        assert np.abs(again["bodies/position"] - whole["bodies/position"][at:]).max() < 1e-12


def test_where_the_scene_draws_no_closed_mechanism_the_start_tells_the_rows():
    """Its bars are drawn where no pose closes; bodies' poses at the start close it."""
    compiled, state = compiled_of(restarted("bricard"))
    broken = replace(compiled.system, drawn=np.where(np.arange(35) % 7 < 3, 1e3, compiled.system.drawn))
    other = Reduced(core(), broken)
    assert settle_rows(other, state) == 1
    assert other.model.rows.left_out
