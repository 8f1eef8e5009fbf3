"""Runs with the energy balance and momenta as rows of the velocity projection."""

from __future__ import annotations

from typing import Any

from mbproj import Report
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.scene.settings import settings_to_run, with_options
from tests.support import ROOT, Recorder

SCENES = ROOT / "mechanisms"
FIXED = {"step": 0.01, "integrator": "rk4"}
CONTROLLED = {"tolerance": 1e-9, "integrator": "dop853"}
IMPLICIT = {"tolerance": 1e-6, "integrator": "esdirk4"}

#: A pendulum that never rests, with a torque, a damper and a spring; a motor's motion drives a cart below it.
WORKED = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {duration: 1 s, step: 0.01, output_step: 0.05}
bodies:
  cart: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  bar: {mass: 2 kg, inertia: [0.01, 0.2, 0.2], position: [0.5, 0, 0], angular_velocity: [0, 0, 9]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
  pin: {type: revolute, bodies: [cart, bar], location: [0, 0, 0], axis: [0, 0, 1]}
motions:
  shake: {joint: rail, displacement: "0.1*sin(3*t)"}
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: "2*cos(angle)"}
  coil: {type: torsion_spring_damper, joint: pin, stiffness: 5, damping: 0.1}
"""


def run(scene: str, parameters: dict[str, str] | None = None, **options: Any) -> tuple[Report, Recorder]:
    """Of a scene of ours, or of a text."""
    options = {name: str(value) for name, value in options.items()}
    given = parameters or {}
    what = read_scene_text(scene) if "\n" in scene else read_scene(SCENES / f"{scene}.yaml", given)
    what = with_options(what, options)
    system = compile_system(what)
    state = assemble(system, initial_guess(what, system))
    recorder = Recorder()
    return simulate(system, state, settings_to_run(what), recorder), recorder
