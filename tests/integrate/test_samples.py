"""Samples inside a step."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import SimulationError
from mbproj.integrate.formulations.compiled import require_finite


def test_a_sample_that_no_correction_closes_ends_the_run_at_its_time():
    """Inside a step much too long for the motion a sample may have no pose near by."""
    block = {"t": np.array([0.1, 0.2, 0.3]), "y": np.zeros((3, 2, 13))}
    require_finite(block)
    block["y"][1, 0, 4] = np.nan
    with pytest.raises(SimulationError, match="no longer finite") as error:
        require_finite(block)
    assert error.value.time == 0.2
