"""Equilibria, modes and linear models of a mechanism, on the tangent space of the constraints.

All derivatives come from `mbproj.dynamics.derivatives`. SciPy is imported where it is needed.
"""

from mbproj.registry import lazily

__getattr__ = lazily(
    __name__,
    {
        "equilibrium.balance": "EquilibriumProblem",
        "equilibrium.observed": "observed",
        "equilibrium.solve": "NoEquilibrium",
        "equilibrium.started": "assembled_start start_state",
        "equilibrium.steady": "steady_turn",
        "mode_notes": "notes_on",
        "reference": "reference_at",
        "resting_contacts": "held_at",
        "state_space.instants": "round_of",
        "states": "stored_state",
    },
)
