"""Contacts as a border on the joints' factor: their operator is that of the whole equations, and what they hold does
not accelerate."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.constraints import set_bias, set_jacobian
from mbproj.equations.contacts import Freedom
from mbproj.equations.derivatives import MotionAtTime, tangent_force
from mbproj.equations.motions import drive_at
from mbproj.equations.rank.row_space import tangent_gamma
from mbproj.equations.tangent_space import tangent_velocities
from mbproj.kernel import core
from mbproj.model.contacts import Contacts, in_contact
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.reduced import Reduced
from tests.kernel.scenes import needs_kernel
from tests.stops.scenes import SCENE

pytestmark = needs_kernel

#: A slider-crank that turns, in the plane, with a stop at its slider, one at its rocker's angle, and a rope.
LOOP = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {duration: 1, step: 1 ms}
bodies:
  crank: {mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.05, 0, 0]}
  rod: {mass: 2, inertia: [7.0e-3, 7.0e-3, 7.0e-3], position: [0.25, 0, 0]}
  slider: {mass: 3, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.4, 0, 0]}
  weight: {mass: 0.5, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.4, -0.2, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1], angle: 50 deg, speed: 4}
  B: {type: revolute, bodies: [crank, rod], location: [0.1, 0, 0], axis: [0, 0, 1]}
  C: {type: revolute, bodies: [rod, slider], location: [0.4, 0, 0], axis: [0, 0, 1]}
  D:
    type: prismatic
    bodies: [ground, slider]
    location: [0.4, 0, 0]
    axis: [1, 0, 0]
    limits: {displacement: {range: [null, 1], rigid: true}}
  P:
    type: revolute
    bodies: [slider, weight]
    location: [0.4, 0, 0]
    axis: [0, 0, 1]
    speed: 3
    limits: {angle: {range: [-3, 3], rigid: true}}
forces:
  rope: {type: stop, points: {ground: [0, -1, 0], weight: [0.4, -0.2, 0]}, longest: 5 m, rigid: true}
"""

#: A door, a block and a ball on its way, with stops between them.
THROWN = SCENE.replace("position: [2, 0, 1.3],", "position: [2, 0, 1.3], velocity: [1, -2, 0.5],")


def opened(text, formulation):
    """The mechanism, a state of it, and what runs it in the kernel."""
    scene = read_scene_text(text)
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    return system, state, choose(system, state, Settings(duration=1.0, step=1e-3, formulation=formulation)).compiled


def gap_accelerations(freedom):
    """g'' of the gaps (S,) where no stop acts, by minimal coordinates."""
    system, state, pose, twist = freedom.system, freedom.state, freedom.pose, freedom.twist
    along, counted = system.stops.coordinates, coordinate_values(system, pose) + 2.0 * np.pi * state.turns
    change = freedom.smallest @ tangent_gamma(system, pose, twist, drive_at(system, state.t))
    moving = MotionAtTime(state.t, state.q, tangent_velocities(pose, state.v), change, counted, state.x)
    change = change + freedom.basis @ (freedom.basis.T @ tangent_force(system, moving))
    kept = np.zeros((system.bodies, 7))  # the part of Λ'' that keeps |Λ| is -|Λ'|² Λ
    kept[:, 3:] = -np.sum(twist.rate[:-1] ** 2, axis=1, keepdims=True) * pose.orientation[:-1]
    bias = set_bias(along, pose, twist) + set_jacobian(along, pose) @ kept.ravel()
    return system.stops.side * (freedom.gradients_of(along) @ change + bias)


CASES = [(LOOP, "planar", [0, 3]), (LOOP, "reduced", [0, 3]), (THROWN, "reduced", [1, 2, 5])]


@pytest.mark.parametrize(("text", "formulation", "which"), CASES)
def test_the_operator_is_that_of_the_whole_equations(text, formulation, which):
    """B = N (W⁻¹ - W⁻¹GᵀS⁻¹GW⁻¹) Nᵀ, and the gaps' accelerations without contact."""
    system, state, compiled = opened(text, formulation)
    freedom = Freedom.at(system, state)
    N = freedom.rows(system.stops)[which]
    b = gap_accelerations(freedom)[which]
    rows = [(k, float(system.stops.side[k])) for k in which]
    found, free = compiled.equations().border(compiled.state(state.q, state.v), rows)
    size = np.sqrt(np.diagonal(N @ N.T))
    np.testing.assert_allclose(found / np.outer(size, size), N @ N.T / np.outer(size, size), atol=1e-12)
    np.testing.assert_allclose(found, found.T, rtol=0, atol=1e-13 * size.max() ** 2)
    np.testing.assert_allclose(free, b, rtol=0, atol=1e-11 * np.abs(b).max())


@pytest.mark.parametrize(("text", "formulation", "which"), CASES)
def test_what_contacts_hold_does_not_accelerate(text, formulation, which):
    """The accelerations are those of a mechanism whose joints have these rows."""
    system, state, compiled = opened(text, formulation)
    equations, y = compiled.equations(), compiled.state(state.q, state.v)
    rows = [(k, float(system.stops.side[k])) for k in which]
    equations.border(y, rows)
    acceleration, multipliers = equations.accelerations(y)
    held = Reduced(core(), in_contact(system, Contacts(tuple(which))))
    expected, expected_multipliers = held.equations().accelerations(held.state(state.q, state.v))
    at = system.joints.size
    if formulation == "planar":
        found = compiled.acceleration(y[None], acceleration[None])
        expected = held.acceleration(held.state(state.q, state.v)[None], expected[None])
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())
        return
    np.testing.assert_allclose(acceleration, expected, rtol=0, atol=1e-10 * np.abs(expected).max())
    assert len(expected_multipliers) == len(multipliers) + len(which)
    joints = np.delete(expected_multipliers, np.arange(at, at + len(which)))
    np.testing.assert_allclose(multipliers, joints, rtol=0, atol=1e-10 * np.abs(joints).max())


def test_rows_that_depend_on_each_other_are_seen():
    """Both ends of one range: the second row is the first with the other sign, and no push is unique."""
    _, state, compiled = opened(LOOP, "planar")
    equations, y = compiled.equations(), compiled.state(state.q, state.v)
    assert equations.border(y, [(1, 1.0), (0, -1.0)]) is not None
    assert equations.border(y, [(1, 1.0), (0, -1.0), (2, -1.0)]) is None
