"""Which forces and motions have more kinks in time than steps end at: there no method keeps its order. Kinks in the
state are met by error control, wherever they are."""

from __future__ import annotations

from collections.abc import Sequence

from mbproj.integrate.events.time_events import crowded, time_events
from mbproj.scene.sampling import DEFAULT_SAMPLES
from mbproj.studies.measure.mechanism import Mechanism

#: Forces and motions that are named, at most.
SHOWN = 3


def uneven(mechanism: Mechanism, until: float) -> tuple[str, ...]:
    """Whose kinks are too many up to a time in s."""
    start = mechanism.state.t
    return crowded(time_events(mechanism.system, start, start + until, until / DEFAULT_SAMPLES))


def not_smooth(names: Sequence[str]) -> str:
    """What `uneven` has found, in words: "force 'push' has more kinks in time than steps end at"."""
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    *others, last = [*names[:SHOWN], *more]
    said = "more kinks in time than steps end at"
    return f"{', '.join(others)} and {last} have {said}" if others else f"{last} has {said}"
