"""The damping of a compliant stop from the restitution that it is to have (Hunt & Crossley 1975).

A mass m on F = k δᵖ (1 + c δ') has v dv / (1 + c v) = -(k/m) δᵖ dδ. From the speed of approach v to that of departure,
-e v, the right-hand side integrates to 0, whatever k, m and p are; with d = c v this is

    d (1 + e) = ln((1 + d) / (1 - e d)),

which has one solution in 0 < d < 1/e. The force pulls nowhere, because 1 - e d > 0.
"""

from __future__ import annotations

import math


def relative_damping(restitution: float) -> float:
    """d = c v of a stop with this restitution e, 0 < e <= 1: 0 for e = 1, and next to 1/e for small e."""
    e = restitution
    low, high = 0.0, 1.0 / e
    if e == 1.0:
        return 0.0
    while True:
        d = 0.5 * (low + high)
        if not low < d < high:
            return d
        if _excess(d, e) < 0.0:
            low = d
        else:
            high = d


def _excess(d: float, e: float) -> float:
    """ln((1 + d) / (1 - e d)) - d (1 + e): negative below the solution."""
    if max(d, e * d) < 1e-3:  # the terms of first order cancel
        powers = ((-1) ** (n + 1) * d**n / n + (e * d) ** n / n for n in range(2, 8))
        return math.fsum(powers)
    return math.log1p(d) - math.log1p(-e * d) - d * (1.0 + e) if e * d < 1.0 else math.inf
