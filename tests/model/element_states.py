"""A pendulum whose elements have states, x and z, with rates of a test's own."""

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
from tests.support import Recorder

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
