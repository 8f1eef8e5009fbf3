"""Equilibria and small motions on stops: compliant ones carry, rigid ones are refused by name."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.equilibrium.start import observed, start_state
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from tests.stops.runs import Recorded

#: A block of 2 kg on a vertical slide, above a stop, with a spring that holds it where SPRING says so.
BLOCK = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 1, step: 1 ms}
bodies:
  block: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  slide:
    type: prismatic
    bodies: [ground, block]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    displacement: 0
    limits: {displacement: {range: [-0.1, null], LAW}}
SPRING
"""
SPRING = "forces: {coil: {type: linear_spring_damper, joint: slide, stiffness: 100}}"


def assembled(law, spring=""):
    scene = read_scene_text(BLOCK.replace("LAW", law).replace("SPRING", spring))
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system))


@pytest.mark.parametrize(("exponent", "depth"), [(1, 20.0 / 1e4), (1.5, (20.0 / 1e4) ** (1 / 1.5)), (2, 0.002**0.5)])
def test_a_compliant_stop_carries_the_weight(exponent, depth):
    found = equilibrium(*assembled(f"stiffness: 1.0e4, exponent: {exponent}, restitution: 0.5"))
    block = observed(found)
    assert block["stops/gap"][0, 0] == pytest.approx(-depth, rel=1e-9)
    assert block["stops/force"][0, 0] == pytest.approx(20.0, rel=1e-9)
    stiffness = exponent * 1e4 * depth ** (exponent - 1)
    (frequency,) = np.abs(modes(found.reference).eigenvalues[:1])
    assert frequency == pytest.approx(np.sqrt(stiffness / 2.0), rel=1e-9)


def test_what_does_not_touch_does_not_act():
    found = equilibrium(*assembled("stiffness: 1.0e4", SPRING.replace("100", "1000")))
    assert observed(found)["joints/coordinate"][0, 0] == pytest.approx(-0.02, rel=1e-9)
    assert observed(found)["stops/force"][0, 0] == 0.0


def test_an_equilibrium_beyond_a_rigid_stop_is_none():
    with pytest.raises(InputError, match=r"0\.1 m beyond the rigid stop 'slide.displacement.low'"):
        equilibrium(*assembled("rigid: true", SPRING))


def test_rigid_stops_hold_nothing_in_an_equilibrium_and_that_is_said():
    with pytest.raises(NoEquilibrium, match="rigid stops hold nothing here"):
        equilibrium(*assembled("rigid: true"))


def test_a_rigid_stop_that_touches_has_no_linear_part():
    scene = read_scene_text(BLOCK.replace("LAW", "rigid: true").replace("SPRING", "").replace("-0.1, null", "0, null"))
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    with pytest.raises(InputError, match=r"the rigid stop 'slide.displacement.low' touches at this pose"):
        modes(reference_at(system, state, "start"))


def test_a_run_from_the_equilibrium_stays_there():
    text = BLOCK.replace("LAW", "stiffness: 1.0e4, restitution: 0.5").replace("SPRING", "")
    scene = read_scene_text(text.replace("step: 1 ms", "step: 1 ms, start: equilibrium"))
    system, recorded = compile_system(scene), Recorded()
    simulate(system, start_state(scene, system), settings_to_run(scene), recorded)
    assert recorded["stops/gap"][:, 0] == pytest.approx(-20.0 / 1e4, abs=1e-12)
    assert recorded["stops/force"][:, 0] == pytest.approx(20.0, rel=1e-9)
