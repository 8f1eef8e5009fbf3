"""How stops that touch share what they push, where their rows depend on each other: some of them hold rows, and the
pushes of all are parts of what these bear."""

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
    """Of S stops that touch: those that hold `rows` (h,), and the `parts` (S, h) of their multipliers that each pushes
    with. Of those that are `idle` (S,) the parts give less than nothing, as long as they do not push; `apart` (S,) are
    those that have no share, since they open. Whether the motion depends on how they share is `decides`."""

    rows: Integers
    parts: Array
    idle: Flags
    apart: Flags
    decides: bool


def shares_of(N: Array, push: Array) -> Shares | None:
    """Of stops with rows N (S, f) that push so, (S,), and rub nowhere; None where the rows of those that push, and of
    those that follow from them, are independent. As their motion goes on they share as springs of one stiffness do."""
    B = numbers(N @ N.T)
    if len(independent(B, np.arange(len(B)))) == len(B):
        return None
    return shares_from(law().shares_of(thresholds(), B, B, numbers(push)))


def shares_from(found: Sequence[Any] | None) -> Shares | None:
    """As the kernel tells them."""
    if found is None:
        return None
    rows, parts, idle, apart, decides = found
    return Shares(
        np.array(rows, dtype=np.intp), parts, np.array(idle, dtype=bool), np.array(apart, dtype=bool), decides
    )


def held_by(push: Array, touches: Integers, shares: Shares | None) -> Contacts:
    """The stops that hold rows where these touch and push so, (S,), and how they share."""
    if shares is None:
        return Contacts(tuple(np.flatnonzero(push > 0.0).tolist()))
    held = touches[shares.rows].tolist()
    parts = {
        int(touches[k]): tuple(zip(held, shares.parts[k].tolist(), strict=True)) for k in np.flatnonzero(~shares.apart)
    }
    idle = frozenset(touches[shares.idle].tolist())
    return Contacts(tuple(held), shares=parts, idle=idle, decides=shares.decides)
