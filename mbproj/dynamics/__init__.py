"""The paper's equations in NumPy, 7 coordinates a body, dense: the full formulation, the reference for all others.

Modules that a run in the kernel does not need are imported on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.dynamics.assembly.assemble import State, assemble
from mbproj.registry import lazily

if TYPE_CHECKING:
    from mbproj.dynamics.rank.mobility import Mobility, mobility
    from mbproj.dynamics.rank.uniqueness import unique_components

__getattr__ = lazily(
    __name__,
    {
        "rank.mobility": "Mobility mobility",
        "rank.uniqueness": "unique_components",
    },
)
