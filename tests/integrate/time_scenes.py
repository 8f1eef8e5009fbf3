"""Scenes whose forces and motions begin, end or jump at known times."""

from __future__ import annotations

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.support import Recorder

#: A rotor that turns freely about the y axis by a torque: I θ'' = τ.
INERTIA = 0.5
ROTOR = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {rotor: {mass: 1, inertia: [0.3, 0.5, 0.4], position: [0, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0, 1, 0]}}
forces: {push: {type: torsion_spring_damper, joint: pin, torque: "TORQUE"}}
simulation: {duration: 2 s}
"""
#: A trolley with a load that hangs from it at rest until the trolley moves.
TROLLEY = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  trolley: {mass: 10, inertia: [1, 1, 1], position: [0, 0, 0]}
  load: {mass: 5, inertia: [0.01, 0.01, 0.01], position: [0, 0, -2]}
joints:
  rail: {type: prismatic, bodies: [ground, trolley], location: [0, 0, 0], axis: [1, 0, 0]}
  hook: {type: revolute, bodies: [trolley, load], location: [0, 0, 0], axis: [0, 1, 0]}
motions: {move: {joint: rail, displacement: {smooth_step: {to: 0.5, start: 3, duration: 0.2}}}}
markers: {load: {body: load, location: [0, 0, -2]}}
simulation: {duration: 10 s, tolerance: 1.0e-8, integrator: dop853, output_step: 1}
"""


def rotor(torque: str) -> str:
    return ROTOR.replace("TORQUE", torque)


def run(text: str, **options: str):
    """(recorder, report) of a scene with these options of the command line."""
    scene = read_scene_text(text, simulation=options)
    system = compile_system(scene)
    recorder = Recorder()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    return recorder, report
