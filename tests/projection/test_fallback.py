"""What becomes of a position that a method does not close: the run stops, or takes GOPM's metric where that is allowed.

The mass-orthogonal projection with a penalty far below the masses leaves most of a violation at each pass."""

from __future__ import annotations

import re

import numpy as np
import pytest

from mbproj import Report
from mbproj.base.errors import SimulationError
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.equations.assembly.assemble import State
from mbproj.kernel import core
from mbproj.motion.simulate import simulate
from tests.projection.uneven_chains import uneven_chain
from tests.support import Recorder

FORMULATIONS = ["full", *(["reduced", "planar"] if core() is not None else [])]
SOFT = {"method": "mass-orthogonal", "alpha": 1.0}
STEP = 1e-3


def after_one_step(formulation: str, **projection: object) -> tuple[Report, Recorder]:
    """A step from rest of a chain with masses 1e6 apart whose joints are open by some hundredths of a metre."""
    system, _, q = uneven_chain(1e6, 0)
    state = State.of(system, 0.0, positions=q, velocities=np.zeros_like(q))
    settings = Settings(duration=STEP, step=STEP, formulation=formulation, projection=ProjectionSettings(**projection))
    recorder = Recorder()
    return simulate(system, state, settings, recorder), recorder


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_without_a_fallback_the_run_stops_and_says_what_may_help(formulation):
    with pytest.raises(SimulationError) as caught:
        after_one_step(formulation, **SOFT)
    error = caught.value
    assert error.time == STEP
    assert re.fullmatch(r"joint 'J\d'", error.where)
    assert re.fullmatch(r"the projection did not close it: \S+ is left after \d+ passes", error.cause)
    assert error.hint.endswith("where masses differ widely, --projection-fallback gopm may help")


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_with_the_fallback_it_begins_again_in_gopms_metric_and_counts(formulation):
    """From where the method began: the state is GOPM's own, to round-off."""
    report, recorder = after_one_step(formulation, **SOFT, fallback="gopm")
    assert (report.counters["projection_fallbacks"], report.counters["projection_failures"]) == (1, 0)
    assert recorder["diagnostics/position_violation"][-1] <= 1e-13
    expected = after_one_step(formulation, method="gopm")[1]
    for path in ("bodies/position", "bodies/orientation"):
        np.testing.assert_allclose(recorder[path], expected[path], rtol=0, atol=1e-14)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_method_that_converges_has_no_use_for_it(formulation):
    report, recorder = after_one_step(formulation, method="gpopm", fallback="gopm")
    assert report.counters["projection_fallbacks"] == 0
    other = after_one_step(formulation, method="gopm")[1]
    assert np.abs(recorder["bodies/position"][-1] - other["bodies/position"][-1]).max() > 1e-3
