"""The pendulum with a motor's inductance and a PID controller, of which others computed the motion."""

from __future__ import annotations

import numpy as np

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from tests.support import DATA, Recorder

PID = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.5 s, output_step: 0.01 s, integrator: dop853, tolerance: 1e-12, formulation: auto}
bodies:
  rod: {mass: 1 kg, inertia: [0.02, 0.02, 0.02], position: [0, 0, -0.4]}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, -1, 0]}
signals:
  error: 1 rad - pin.angle
  U: 20*error + 30*integral - 2*filtered
states:
  integral: {derivative: error, initial: 0 rad*s}
  current: {derivative: (U - 0.8*current - 2*pin.angle_dot)/2e-3, scale: 1 A}
  filtered: {derivative: (pin.angle_dot - filtered)/(10 ms)}
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: 2*current}
"""


def ran(text: str, parameters=(), **simulation):
    """System, recorder and report of a run."""
    scene = read_scene_text(text, "<text>", dict(parameters), simulation)
    system, found = compile_system(scene), Recorder()
    state = assemble(system, initial_guess(scene, system))
    return system, found, simulate(system, state, settings_to_run(scene), found)


def columns(system, found):
    """Angle, rate, current, integral and filtered rate, (T, 5)."""
    names = system.names.states
    states = [found["states/value"][:, names.index(name)] for name in ("current", "integral", "filtered")]
    return np.column_stack([found["joints/coordinate"][:, 0], found["joints/speed"][:, 0], *states])


def reference():
    """What an integration of the equations in five unknowns gives, t and those, (T, 6)."""
    return np.loadtxt(DATA / "elements" / "pid_pendulum.csv", delimiter=",", skiprows=1)
