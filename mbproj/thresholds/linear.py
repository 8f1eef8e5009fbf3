"""Equilibrium, modes and linear models: what is round-off, and what is large."""

from __future__ import annotations

from dataclasses import dataclass

from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Linear:
    """Parts of sums without their signs, unless a unit says otherwise."""

    linear_round_off: float = threshold(
        1e-12, "1", "numpy", "a smaller part of a stiffness or damping is none", "ε × some thousand terms"
    )
    dense_modes: int = threshold(150, "bodies", "numpy", "modes of more are found by sparse matrices", "seconds")
    no_eigenvalue: float = threshold(
        1e-14, "1", "numpy", "a smaller eigenvalue beside the largest is round-off of one that is 0", "45 ε"
    )
    shift: float = threshold(
        0.1, "1", "numpy", "Arnoldi's iteration is shifted by so much of the slowest frequency", "chosen"
    )
    first_shift: float = threshold(
        1e-5, "1", "numpy", "which is looked for from so much of the fastest on", "chosen: keeps half of the digits"
    )
    same_sample: float = threshold(
        1e-9, "1", "numpy", "a time is that of a sample where it differs by no more of the span", "as the reader's"
    )
    told_in_name: float = threshold(
        0.5, "1", "numpy", "a mode is named by what has so much of the largest share of its energy", "words only"
    )
    balanced: float = threshold(
        1e-9, "1", "numpy", "forces balance where no more than this part of the largest is left", "√ε, with room"
    )
