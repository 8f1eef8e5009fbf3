"""What a program's file hands over: peers, each with the settings that are tried of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import takewhile
from time import perf_counter
from typing import Any

from peers.problem import Array, Chain, Mechanism


class NotConverged(Exception):
    """A setting with which a program cannot finish the motion."""


@dataclass(frozen=True)
class Observation:
    """Of a mechanism the marker's coordinates (T, columns) at the reference's times, of a chain the tip's at its end,
    m; and by how much a joint was open at these times at most, m (None where the coordinates keep it closed)."""

    points: Array
    opening: float | None = None


@dataclass(frozen=True)
class Setting:
    """A step or a tolerance of a peer. `integrate` runs the whole motion and returns the seconds of the integration
    alone; `observe` runs it again with outputs, untimed. Either may raise NotConverged."""

    label: str
    integrate: Callable[[], float]
    observe: Callable[[], Observation]


@dataclass(frozen=True)
class Peer:
    """A program as it is used here: `settings` yields them from coarse to fine, and nothing for a mechanism that the
    program cannot do; `chain` makes one, or None. A `bound` is no general program."""

    name: str
    settings: Callable[[Mechanism], Iterator[Setting]]
    chain: Callable[[Chain], Setting | None] | None = None
    bound: bool = False


def steps_per_interval(fewest: int, most: int) -> Iterator[int]:
    """Whole numbers of fixed steps between two outputs, three to each doubling."""
    counts = (round(fewest * 2.0 ** (k / 3)) for k in range(1000))
    return takewhile(lambda count: count <= most, counts)


def tolerances(loosest: int, tightest: int) -> Iterator[float]:
    """10^-loosest ... 10^-tightest, three to each decade."""
    return (10.0 ** (-k / 3) for k in range(3 * loosest, 3 * tightest + 1))


def seconds_of(run: Callable[[], Any]) -> float:
    """The wall time of a call, s."""
    started = perf_counter()
    run()
    return perf_counter() - started


def ode_label(step: float) -> str:
    """A fixed step in ms."""
    return f"h = {1000 * step:.3g} ms"


def tolerance_label(tolerance: float) -> str:
    """A tolerance to two digits."""
    return f"tol = {tolerance:.1e}" if math.isfinite(tolerance) else "no tolerance"
