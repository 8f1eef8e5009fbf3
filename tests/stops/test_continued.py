"""Runs with stops go on from a results file: with the bits of one run, whatever touches when it ends."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.errors import InputError
from tests.stops.runs import DOP853, FIXED, simulated

TEXT = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  bob: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, -1, 0]}}
joints:
  pivot:
    type: revolute
    bodies: [ground, bob]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    speed: 2
    limits: {{angle: {{range: [-0.3, 0.2], {law}}}}}
forces:
  push: {{type: torque, body: bob, torque: [0, 0, "6 * sin(1.5 * t)"]}}
"""


@pytest.mark.parametrize("law", ["rigid: true, restitution: 0.5", "stiffness: 1.0e4, restitution: 0.5"])
@pytest.mark.parametrize(
    ("formulation", "steps"), [("planar", DOP853), ("planar", FIXED), ("full", "integrator: rk4, step: 0.02")]
)
def test_a_run_goes_on_with_the_bits_of_a_longer_one(formulation, steps, law):
    whole, _ = simulated(TEXT.format(duration=4, steps=steps, formulation=formulation, law=law))
    part, kept = simulated(TEXT.format(duration=2, steps=steps, formulation=formulation, law=law))
    mark = kept[-1]
    assert 0.0 < mark["t"] <= 2.0
    rest, _ = simulated(TEXT.format(duration=4, steps=steps, formulation=formulation, law=law), mark)
    after = whole["time"] > mark["t"]
    assert len(part["time"]) < after.size
    for path in ("time", "bodies/position", "bodies/velocity", "stops/force", "diagnostics/dissipation"):
        assert np.array_equal(rest[path], whole[path][after]), path
    assert rest.happened == whole.happened


def test_a_mark_of_an_older_law_of_stops_is_refused():
    steps = "integrator: rk4, step: 0.02"
    text = TEXT.format(duration=0.35, steps=steps, formulation="full", law="stiffness: 1.0e2, restitution: 0.5")
    _, kept = simulated(text)
    mark = next(mark for mark in kept[::-1] if mark["stops"]["pushing"])
    del mark["stops"]["law"]
    with pytest.raises(InputError, match="an older mbproj made it, with another law of stops that give way"):
        simulated(text.replace("duration: 0.35", "duration: 2"), mark)
