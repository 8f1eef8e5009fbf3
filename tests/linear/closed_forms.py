"""Scenes whose linear motion has a closed form, and a way to their modes."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.equilibrium.steady import refuse_unsteady, steady_turn
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.scene.scene import read_scene_text

g = 9.81
HEAD = "mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {duration: 1 s, step: 1 ms}\n"


def under_gravity(text: str) -> str:
    """The scene with these bodies, joints and forces, which runs for 1 s."""
    return HEAD + text


def weightless(text: str) -> str:
    """The same, without gravity."""
    return HEAD.replace("-9.81", "0") + text


def modes_of(text, count=None, **parameters):
    """The modes at the start of a scene."""
    scene = read_scene_text(text, parameters={name: repr(value) for name, value in parameters.items()})
    system = compile_system(scene)
    return modes(reference_at(system, assembled_start(scene, system), "start"), count)


def turning(text, speed, name="A.angle"):
    """The steady turn of a scene, in which a coordinate grows at this speed."""
    scene = read_scene_text(text)
    system = compile_system(scene)
    start = assembled_start(scene, system)
    turn, held = steady_turn(system, start, name, speed)
    found = equilibrium(system, start, 0.0, turn, held)
    refuse_unsteady(found, turn, held)
    return found


def chain(links, length=1.0, mass=1.0):
    """A chain of thin bars that hangs at rest, on parallel pins."""
    part, weight = length / links, mass / links
    inertia = weight * part**2 / 12
    bodies, joints = [], []
    for i in range(links):
        place = f"position: [0, 0, {-(i + 0.5) * part!r}]"
        bodies.append(f"  b{i}: {{mass: {weight!r}, inertia: [{inertia!r}, {inertia!r}, 1.0e-12], {place}}}\n")
        before = f"b{i - 1}" if i else "ground"
        joints.append(
            f"  j{i}: {{type: revolute, bodies: [{before}, b{i}], location: [0, 0, {-i * part!r}], axis: [0, 1, 0]}}\n"
        )
    return HEAD + "bodies:\n" + "".join(bodies) + "joints:\n" + "".join(joints)


def chain_frequencies(links, length=1.0, mass=1.0):
    """Angular frequencies of that chain from its own equations in the bars' angles, the slowest first."""
    part, weight = length / links, mass / links
    beyond = links - 1 - np.arange(links)
    M = weight * part**2 * (beyond[np.maximum.outer(np.arange(links), np.arange(links))] + 0.5)
    np.fill_diagonal(M, weight * part**2 * (beyond + 1 / 3))
    K = np.diag(weight * g * part * (beyond + 0.5))
    return 1.0 / np.sqrt(eigh(M, K, eigvals_only=True)[::-1])


TOP = under_gravity("""\
parameters: {spin: 100}
bodies:
  top: {mass: 0.5, inertia: [0.002, 0.002, 0.0008], position: [0, 0, 0.1], angular_velocity: [0, 0, spin]}
joints:
  foot: {type: spherical, bodies: [ground, top], location: [0, 0, 0]}
""")

#: A rotor whose ends are drawn outwards by springs without free length, so that they pull sideways in proportion.
LAVAL = weightless("""\
parameters: {spin: 200 rad/s}
bodies:
  rotor: {mass: 3, inertia: [0.02, 0.02, 0.03], position: [0, 0, 0], angular_velocity: [0, 0, spin]}
forces:
  up: {type: spring_damper, points: {ground: [0, 0, 0.5], rotor: [0, 0, 0.2]}, stiffness: 1000, free_length: 0}
  down: {type: spring_damper, points: {ground: [0, 0, -0.5], rotor: [0, 0, -0.2]}, stiffness: 1000, free_length: 0}
""")
