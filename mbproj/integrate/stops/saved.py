"""Where a run with stops or dry friction can go on from, as plain data."""

from __future__ import annotations

from typing import Any, Protocol, cast

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.integrate.reporting.marks import Mark, restore_tally, saved_tally
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.stops.variants import Variants
from mbproj.model.contacts import Contacts
from mbproj.model.system import System


class Standing(Protocol):
    """What a leg depends on."""

    system: System
    state: State
    contacts: Contacts
    push: float
    fastest: float
    integrals: Array
    tally: Tally
    variants: Variants
    shared: tuple[str, ...]


def saved(at: Standing) -> dict[str, Any]:
    """All that a leg depends on, but for the events before it."""
    state, contacts, chosen = at.state, at.contacts, at.variants.chosen_at
    return {
        "law": LAW,
        "state": _listed(state),
        "held": list(contacts.held),
        **{name: [[k, x] for k, x in getattr(contacts, name).items()] for name in NUMBERED},
        **{name: sorted(getattr(contacts, name)) for name in MARKED},
        "shares": [[k, [list(each) for each in parts]] for k, parts in contacts.shares.items()],
        "decides": contacts.decides,
        "push": at.push,
        "fastest": at.fastest,
        "integrals": at.integrals.tolist(),
        "shared": list(at.shared),
        "chosen": [[held, [list(each) for each in stuck], _listed(where)] for (held, stuck), where in chosen.items()],
        "tally": saved_tally(at.tally),
    }


def _listed(state: State) -> list[Any]:
    return [state.t, *(part.tolist() for part in state.layout.shared(state.y, state.layout).values())]


def _state(system: System, saved: list[Any]) -> State:
    """Of an older version it may be without the last blocks."""
    t, *parts = saved
    blocks = {block.name: np.array(part, dtype=float) for block, part in zip(system.layout.blocks, parts, strict=False)}
    return State.of(system, float(t), **blocks)


#: The law of stops with restitution that a mark was made by: their number in `pushing` depends on it.
LAW = 2
#: What `Contacts` has by the number of a stop or a friction, and what it is.
NUMBERED = {"pushing": float, "sliding": float, "stuck": float, "bearing": float}


#: What it has as sets of frictions.
MARKED = ("straight", "starting", "idle")


def restore(at: Standing, mark: Mark) -> None:
    """Goes on from what was saved. Raises ValueError where that is not of this mechanism."""
    at.state = _state(at.system, mark["state"])
    held = tuple(int(k) for k in mark["held"])
    numbered = {name: {int(k): kind(x) for k, x in mark[name]} for name, kind in NUMBERED.items()}
    stops, frictions = len(at.system.names.stops), len(at.system.names.frictions)
    if any(not 0 <= k < stops for k in (*held, *numbered["pushing"])):
        raise ValueError("a stop is not there")
    if any(not 0 <= k < frictions for name in ("sliding", "stuck", "bearing") for k in numbered[name]):
        raise ValueError("a friction is not there")
    if numbered["pushing"] and mark.get("law") != LAW:
        raise ValueError("an older mbproj made it, with another law of stops that give way")
    marked = {name: frozenset(int(k) for k in mark[name]) for name in MARKED}
    shares = {int(k): tuple((int(own), float(part)) for own, part in parts) for k, parts in mark["shares"]}
    if any(not 0 <= k < stops or any(own not in held for own, _ in parts) for k, parts in shares.items()):
        raise ValueError("what shares is not there")
    at.contacts = Contacts(
        held, shares=shares, decides=bool(mark["decides"]), **cast("dict[str, Any]", numbered | marked)
    )
    for stopped, stuck, where in mark["chosen"]:
        rows = tuple(int(k) for k in stopped), tuple((int(k), float(x)) for k, x in stuck)
        if any(not 0 <= k < stops for k in rows[0]) or any(not 0 <= k < frictions for k, _ in rows[1]):
            raise ValueError("what is held is not there")
        at.variants.choose(rows, _state(at.system, where))
    at.push, at.fastest = float(mark["push"]), float(mark["fastest"])
    at.integrals = np.array(mark["integrals"], dtype=float)
    at.shared = tuple(str(name) for name in mark.get("shared", ()))
    restore_tally(at.tally, mark["tally"])
