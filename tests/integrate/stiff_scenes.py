"""Mechanisms with forces that are stiff for their steps."""

from __future__ import annotations

from mbproj import Scene
from mbproj.scene.scene import read_scene_text

#: A bar that swings on a pin, and a bob of 1 kg that a force holds on it: 1/m + 1/m with the arm, that is turned aside.
PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  arm: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  bob: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [1, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 1, 0]}
  slide: {type: prismatic, bodies: [arm, bob], location: [1, 0, 0], axis: [1, 0, 0]}
"""
#: A wheel of 0.5 kg m² on its pin.
WHEEL = """
mbproj: 1
gravity: [0, 0, 0]
bodies:
  wheel: {mass: 2, inertia: [1, 0.5, 1], position: [0, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], speed: 2, angle: 0.1}
"""

#: A mass of 1 kg that creeps on a spring of 1e8 N/m with its damper, pushed slowly.
CREEP = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5 s, tolerance: 1.0e-6, integrator: auto, output_step: 0.1}
bodies:
  mass: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  bush: {type: linear_spring_damper, joint: rail, force: "1e7*sin(t) - 1e8*displacement - 2e4*displacement_dot"}
"""


def held_by(force: str, base: str = PENDULUM) -> Scene:
    """The mechanism with this force, called 'rod'."""
    return read_scene_text(f"{base}forces:\n  rod: {force}\n")


def rod(stiffness: float = 0.0, damping: float = 0.0) -> Scene:
    """The pendulum with a spring and a damper along its arm."""
    law = f"stiffness: {stiffness!r}, damping: {damping!r}"
    return held_by(f"{{type: linear_spring_damper, joint: slide, {law}}}")


#: A cart is pushed to 0.05 m, where a clamp of 1e8 N/m holds it from 0.5 s to 1 s, and back. A bob swings beside it.
CLAMP = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1.0e-7, integrator: auto, output_step: 0.02}
bodies:
  cart: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  bob: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0.1, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
  wire: {type: prismatic, bodies: [ground, bob], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  push: {type: linear_spring_damper, joint: rail, force: "0.4*sign(1 - t)"}
  coil: {type: linear_spring_damper, joint: wire, force: "-100*(displacement + 0.1)"}
  clamp:
    type: linear_spring_damper
    joint: rail
    force: "-(1e8*(displacement - 0.05) + 2e4*displacement_dot)*(sign(t - 0.5) - sign(t - 1))/2"
"""
