"""The paper's equations in NumPy, 7 coordinates a body, dense: the full formulation, the reference for all others.

Modules that a run in the kernel does not need are imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mbproj.dynamics.assembly.assemble import State, assemble

if TYPE_CHECKING:
    from mbproj.dynamics.rank.mobility import Mobility, mobility
    from mbproj.dynamics.rank.uniqueness import unique_components

_HOME_OF = {
    "Mobility": "mbproj.dynamics.rank.mobility",
    "mobility": "mbproj.dynamics.rank.mobility",
    "unique_components": "mbproj.dynamics.rank.uniqueness",
}

__all__ = ["Mobility", "State", "assemble", "mobility", "unique_components"]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj.dynamics' has no attribute '{name}'")
    return getattr(import_module(_HOME_OF[name]), name)
