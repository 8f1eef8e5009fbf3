"""Slopes by dual numbers beside differences of runs, over what a scene may hold; what they do not follow is said."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.base.mechanisms_folder import mechanism
from mbproj.studies.design.slopes import DifferenceWork, differences
from tests.crossed import full
from tests.kernel.scenes import needs_kernel

pytestmark = needs_kernel

#: Two bodies on a rail and a hinge; what acts on them is added. The numbers `a` and `b` are those of that.
HEAD = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {{{parameters}}}
bodies:
  cart: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
  bob: {{mass: 1, inertia: [0.02, 0.03, 0.02], position: [0.5, 0, 0]}}
joints:
  rail: {{type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}}
  pin: {{type: revolute, bodies: [cart, bob], location: [0, 0, 0], axis: [0, -1, 0]}}
simulation: {{duration: 0.6 s, tolerance: 1.0e-9, integrator: dop853, output_step: 0.05 s}}
expect:
  way: {{joint: rail, quantity: displacement, at: end, below: 100 m, source: differences}}
  turn: {{joint: pin, quantity: angle_speed, at: 0.35 s, below: 100 rad/s, source: differences}}
  load: {{joint: pin, quantity: reaction_force, component: norm, at: largest, below: 1.0e6 N, source: differences}}
"""
#: By what acts: the parameters, and the blocks.
ACTS = {
    "spring": (
        "a: 40 N/m, b: 2 N*s/m",
        "forces: {f: {type: linear_spring_damper, joint: rail, stiffness: a, damping: b}}",
    ),
    "law of its own": (
        "a: 3, b: 2",
        "forces: {f: {type: linear_spring_damper, joint: rail, force: a*sin(b*x) - 0.3*v}}\n"
        "signals: {x: rail.displacement, v: rail.displacement_dot}",
    ),
    "force of time": (
        "a: 5 N, b: 4 rad/s",
        "forces: {f: {type: force, body: bob, location: [0.5, 0, 0], force: [a*sin(b*t), 0, a*cos(b*t)]}}",
    ),
    "motion": ("a: 0.2 m, b: 5 rad/s", "motions: {m: {joint: rail, displacement: a*sin(b*t)}}"),
    "bushing": (
        "a: 2000 N/m, b: 30 N*m/rad",
        "forces: {f: {type: bushing, bodies: [ground, bob], location: [0.5, 0, 0], stiffness: "
        "{translation: [a, a, a], rotation: [b, b, b]}}}",
    ),
    "state": (
        "a: 3 N, b: 0.1 s",
        "states: {x: {derivative: (sin(7 1/s*t) - x)/b, initial: 0.2}}\n"
        "forces: {f: {type: linear_spring_damper, joint: rail, force: a*x}}",
    ),
}


def apart(scene, found):
    """By how much slopes differ from those by differences, less what these may be off by and 1e-6 of themselves."""
    work = DifferenceWork(scene, scene.settings, found.paths, found.measures)
    other = differences(work, found.x, np.where(found.x == 0.0, 1.0, np.abs(found.x)), 1)
    assert np.abs(other.slopes).max() > 0.0
    return np.max(np.abs(found.slopes - other.slopes) - other.uncertainty - 1e-6 * np.abs(other.slopes))


@pytest.mark.parametrize("name", ACTS)
def test_of_what_acts(name):
    parameters, blocks = ACTS[name]
    scene = mbproj.read_scene_text(HEAD.format(parameters=parameters) + blocks + "\n")
    found = mbproj.sensitivity(scene, jobs=1)
    assert not any(map(any, found.why))
    assert np.all(np.abs(found.elasticity).max(axis=0) > 1e-4)
    assert apart(scene, found) <= 0.0


@pytest.mark.parametrize(
    ("name", "to", "of"),
    [
        full("differential", "ice,road", ""),  # gears
        ("governor", "ball,arm", ""),  # loops in space
        full("rolling_coin", "R,m", ""),  # rows of velocities
        ("chaplygin_sleigh", "a,J", ""),
        ("hoist", "g,load", ""),  # a rope around pulleys
        full("planar_four_bar", "crank,speed", ""),
        full("spatial_four_bar", "rocker", ""),  # loops with a motion
    ],
)
def test_of_mechanisms(name, to, of):
    scene = mbproj.read_scene(mechanism(name))
    found = mbproj.sensitivity(scene, to=to, jobs=1)
    assert not any(map(any, found.why))
    assert apart(scene, found) <= 0.0


@pytest.mark.parametrize(
    ("name", "to", "why"),
    [
        ("hoist", "radius", "a rope's path"),
        ("door_with_stop", "width", "stops or dry friction"),
    ],
)
def test_what_they_do_not_follow_is_said(name, to, why):
    found = mbproj.sensitivity(mbproj.read_scene(mechanism(name)), to=to, jobs=1)
    assert why in found.why[0][0]
    assert {(row[-2], why in row[-1]) for row in found.table.rows} == {("differences", True)}


def test_instants_that_move_are_said():
    """A force that sets in at `a`: its kink is where steps end."""
    blocks = 'forces: {f: {type: linear_spring_damper, joint: rail, force: "-9*max(t - a, 0)"}}\n'
    text = HEAD.format(parameters="a: 0.2, b: 3") + blocks
    found = mbproj.sensitivity(mbproj.read_scene_text(text), to="a", of="way", jobs=1)
    assert found.why[0][0].startswith("it moves instants")
    assert found.slopes[0, 0] > 0.0


def test_one_measure_that_is_no_state_goes_by_differences_alone():
    """Energy that dampers lose is found along the run: E + D = k s²/2, with s = 1 m at the start."""
    text = HEAD.format(parameters="k: 50, c: 0.7") + (
        "forces: {f: {type: linear_spring_damper, joint: rail, stiffness: k, damping: c, free_displacement: -1}}\n"
    )
    ends = "at: end, below: 100, source: energy"
    text = text.replace(
        "expect:", f"expect:\n  lost: {{diagnostic: dissipation, {ends}}}\n  left: {{diagnostic: total_energy, {ends}}}"
    )
    found = mbproj.sensitivity(mbproj.read_scene_text(text), to="k,c", of="lost,left", jobs=1)
    assert found.why == (("'diagnostics/dissipation' is no function of the state",) * 2, ("", ""))
    assert found.slopes.sum(axis=0) == pytest.approx([0.5, 0.0], abs=1e-9)
    assert np.abs(found.slopes).min() > 1e-3
