"""Euler parameters are recorded without jumps: Λ and -Λ are one orientation, but derivatives of a record are wrong
where the sign changes between two samples."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text, simulate
from tests.support import Recorder

CRANK = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2.2 s, tolerance: 1e-6, integrator: dop853, output_step: 20 ms}
bodies:
  crank: {mass: 0.5, inertia: [2e-3, 2e-3, 2e-3], position: [0.12, 0, 0]}
  spun: {mass: 1, inertia: [1e-2, 1e-2, 1e-2], position: [1, 0, 0], angular_velocity: [0, -17, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [ground, spun], location: [1, 0, 0], axis: [0, 1, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 75 rpm}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_orientations_do_not_jump_between_samples(formulation: str) -> None:
    scene = read_scene_text(CRANK)
    system, recorder = compile_system(scene), Recorder()
    simulate(
        system,
        assemble(system, initial_guess(scene, system)),
        replace(scene.settings, formulation=formulation),
        recorder,
    )
    found = recorder["bodies/orientation"]
    assert len(found) == 111  # five turns and a half of one, and six of the other
    assert np.sum(found[1:] * found[:-1], axis=-1).min() > 0.98


def test_a_run_that_goes_on_does_not_jump() -> None:
    """At 0.42 s the crank has turned by more than half a turn."""
    scene = read_scene_text(CRANK)
    system = compile_system(scene)
    state, recorder, kept = assemble(system, initial_guess(scene, system)), Recorder(), list[Any]()
    settings = replace(scene.settings, formulation="planar")
    simulate(system, state, replace(settings, duration=0.42), recorder, keep=lambda *mark: kept.append(mark[-1]))
    simulate(system, state, settings, recorder, keep=lambda *_: None, resumed=kept[-1])
    times, rows = np.unique(recorder["time"], return_index=True)
    found = recorder["bodies/orientation"][rows]
    assert len(times) == 111
    assert np.sum(found[1:] * found[:-1], axis=-1).min() > 0.98
