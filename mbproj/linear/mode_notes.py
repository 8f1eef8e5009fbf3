"""Words on modes: the states that take part, and notes on the reference."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.dynamics.derivatives.law_derivatives import channel_slopes, state_slopes
from mbproj.dynamics.equations.forces import state_rates
from mbproj.errors import shortened
from mbproj.linear.modes import Modes, leading
from mbproj.linear.reference import LinearReference
from mbproj.thresholds import THRESHOLDS

#: The most dry frictions that are named.
MOST_HELD = 8
#: The coordinates in which frequencies hold away from balance, in words.
COORDINATES = "shifts and turns of the bodies on the tangent space, which turns along the motion as little as it can"


def states_in(modes: Modes, mode: int) -> str:
    """Return the states of elements with the largest part in a mode: "state 'current'"."""
    names, share = modes.reference.system.names.states, modes.state_share[mode]
    return " and ".join(f"state '{names[index]}'" for index in leading(share))


def notes_on(modes: Modes) -> list[str]:
    """Return the notes that a reader of the frequencies needs."""
    return list(_notes(modes))


def _notes(modes: Modes) -> Iterator[str]:
    reference = modes.reference
    if not is_balanced(reference):
        off = reference.imbalance
        yield (
            f"forces do not balance here: up to {off.force:.3g} N and {off.torque:.3g} N m are left "
            f"({off.relative:.2g} of the largest); frequencies then depend on the coordinates: {COORDINATES}"
        )
    if unsteady := unsteady_states(reference):
        yield unsteady
    if reference.held:
        names = shortened([f"'{name}'" for name in reference.held], MOST_HELD)
        yield f"dry friction holds its coordinates as they are: {names}"
    if modes.turns:
        yield "the mechanism moves: these are the modes of this instant, and hold for as long as it hardly moves"


def unsteady_states(reference: LinearReference) -> str:
    """Return the note that states of elements change at a reference, with their rates; "" where they do not."""
    system = reference.system
    if not system.states.size:
        return ""
    instant = reference.motion.instant(system)
    rates, terms = state_rates(instant), np.abs(channel_slopes(instant)[1]) @ np.abs(instant.channels)
    size = terms + np.abs(state_slopes(instant)) @ system.states.scale
    changing = np.flatnonzero(np.abs(rates) > THRESHOLDS.dependent * size)
    named = zip(system.names.states, rates.tolist(), system.names.state_units, strict=True)
    told = [f"'{name}' by {rate:.3g} {unit}/s" for name, rate, unit in named]
    return f"states change here: {', '.join(told[k] for k in changing[:MOST_HELD])}" if len(changing) else ""


def is_balanced(reference: LinearReference) -> bool:
    """Return whether the forces balance to round-off."""
    return reference.imbalance.relative <= THRESHOLDS.dependent
