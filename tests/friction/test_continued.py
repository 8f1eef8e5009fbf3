"""Runs with dry friction go on from a results file: with the bits of one run, whatever sticks when it ends."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.crossed import full
from tests.friction.scenes import AGAIN, BELT, SLIPS, STICKS
from tests.stops.runs import simulated

ENDS = (0.5 * (STICKS + SLIPS), SLIPS + 0.1, AGAIN - 0.1, AGAIN + 0.2)
DOPRI5 = "integrator: dopri5, tolerance: 1.0e-9, output_step: 0.02 s"
FIXED = "integrator: rk4, step: 0.02 s"
COARSE = "integrator: rk4, step: 0.1 s"


def text(duration, steps, formulation):
    own = f"simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}"
    return re.sub("simulation: .*", own, BELT.partition("expect:")[0])


@pytest.mark.parametrize(("steps", "formulation"), [(DOPRI5, "planar"), (FIXED, "planar"), full(COARSE, "full")])
def test_a_run_goes_on_with_the_bits_of_a_longer_one(steps, formulation):
    whole, _ = simulated(text(3.5, steps, formulation))
    assert [event.kind for event in whole.happened] == ["stick", "slip", "stick"]
    begun = []
    for end in ENDS if formulation == "planar" else ENDS[2:4]:
        end = 0.1 * round(end / 0.1)
        part, kept = simulated(text(f"{end:.1f}", steps, formulation))
        rest, _ = simulated(text(3.5, steps, formulation), kept[-1])
        begun.append(kept[-1]["t"])
        before, after = whole["time"] <= begun[-1], whole["time"] > begun[-1]
        paths = ("time", "bodies/velocity", *(f"friction/{name}" for name in ("rate", "force", "state", "dissipation")))
        for path in paths:
            assert np.array_equal(part[path][: before.sum()], whole[path][before]), (end, path)
            assert np.array_equal(rest[path], whole[path][after]), (end, path)
        assert rest.happened == whole.happened
    assert begun[-1] > STICKS
