"""How stops that touch share a load, where their rows depend on each other. Some stops hold rows, and the push of each
stop is a sum of parts of these rows' multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.friction.problem import independent, law, numbers, thresholds
from mbproj.model.contacts import Contacts


@dataclass(frozen=True, eq=False)
class Shares:
    """The shares of S stops that touch: `rows` (h,) are the stops that hold rows, and each stop pushes with these
    `parts` (S, h) of their multipliers.

    A stop that is `idle` (S,) does not push now, and its parts give a negative push until it does. One that is `apart`
    (S,) opens and has no share. `decides`: whether the motion depends on how the stops share."""

    rows: Integers
    parts: Array
    idle: Flags
    apart: Flags
    decides: bool


def shares_of(N: Array, push: Array) -> Shares | None:
    """The shares of stops without friction, with rows N (S, f) and pushes `push` (S,). They share the load as springs
    of equal stiffness do. None where the rows of the stops that push, and of those that these carry along, are
    independent."""
    B = numbers(N @ N.T)
    if len(independent(B, np.arange(len(B)))) == len(B):
        return None
    return shares_from(law().shares_of(thresholds(), B, B, numbers(push)))


def shares_from(found: Sequence[Any] | None) -> Shares | None:
    """The shares from the kernel's sequence."""
    if found is None:
        return None
    rows, parts, idle, apart, decides = found
    return Shares(
        np.array(rows, dtype=np.intp), parts, np.array(idle, dtype=bool), np.array(apart, dtype=bool), decides
    )


def held_by(push: Array, touches: Integers, shares: Shares | None) -> Contacts:
    """The stops that hold rows, and how all share. `touches` (S,) are the numbers of the stops that touch, `push` (S,)
    their pushes."""
    if shares is None:
        return Contacts(tuple(np.flatnonzero(push > 0.0).tolist()))
    held = touches[shares.rows].tolist()
    parts = {
        int(touches[k]): tuple(zip(held, shares.parts[k].tolist(), strict=True)) for k in np.flatnonzero(~shares.apart)
    }
    idle = frozenset(touches[shares.idle].tolist())
    return Contacts(tuple(held), shares=parts, idle=idle, decides=shares.decides)
