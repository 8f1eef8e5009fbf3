"""A pendulum whose pin a motor turns, with a controller: functions that name channels, and states of elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.functions.program import CHANNELS, Program
from mbproj.functions.program_set import flatten
from mbproj.model.channels import ChannelKind, Channels, ElementStates
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run

#: A pendulum whose pin a motor turns; a wheel beside it, in the same plane.
PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.5, output_step: 0.1, tolerance: 1e-12, integrator: dop853}
bodies:
  rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, -0.2]}
  wheel: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 1]}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
  axle: {type: revolute, bodies: [ground, wheel], location: [0, 0, 1], axis: [0, 1, 0], angle: 0.02 rad}
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: "2*t"}
  spring: {type: torsion_spring_damper, joint: axle, torque: "-t"}
"""
NAMES = ("current", "integral", "filtered", "angle", "speed", "turn")
CHANNELS_OF = Channels.of(
    [
        (ChannelKind.STATE, 0),
        (ChannelKind.STATE, 1),
        (ChannelKind.STATE, 2),
        (ChannelKind.COORDINATE, 0),
        (ChannelKind.RATE, 0),
        (ChannelKind.COORDINATE, 1),
    ]
)
RATES = (
    "(20*(1 - angle) + 30*integral - 2*filtered - 0.8*current - 2*speed)/2e-3",
    "1 - angle",
    "(speed - filtered)/0.01",
)


def programs(texts):
    """Functions of the channels by name."""
    variables = {"t": 0} | {name: CHANNELS + number for number, name in enumerate(NAMES)}
    return flatten([Program(compiled(parse(text), {}, variables)[0], text) for text in texts])


def driven(motor="2*current", spring="0*t", rates=RATES, **options):
    """(system with a motor's current and a controller's states, start, settings)."""
    scene = read_scene_text(PENDULUM, simulation=options)
    system = compile_system(scene)
    start = assemble(system, initial_guess(scene, system))
    states = ElementStates(np.zeros(3), np.ones(3), programs(rates), np.zeros(3, dtype=bool))
    names = replace(system.names, states=("x.current", "x.integral", "x.filtered"), state_units=("A", "s", "1/s"))
    forces = replace(system.forces, programs=programs([motor, spring]))
    system = replace(system, states=states, names=names, forces=forces, channels=CHANNELS_OF)
    start = start.of(system, 0.0, positions=start.q, velocities=start.v, turns=start.turns)
    return system, start, settings_to_run(scene)
