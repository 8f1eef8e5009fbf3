"""How the run of a mechanism with stops is cut into legs."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mbproj.integrate.events.leg import Leg
from mbproj.integrate.stops.march import StopMarch


@given(
    step=st.floats(1e-6, 10.0),
    count=st.integers(1, 5000),
    start=st.floats(0.0, 100.0),
    end_grains=st.integers(-2, 2),
    at=st.floats(0.0, 1.0),
    grains=st.integers(-3, 3),
)
def test_every_leg_of_fixed_steps_takes_time(step, count, start, end_grains, at, grains):
    """The end of a run is its duration, and may be a grain of round-off after its last step: a leg from there to there
    had no duration."""
    duration = count * step + end_grains * np.spacing(start + count * step)
    whole = Leg(start, duration, duration, (), step=step, count=count)
    t = start + round(at * count) * step
    t += grains * np.spacing(t)
    if not start <= t < whole.end:
        return
    leg = StopMarch._next_leg(SimpleNamespace(state=SimpleNamespace(t=t), whole=whole))
    assert leg.duration > 0.0
    assert leg.start + leg.duration <= whole.end + 2.0 * np.spacing(whole.end)
