"""Mechanisms that motions drive in all their freedoms, and how they are run."""

from __future__ import annotations

import numpy as np

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.support import Recorder

FORMULATIONS = ["reduced", "planar"]
#: Of the crank, coupler, rocker and ground, m.
CRANK, COUPLER, ROCKER, GROUND = 0.2, np.hypot(0.4, 0.4), np.hypot(0.1, 0.4), 0.7
SPEED = 2.0 * np.pi
FOUR_BAR = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2 s, tolerance: 1e-3, integrator: dop853, output_step: 50 ms}
bodies:
  crank: {mass: 0.4, inertia: [1e-3, 1e-3, 1e-3], position: [0.1, 0, 0]}
  coupler: {mass: 1.0, inertia: [2e-2, 2e-2, 2e-2], position: [0.4, 0, 0.2]}
  rocker: {mass: 0.8, inertia: [1e-2, 1e-2, 1e-2], position: [0.65, 0, 0.2]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, -1, 0]}
  B: {type: revolute, bodies: [crank, coupler], location: [0.2, 0, 0], axis: [0, -1, 0]}
  C: {type: revolute, bodies: [coupler, rocker], location: [0.6, 0, 0.4], axis: [0, -1, 0]}
  D: {type: revolute, bodies: [ground, rocker], location: [0.7, 0, 0], axis: [0, -1, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 60 rpm}}
"""
#: Its rocker drives it, to where crank and coupler are in line.
BY_THE_ROCKER = FOUR_BAR.replace("joint: A, angle: {constant_speed: 60", "joint: D, angle: {constant_speed: 20")
#: It passes the flat pose twice a turn, where it could become an antiparallelogram.
PARALLELOGRAM = (
    FOUR_BAR.replace("[0.1, 0, 0]", "[0, 0, 0.1]")
    .replace("[0.4, 0, 0.2]", "[0.25, 0, 0.2]")
    .replace("[0.65, 0, 0.2]", "[0.5, 0, 0.1]")
    .replace("[0.2, 0, 0]", "[0, 0, 0.2]")
    .replace("[0.6, 0, 0.4]", "[0.5, 0, 0.2]")
    .replace("[0.7, 0, 0]", "[0.5, 0, 0]")
    .replace("60 rpm", "57 rpm")
)


def run(text, resumed=None, change=lambda system: system, **options):
    """(report, recorder, marks) of a scene's text with these settings."""
    scene = read_scene_text(text, simulation=options)
    system = change(compile_system(scene))
    recorder, marks = Recorder(), []
    keep = {} if resumed is None else {"keep": lambda *mark: marks.append(mark[-1]), "resumed": resumed}
    start = assemble(system, initial_guess(scene, system))
    return simulate(system, start, settings_to_run(scene), recorder, **keep), recorder, marks


def rocker_angle(time):
    """Of the rocker from the ground's line, by the cosine rule (Freudenstein), on the branch of the scene."""
    crank = SPEED * time
    x, z = GROUND - CRANK * np.cos(crank), -CRANK * np.sin(crank)
    diagonal = np.hypot(x, z)
    inner = np.arccos((diagonal**2 + ROCKER**2 - COUPLER**2) / (2.0 * diagonal * ROCKER))
    return np.arctan2(z, x) + np.pi - inner


def rocker_at_dead_centre():
    """By how much the rocker turns from the start to where the crank lies on the coupler."""
    cosine = ((COUPLER - CRANK) ** 2 - GROUND**2 - ROCKER**2) / (2.0 * GROUND * ROCKER)
    return np.arccos(cosine) - np.arctan2(0.4, -0.1)
