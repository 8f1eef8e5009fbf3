"""Scenes whose elements have states, and a pendulum that a motor drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.functions.program import CHANNELS, Program
from mbproj.functions.program_set import flatten
from mbproj.kernel import core
from mbproj.model.channels import ChannelKind, Channels, ElementStates
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.simulate import simulate
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.support import Recorder, assembled

# A pendulum whose elements have states, x and z, with rates of a test's own.

FORMULATIONS = ["full", *(["reduced", "planar"] if core() is not None else [])]
#: A pendulum with a damper, whose work is integrated beside the states and whose angle is followed.
PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, output_step: 0.05}
bodies: {rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
forces: {damper: {type: torsion_spring_damper, joint: pin, damping: 0.3}}
"""
#: A lag of first order behind a sine, and one behind that.
DRIVEN, T1, T2 = 7.0, 0.05, 0.3
LAGS = (f"(sin({DRIVEN}*t) - x)/{T1}", f"(x - z)/{T2}")


def with_states(system, texts, start=(0.0, 0.5), scale=(1.0, 1.0)):
    """The system with states of these rates, called x and z."""
    variables = {"t": 0, "x": CHANNELS, "z": CHANNELS + 1}
    programs = [Program(compiled(parse(text), {}, variables)[0], text) for text in texts]
    own = ElementStates(np.array(start), np.array(scale), flatten(programs), np.zeros(len(start), dtype=bool))
    names = replace(system.names, states=("lag.x", "lag.z"), state_units=("V", "A/s"))
    return replace(
        system, states=own, names=names, channels=Channels.of([(ChannelKind.STATE, 0), (ChannelKind.STATE, 1)])
    )


def case(options, text=PENDULUM, texts=LAGS, **own):
    """(scene, system with states, start, settings)."""
    scene = read_scene_text(text, simulation=options)
    system = with_states(compile_system(scene), texts, **own)
    return scene, system, assemble(system, initial_guess(scene, system)), settings_to_run(scene)


def run(options, until=1.0, resumed=None, **own):
    """(report, recorder, marks)."""
    _, system, state, settings = case(options, **own)
    recorder, marks = Recorder(), []
    keep = {"keep": lambda *mark: marks.append(mark[-1]), "resumed": resumed or {}}
    return simulate(system, state, replace(settings, duration=until), recorder, **keep), recorder, marks


# A pendulum whose pin a motor turns, with a controller: functions that name channels, and states of elements.

#: A pendulum whose pin a motor turns; a wheel beside it, in the same plane.
DRIVEN_PENDULUM = """
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
    scene = read_scene_text(DRIVEN_PENDULUM, simulation=options)
    system, start = assembled(scene)
    states = ElementStates(np.zeros(3), np.ones(3), programs(rates), np.zeros(3, dtype=bool))
    names = replace(system.names, states=("x.current", "x.integral", "x.filtered"), state_units=("A", "s", "1/s"))
    forces = replace(system.forces, programs=programs([motor, spring]))
    system = replace(system, states=states, names=names, forces=forces, channels=CHANNELS_OF)
    start = start.of(system, 0.0, positions=start.q, velocities=start.v, turns=start.turns)
    return system, start, settings_to_run(scene)
