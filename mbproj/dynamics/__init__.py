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
        "assembly.assemble": "coordinate_values moved_from_scene",
        "contact.driven": "refuse_driven_beyond",
        "contact.freedom": "Freedom",
        "derivatives.law_derivatives": "channel_slopes",
        "derivatives.linear_equations": "MotionAtTime constraint_rows linear_equations tangent_force",
        "derivatives.row_derivatives": "Carried force_derivative row_motion second_derivatives third_derivatives",
        "derivatives.slip_derivatives": "slip_motion",
        "derivatives.tangent": "tangent_velocities velocities",
        "derivatives.tangent_space": "tangent_space",
        "equations.constraint_equations": "constraint constraint_at constraint_velocity "
        "constraint_velocity_at gamma jacobian set_bias set_jacobian set_velocity tangent_jacobian",
        "equations.equations_of_motion": "SOLVERS generalised_force mass_matrix tangent_mass_matrix",
        "equations.forces": "applied generalised law_state state_rates",
        "equations.instant": "Instant of_signals",
        "equations.kinematics": "attached body_rates pose_of slots_of twist_of",
        "equations.motions": "NO_DRIVE drive_at",
        "fast_modes": "speeds_of_free_bodies",
        "observe.total_energy": "kinetic_energy potential_energy total_energy",
        "overlap": "overlapping",
        "rank.lasting": "NO_CONDITIONS",
        "rank.mobility": "Mobility mobility",
        "rank.redundancy": "redundancy",
        "rank.right_hand_sides": "tangent_gamma",
        "rank.row_policy": "RowPolicy",
        "rank.row_set": "RowSet",
        "rank.row_space": "scaled_jacobian",
        "rank.uniqueness": "unique_components",
    },
)
