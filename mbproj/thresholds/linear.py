"""Equilibrium, modes and linear models: what is round-off, and what is large."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Linear:
    """Parts of sums without their signs, unless a unit says otherwise."""

    linear_round_off: float = threshold(
        1e-12, "1", "numpy", "a smaller part of a stiffness or damping is none", "ε × some thousand terms"
    )
    dense_modes: int = threshold(150, "bodies", "numpy", "modes of more are found by sparse matrices", "seconds")
    dense_freedom: int = threshold(
        1200,
        "degrees of freedom",
        "numpy",
        "linear models, steady turns, modes that need dense matrices have no more",
        "some minutes",
    )
    dense_equilibria: int = threshold(
        20, "bodies", "numpy", "the rest of more is found by sparse matrices", "the quicker"
    )
    no_eigenvalue: float = threshold(
        1e-14, "1", "numpy", "a smaller eigenvalue beside the largest is round-off of one that is 0", "45 ε"
    )
    shift: float = threshold(
        0.1, "1", "numpy", "Arnoldi's iteration is shifted by so much of the slowest frequency", "chosen"
    )
    first_shift: float = threshold(
        1e-5, "1", "numpy", "which is looked for from so much of the fastest on", "chosen: keeps half of the digits"
    )
    beside_kink: float = threshold(1e-8, "1", "numpy", "a force is looked at so far beside a pose", "√ε")
    jumping_slope: float = threshold(
        1e-3, "1", "numpy", "its slope jumps there where it changes by so much", "chosen: round-off leaves 1e-8"
    )
    same_sample: float = threshold(
        1e-9, "1", "numpy", "a time is that of a sample where it differs by no more of the span", "as the reader's"
    )
    told_in_name: float = threshold(
        0.5, "1", "numpy", "a mode is named by what has so much of the largest share of its energy", "words only"
    )
    closed_at_rest: float = threshold(
        1e-15, "length, rad", "numpy", "poses on the way to an equilibrium are closed to this", "round-off"
    )
    most_balancing: int = threshold(300, "-", "numpy", "steps on the way to an equilibrium", "chosen")
    rolled: float = threshold(
        0.05, "length, rad", "numpy", "what rolls goes on by so much at once", "fourth order: slips by 1e-7 of the way"
    )
    first_radius: float = threshold(
        0.2, "length, rad", "numpy", "the first of them is no longer", "chosen: the model holds for tenths of a radian"
    )
    largest_radius: float = threshold(1.0, "length, rad", "numpy", "nor is any longer than this", "chosen")
    good_step: float = threshold(
        0.1, "1", "numpy", "a step is taken where the forces do so much of the work that was expected", "usual: 0.1"
    )
    free_fall: float = threshold(
        12.0, "length, rad", "numpy", "a way so long without a change of force goes on for ever", "two turns of a shaft"
    )
    same_force: float = threshold(1e-2, "1", "numpy", "a force that changes by less is the same then", "chosen")
    grown_modes: float = threshold(
        1e-7, "1", "numpy", "a mode grows where it does by more of the fastest mode's speed", "√ε, with room"
    )
    turned_balance: float = threshold(
        1e-6, "1", "numpy", "forces turn with a mechanism where no more is left of them after a turn", "√ε, with room"
    )
    far_away: float = threshold(
        30.0, "length", "numpy", "what has no equilibrium so far from the start is said to have none", "chosen"
    )
    lies_flat: float = threshold(
        1e-3, "1", "numpy", "a wheel lies flat where the sine between its axis and the normal is less", "chosen"
    )
    written_pose: float = threshold(
        1e-9, "m, rad", "numpy", "a pose is that which was written where it is off by no more", "as it assembles"
    )
    other_starts: float = threshold(
        2.0, "length, rad", "numpy", "other equilibria are sought from poses within this", "chosen"
    )
    force_grain: float = threshold(
        1.5e-14, "1", "numpy", "a sum of forces is round-off below this part of the largest", "64 ε"
    )
    told_coordinate: float = threshold(
        0.3, "1", "numpy", "a motion is named by coordinates that change by so much of the largest", "words only"
    )
    balanced: float = threshold(
        1e-9, "1", "numpy", "forces balance where no more than this part of the largest is left", "√ε, with room"
    )
    proximal: float = threshold(
        1e-10, "1", "numpy", "rows of large mechanisms give way by so much, which is taken out again", "√ε, with room"
    )
    most_proximal: int = threshold(30, "-", "numpy", "in so many steps at most", "chosen")
    penalty: float = threshold(
        1e7, "1", "numpy", "rows are made so stiff to ask what is definite without them", "1 / √ε, with room"
    )
    no_shift: float = threshold(
        1e-11,
        "1",
        "numpy",
        "the stiffness of large mechanisms is raised by so much of the largest",
        "for what is neutral",
    )
    clear_distance: float = threshold(
        1e-3,
        "1",
        "numpy",
        "rows of long loops that are farther from each other are independent",
        "⁵√ε: in half of the digits",
    )
    free_rank: float = threshold(
        1e-13,
        "1",
        "numpy",
        "smaller singular values of the mass of free motions count as none",
        "450 ε: massless bodies",
    )
    same_pose: float = threshold(
        1e-5, "length, rad", "numpy", "equilibria whose bodies are nearer are one", "far above what balancing leaves"
    )
    first_damping: float = threshold(
        1e-8, "1", "numpy", "steps of a worse balance are damped by so much of the largest stiffness", "√ε"
    )
    most_damping: float = threshold(
        1e12, "1", "numpy", "where so much is needed there is no better balance nearby", "chosen"
    )
    stalled_steps: int = threshold(10, "-", "numpy", "so many steps that gain less lead to no better balance", "chosen")
    stalled: float = threshold(
        0.01,
        "1",
        "numpy",
        "steps have to lower what is left by so much of it",
        "one length of a hundred takes 10 steps",
    )
    most_of_round: int = threshold(20_000, "-", "numpy", "a round of controllers has no more instants", "seconds")
    largest_ratio: int = threshold(
        1000, "-", "numpy", "periods are no more than so many parts of the shortest one", "chosen"
    )
    same_instant: float = threshold(
        1e-9, "period", "numpy", "instants of a round that are nearer are one", "far above round-off"
    )
    no_damping: float = threshold(1e-12, "1", "numpy", "less damping than this is none", "4500 ε")
    slowest_sought: float = threshold(
        1e-3, "rad/s", "numpy", "the first shift is chosen as if a mode had at least this speed", "chosen"
    )
