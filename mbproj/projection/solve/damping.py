"""Corrections to try in turn where the full correction turns a body further than its linearised rows are valid, or does
not reduce the violation.

A metric by masses turns bodies of small inertia by large angles where a heavy body would have to move otherwise. The
smallest correction that turns no body by more than ϑ is that of a metric with moments of inertia added to such bodies:
min ½ΔᵀMΔ subject to C_q Δ = -C and |δθ_b| <= ϑ has the conditions (M + Σ μ_b E_b) Δ + C_qᵀλ = 0, with μ_b >= 0 where
the bound holds (a trust region: Conn, Gould & Toint 2000, sect. 7). It closes the rows to first order, with an error of
order ϑ², so that some ϑ reduces the violation wherever C_q has full rank.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array
from mbproj.projection.methods.method import Projection
from mbproj.thresholds import THRESHOLDS


def damped(method: Projection, M: Array, C_q: Array, violation: Array, q: Array) -> Iterator[tuple[Array, float]]:
    """Yield corrections Δ (7n,) of q (7n,) for a violation (m,), each with the part of it that Δ closes to first order.

    The first is the method's own. Where that turns a body too far, and from then on, they are the smallest in its
    metric that turn bodies less and less. Where the metric does not limit turns, the method's own is shortened."""
    whole = method.correction(M, C_q, violation)
    widest = _widest(whole, q)
    limit = THRESHOLDS.widest_turn
    if widest <= limit:
        yield whole, 1.0
        limit = THRESHOLDS.tighter * widest
    for _ in range(THRESHOLDS.most_halvings):
        change = _turning_less(method, M, C_q, violation, q, limit)
        if change is None:
            break
        yield change, 1.0
        limit = THRESHOLDS.tighter * min(limit, _widest(change, q))
    part = min(0.5, THRESHOLDS.widest_turn / widest) if widest > 0.0 else 0.5
    while part >= 0.5**THRESHOLDS.most_halvings:
        yield part * whole, part
        part *= 0.5


def _turning_less(method: Projection, M: Array, C_q: Array, violation: Array, q: Array, limit: float) -> Array | None:
    """Return a correction that turns no body by more than `limit`, near to the smallest in energy. Return None where
    moments of inertia do not limit turns: in GOPM's metric, or where the rows prescribe the turn."""
    if not limit > 0.0:
        return None
    Λ = q.reshape(-1, 7)[:, 3:]
    index = np.arange(len(Λ))
    across = 4.0 * (np.eye(4) - Λ[:, :, None] * Λ[:, None, :] / np.sum(Λ * Λ, axis=-1)[:, None, None])
    blocks = M.reshape(len(Λ), 7, len(Λ), 7)
    moment = np.einsum("bibi->b", blocks[:, 3:, :, 3:]) / 12.0
    moment = np.maximum(moment, THRESHOLDS.lent_part * moment.mean())
    added, before = np.zeros(len(Λ)), None
    for _ in range(THRESHOLDS.most_passes):
        stiff = blocks.copy()
        stiff[index, 3:, index, 3:] += added[:, None, None] * across
        try:
            change = method.correction(stiff.reshape(M.shape), C_q, violation)
        except np.linalg.LinAlgError:
            return None
        turns = _turns(change, q)
        if np.all(turns <= limit):
            return change
        if before is not None and np.array_equal(change, before):
            return None
        added = np.where(turns > limit, added + THRESHOLDS.stiffer * (moment + added) * turns / limit, added)
        before = change
    return None


def _turns(change: Array, q: Array) -> Array:
    """Return the turn of each body by a change of q, (n,), to first order: 2 |ΔΛ| across Λ."""
    Λ, ΔΛ = q.reshape(-1, 7)[:, 3:], change.reshape(-1, 7)[:, 3:]
    across = ΔΛ - np.sum(ΔΛ * Λ, axis=-1, keepdims=True) * Λ
    return np.asarray(2.0 * np.linalg.norm(across, axis=-1))


def _widest(change: Array, q: Array) -> float:
    return float(_turns(change, q).max())
