"""The paper's equations in NumPy, 7 coordinates a body, dense: the full formulation, the reference of all others."""

from mbproj.dynamics.assembly import State, assemble
from mbproj.dynamics.rank import Mobility, mobility
from mbproj.dynamics.uniqueness import unique_components

__all__ = ["Mobility", "State", "assemble", "mobility", "unique_components"]
