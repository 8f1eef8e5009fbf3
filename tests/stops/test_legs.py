"""How the run of a mechanism with stops is cut into legs."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mbproj.integrate.events.leg import Leg
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.reporting.tally import Tally
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


def test_an_event_at_which_the_next_leg_begins_is_told_once():
    """Round-off of the state at a kink may show the leg that begins there the same crossing again."""
    kinks = [Event(t, "force 'k'", "kink of max", -1) for t in (0.5, 1.0, 1.5)]
    first, second = Tally(), Tally()
    first.met, second.met = kinks[:2], kinks[1:]
    first.join(second)
    assert first.met == kinks
