"""Which settings are worth another look, where nothing has an error at all."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.measure.setting import Setting
from mbproj.studies.tradeoff import Ladder, projections_at_one_size, promising


def trial(projection: str, step: float, evaluations: int) -> Measurement:
    setting = Setting(projection=projection, integrator="rk4", step=step)
    return Measurement(setting, {"tip": 0.0}, {"tip": 0.0}, 0.0, 0.0, 0.0, 0.0, {"evaluations": evaluations}, 1e-3)


@pytest.mark.filterwarnings("error")
def test_where_every_error_is_zero_the_fewest_evaluations_win():
    ladders = [Ladder(Setting(projection=name, integrator="rk4", step=0.1), False) for name in ("gpopm", "none")]
    swept = [[trial("gpopm", 0.1, 400)], [trial("none", 0.1, 100)]]
    assert promising(ladders, swept) == [ladders[1]]
    trials = [trial(name, step, 10) for step in (0.1, 0.2, 0.4) for name in ("gpopm", "none")]
    assert projections_at_one_size(trials, np.zeros(6), None) == [0, 1]
