"""What a comparison found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.base.arrays import Numbers

#: In SI units: what round-off makes of nothing, where nothing moves and nothing acts.
NOTHING = 1e-25


@dataclass(frozen=True)
class Finding:
    """Something that was compared: how far it is off in units of what is allowed, or infinite, for what reason."""

    what: str
    excess: float
    why: str = ""

    @property
    def holds(self) -> bool:
        """False for NaN."""
        return self.excess <= 1.0


def off(what: str, error: Numbers | float, allowed: Numbers | float) -> Finding:
    """The largest error, component by component, in units of what is allowed."""
    ratio = np.abs(error) / np.maximum(allowed, NOTHING)
    return Finding(what, float(np.max(ratio, initial=0.0)))
