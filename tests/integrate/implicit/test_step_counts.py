"""How many steps of error control a stiff vibration takes that nothing damps: the more, the finer the tolerance."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.registry import implicit_integrators
from scripts.stiff.cases import ringing
from tests.kernel.scenes import needs_kernel, run

both = pytest.mark.parametrize("integrator", implicit_integrators())


def counts(k, tolerances, **keys):
    """Steps, and steps that were rejected, at each tolerance."""
    scene, keys = ringing(k), {"duration": 0.2, "output_step": 0.2} | keys
    found = [run(scene, tolerance=each, **keys)[1].counters for each in tolerances]
    return [[each[name] for each in found] for name in ("steps", "rejected_steps")]


@needs_kernel
@both
@pytest.mark.parametrize("k", [1e6, 1e8, 1e10])
def test_finer_tolerances_take_more_steps(k, integrator):
    """In half decades, past that at which a step begins to follow the vibration."""
    steps, rejected = counts(k, 10.0 ** np.arange(-3.0, -5.5, -0.5), integrator=integrator)
    assert all(np.diff(steps) > -3)
    assert all(np.array(rejected) <= np.array(steps) / 2 + 2)


@both
@pytest.mark.parametrize("formulation", ["full", pytest.param("planar", marks=needs_kernel)])
def test_a_vibration_that_is_damped_stays_so(formulation, integrator):
    """A step that is rejected on the way does not lead back to steps that follow it: of 3e-5 s, more than 1,000."""
    steps, _ = counts(1e8, [10.0**-3.5], integrator=integrator, formulation=formulation)
    assert steps[0] <= 16
