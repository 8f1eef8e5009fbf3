"""Forces and motions with more kinks in time than steps can end at: no method keeps its order there. Kinks in the state
do not count, as error control meets them anywhere."""

from __future__ import annotations

from collections.abc import Sequence

from mbproj.integrate.events.time_events import crowded, time_events
from mbproj.scene.sampling import DEFAULT_SAMPLES
from mbproj.studies.measure.mechanism import Mechanism

#: The most forces and motions that a message names.
SHOWN = 3


def uneven(mechanism: Mechanism, until: float) -> tuple[str, ...]:
    """The names of the forces and motions with too many kinks within `until` (s)."""
    start = mechanism.state.t
    return crowded(time_events(mechanism.system, start, start + until, until / DEFAULT_SAMPLES))


def not_smooth(names: Sequence[str]) -> str:
    """A sentence about the names that `uneven` returned: "force 'push' has more kinks in time than steps end at"."""
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    *others, last = [*names[:SHOWN], *more]
    said = "more kinks in time than steps end at"
    return f"{', '.join(others)} and {last} have {said}" if others else f"{last} has {said}"
