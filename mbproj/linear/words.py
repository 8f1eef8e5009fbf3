"""What is said of modes: a name for each, by what moves and what gives way, and notes on where they are taken."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.linear.modes import Modes
from mbproj.linear.reference import Reference
from mbproj.thresholds import THRESHOLDS

#: Dry frictions that are named at most.
MOST_HELD = 8
#: How the coordinates are called in which frequencies hold away from balance.
COORDINATES = "shifts and turns of the bodies on the tangent space, which turns along the motion as little as it can"


def name_of(modes: Modes, mode: int) -> str:
    """What moves most in a mode, by kinetic energy, and what gives way most: "wheel 91 %, spring tyre 83 %"."""
    moving = _largest(modes.kinetic_names, modes.kinetic[mode])
    if modes.eigenvalues[mode] == 0.0:
        return f"neutral: {moving}"
    return f"{moving}; {_largest(modes.strain_names, modes.strain[mode])}" if modes.strain[mode].any() else moving


def _largest(names: Sequence[str], shares: Array) -> str:
    order = np.argsort(-shares, kind="stable")
    told = [
        index
        for index in order[:2]
        if shares[index] >= THRESHOLDS.told_in_name * shares[order[0]] and shares[index] > 0.0
    ]
    return ", ".join(f"{names[index]} {100.0 * shares[index]:.0f} %" for index in told)


def notes_on(modes: Modes) -> list[str]:
    """What a reader of the frequencies has to know."""
    return list(_notes(modes))


def _notes(modes: Modes) -> Iterator[str]:
    reference = modes.reference
    if not is_balanced(reference):
        off = reference.imbalance
        yield (
            f"forces do not balance here: up to {off.force:.3g} N and {off.torque:.3g} N m are left "
            f"({off.relative:.2g} of the largest); frequencies then depend on the coordinates: {COORDINATES}"
        )
    if reference.held:
        yield f"dry friction holds its coordinates as they are: {_listed(reference.held)}"
    if modes.turns:
        yield "the mechanism moves: these are the modes of this instant, and hold for as long as it hardly moves"


def _listed(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    more = f" and {len(names) - MOST_HELD} more" if len(names) > MOST_HELD else ""
    return ", ".join(f"'{name}'" for name in names[:MOST_HELD]) + more


def is_balanced(reference: Reference) -> bool:
    """Whether no more than round-off of the forces is left."""
    return reference.imbalance.relative <= THRESHOLDS.balanced
