"""Equilibrium, modes and linear models: what is round-off, and what is large."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Linear:
    """Parts of sums without their signs, unless a unit says otherwise."""

    most_dense: int = threshold(
        1200,
        "degrees of freedom, rows",
        "both",
        "linear models, steady turns, modes that need dense matrices have no more; nor has a dense QR factor of rows",
        "O(n³): some minutes",
    )
    good_step: float = threshold(
        0.1, "1", "numpy", "a step is taken where the forces do so much of the work that was expected", "usual: 0.1"
    )
    largest_radius: float = threshold(
        1.0,
        "length, rad",
        "numpy",
        "no step to a balance is longer",
        "the equilibrium of steered_car.yaml: without it a step that rolls without resistance has 1e8 parts",
    )
    far_away: float = threshold(
        30.0,
        "length",
        "numpy",
        "what has no equilibrium so far from the start, or falls so far by a force that does not change, has none",
        "four turns of a shaft",
    )
    proximal: float = threshold(
        1e-10,
        "1",
        "numpy",
        "rows of large mechanisms give way by so much, which is taken out again; their stiffness is raised by so much",
        "√ε, with room",
    )
    same_pose: float = threshold(
        1e-5,
        "length, rad",
        "numpy",
        "assemblies or equilibria whose bodies are nearer are one; a pose that is open by more is locked",
        "far above what balancing leaves",
    )
    stalled: float = threshold(
        0.01,
        "1",
        "numpy",
        "steps have to lower what is left by so much of it; a force that changes by less is the same",
        "one length of a hundred takes 10 steps",
    )
    most_of_round: int = threshold(20_000, "-", "numpy", "a round of controllers has no more instants", "seconds")
    largest_ratio: int = threshold(
        10_000,
        "-",
        "numpy",
        "ratios of periods of controllers, and of weights of angles, are fractions of numbers up to so many",
        "wheels of 100 teeth in two stages",
    )
