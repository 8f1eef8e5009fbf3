"""Runs with stops go on from a results file: with the bits of one run, whatever touches when it ends."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import InputError
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


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("law", ["rigid: true, restitution: 0.5", "stiffness: 1.0e4, restitution: 0.5"])
@pytest.mark.parametrize(
    ("formulation", "steps"), [("planar", DOP853), ("planar", FIXED), ("full", "integrator: rk4, step: 0.02")]
)
def test_a_run_goes_on_with_the_bits_of_a_longer_one(formulation, steps, law):
    """After impacts: the first is at 0.1 s."""
    until = 0.4 if formulation == "full" else 2.0
    long = TEXT.format(duration=2.0 * until, steps=steps, formulation=formulation, law=law)
    whole, _ = simulated(long)
    part, kept = simulated(long.replace(f"duration: {2.0 * until}", f"duration: {until}"))
    mark = kept[-1]
    assert 0.1 < mark["t"] <= until
    rest, _ = simulated(long, mark)
    after = whole["time"] > mark["t"]
    assert len(part["time"]) < after.size
    for path in ("time", "bodies/position", "bodies/velocity", "stops/force", "diagnostics/dissipation"):
        assert np.array_equal(rest[path], whole[path][after]), path
    assert rest.happened == whole.happened


SOFT = TEXT.format(duration=2, steps=FIXED, formulation="planar", law="stiffness: 1.0e2, restitution: 0.5")


@pytest.mark.parametrize(
    ("part", "missing", "why"),
    [
        ({"counters": {"steps": 0}, "law": 1}, "", "with another law of stops that give way"),
        ({"counters": {"steps": 8}, "law": 2}, "", "which met stops in another way"),
        ({"counters": {"steps": 0}, "law": 2}, "contacts", "which met stops in another way"),
    ],
)
def test_what_an_older_mbproj_has_marked_within_a_run_is_refused(part, missing, why):
    _, kept = simulated(SOFT.replace("duration: 2", "duration: 0.35"))
    mark = next(mark for mark in kept[::-1] if mark["contacts"]["pushing"])
    older = {name: value for name, value in mark.items() if name != missing}
    older["stops"] = {"tally": {"counters": part["counters"]}, "law": part["law"]}
    with pytest.raises(InputError, match=f"an older mbproj made it, {why}"):
        simulated(SOFT, older)


def test_what_an_older_mbproj_has_marked_of_a_whole_run_goes_on():
    whole, _ = simulated(SOFT)
    _, kept = simulated(SOFT.replace("duration: 2", "duration: 0.35"))
    older = {**kept[-1], "stops": {"tally": {"counters": {"steps": 0}}, "law": 2}}
    rest, _ = simulated(SOFT, older)
    assert np.array_equal(rest["bodies/position"], whole["bodies/position"][whole["time"] > older["t"]])
