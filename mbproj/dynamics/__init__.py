"""The paper's equations in NumPy, 7 coordinates a body, dense: the full formulation, the reference of all others."""

from mbproj.dynamics.assembly.assemble import State, assemble
from mbproj.dynamics.rank.mobility import Mobility, mobility
from mbproj.dynamics.rank.uniqueness import unique_components

__all__ = ["Mobility", "State", "assemble", "mobility", "unique_components"]
