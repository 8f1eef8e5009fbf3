"""A wheel and a slide, each on a joint to the ground, that elements couple and drive; and two slides."""

from __future__ import annotations

from mbproj.dynamics import assemble
from mbproj.integrate import simulate
from mbproj.kernel import core
from mbproj.model import compile_system, initial_guess, with_elements
from mbproj.scene import read_scene_text, settings_to_run
from tests.crossed import full
from tests.support import Recorder

FORMULATIONS = ["full", *(["reduced", "planar"] if core() is not None else [])]
#: Where the full one, in NumPy, takes a second or more and another test has it with such elements.
SELDOM_FULL = [full("full"), *FORMULATIONS[1:]]
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, output_step: 0.1, tolerance: 1e-11, integrator: dop853}
bodies:
  wheel: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  slide: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.3]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], SPEED}
  rail: {type: prismatic, bodies: [ground, slide], location: [0, 0, 0.3], axis: AXIS, speed: SLIDE}
"""
#: Two slides beside one another, with GRAVITY and FORCES.
TWO_SLIDES = """
mbproj: 1
gravity: [0, 0, GRAVITY]
simulation: {duration: 0.5, output_step: 0.05, tolerance: 1e-11, integrator: dop853}
bodies:
  left: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0, 0, -1]}
  right: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [1, 0, -1.5]}
joints:
  a: {type: prismatic, bodies: [ground, left], location: [0, 0, -1], axis: [0, 0, 1]}
  b: {type: prismatic, bodies: [ground, right], location: [1, 0, -1.5], axis: [0, 0, 1]}
markers:
  one: {body: left, location: [0, 0, -1]}
  two: {body: right, location: [1, 0, -1.5]}
  low: {body: left, location: [0, 0, -1.2]}
FORCES
"""
AXES = {"x": "[1, 0, 0]", "z": "[0, 0, 1]"}


def scene_of(axis="x", speed="speed: 0", slide=None, **options):
    text = SCENE.replace("AXIS", AXES[axis]).replace("SPEED", speed)
    text = text.replace(", speed: SLIDE", "" if slide is None else f", speed: {slide}")
    return read_scene_text(text, simulation=options)


def run(elements, **own):
    """(system, recorder, report) of the scene with elements."""
    scene = scene_of(**own)
    system = with_elements(compile_system(scene), elements)
    recorder = Recorder()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    return system, recorder, report


def brief(formulation):
    """The options of a run in this formulation, short in the full one, which takes milliseconds a step."""
    return {"formulation": formulation, "duration": "0.5" if formulation == "full" else "2"}


def at(found, name, names):
    return found["joints/coordinate"][:, names.index(name)]
