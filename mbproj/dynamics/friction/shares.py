"""How stops that touch share what they push, where their rows depend on each other: some of them hold rows, and the
pushes of all are parts of what these bear."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.friction.problem import independent
from mbproj.model.contacts import Contacts
from mbproj.thresholds import THRESHOLDS


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


def shares_of(N: Array, push: Array, pulled: Array) -> Shares | None:
    """Of stops with rows N (S, f) that push so, (S,), where each push of 1 does `pulled` (S, f), its row and the
    friction that slides by it; None where the rows of those that push, and of those that follow
    from them, are independent. As their motion goes on they share as springs of one stiffness do."""
    pushes = push > 0.0
    if not pushes.any():
        return None
    B = N @ N.T
    rows = independent(B, np.flatnonzero(pushes))
    C = np.linalg.lstsq(N[rows].T, N.T, rcond=None)[0].T
    apart = np.linalg.norm(C @ N[rows] - N, axis=1) > np.sqrt(THRESHOLDS.no_push) * np.linalg.norm(N, axis=1)
    apart |= np.linalg.norm(N, axis=1) <= THRESHOLDS.no_push * np.linalg.norm(N, axis=1).max(initial=0.0)
    if (~apart).sum() == len(rows):
        return None
    parts = C @ np.linalg.inv(C[pushes].T @ C[pushes])
    borne = C[pushes].T @ push[pushes]
    off = np.where(pushes, push - parts @ borne, 0.0)
    open_to_all = null_space(C[pushes].T)
    effect = np.abs(pulled[pushes].T @ open_to_all).max(initial=0.0)
    decides = bool(effect > np.sqrt(THRESHOLDS.no_push) * np.abs(pulled).max())
    return Shares(rows, parts + np.outer(off, borne) / (borne @ borne), ~pushes & ~apart, apart, decides)


def null_space(A: Array) -> Array:
    """An orthonormal basis (k, n) of the x with A x = 0."""
    _, sizes, rows = np.linalg.svd(A)
    rank = int((sizes > np.sqrt(THRESHOLDS.no_push) * sizes.max(initial=0.0)).sum())
    return np.asarray(rows[rank:].T)


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
