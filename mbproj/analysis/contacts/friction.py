"""What each dry friction of a run has done: how often it stuck and slid, for how long, how hard, and what that cost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from mbproj.arrays import Flags
from mbproj.results import Results

#: Kinds of events after which a friction slides.
SLIDES = ("slip", "turn")
#: What the two tangents are called along which a point rubs on the plane of a stop.
TANGENTS = ("1", "2")


class Rubbed(TypedDict):
    """The `unit` of what a friction resists, m or rad; how often it began to stick, to slip, and turned from sliding
    one way to sliding the other way; for how many s it stuck, and for what part of the time; the largest size of its
    force in N or torque in N m, and the energy in J that it has lost. None where there are no samples."""

    unit: str
    sticks: int
    slips: int
    turns: int
    sticking_seconds: float | None
    sticking_part: float | None
    largest_force: float | None
    energy: float | None


def rubbed_by_frictions(results: Results) -> dict[str, Rubbed]:
    """By the names of the dry frictions that can stick; of a stop both tangents together, by its name."""
    names = results.names("frictions")
    together = {_owner(results, name): _with_partner(results, name) for name in names}
    return {owner: _rubbed(results, owner, columns) for owner, columns in together.items()}


def _rubbed(results: Results, owner: str, columns: Sequence[int]) -> Rubbed:
    """What the friction in these columns has done."""
    time, unit = results.time, results.names("friction_units")[columns[0]]
    kinds = [kind for _, kind in _changes(results, owner, columns)]
    found = Rubbed(
        unit=unit,
        sticks=kinds.count("stick"),
        slips=kinds.count("slip"),
        turns=kinds.count("turn"),
        sticking_seconds=None,
        sticking_part=None,
        largest_force=None,
        energy=None,
    )
    if not len(time):
        return found
    spans = sticking(results, results.names("frictions")[columns[0]])
    held, lasts = sum(end - begin for begin, end in spans), float(time[-1] - time[0])
    force, lost = (results[f"friction/{quantity}"][:, columns] for quantity in ("force", "dissipation"))
    found["sticking_seconds"], found["sticking_part"] = held, held / lasts if lasts > 0.0 else None
    found["largest_force"] = float(np.linalg.norm(force, axis=1).max())
    found["energy"] = float((lost[-1] - lost[0]).sum())
    return found


def sticking(results: Results, name: str) -> list[tuple[float, float]]:
    """The spans of time, (begin, end) in s, in which a friction sticks, within those of the samples; that of a stop
    while this touches."""
    time, owner, columns = results.time, _owner(results, name), _with_partner(results, name)
    if not len(time):
        return []
    if len(columns) > 1:
        return _spans_by_samples(results, owner, _sticks(results, owner, columns))
    since = float(time[0]) if _sticks(results, owner, columns)[0] else None
    found = []
    for at, kind in _changes(results, owner, columns):
        if kind == "stick" and since is None:
            since = at
        elif kind in SLIDES and since is not None:
            found.append((since, at))
            since = None
    if since is not None:
        found.append((since, float(time[-1])))
    return [(begin, end) for begin, end in found if end > begin]


def _spans_by_samples(results: Results, owner: str, sticks: Flags) -> list[tuple[float, float]]:
    """Where samples stick one after another, with the ends where there are events of the friction or its stop."""
    time, owners = results.time, (f"friction '{owner}'", f"stop '{owner}'")
    happened = np.array([each.time for each in results.events if each.name in owners])

    def change(k: int) -> float:
        """When, between the samples k - 1 and k."""
        between = happened[(happened >= time[k - 1]) & (happened <= time[k])]
        return float(between[-1]) if len(between) else float(time[k])

    ends = np.flatnonzero(np.diff(sticks)) + 1
    times = [*([float(time[0])] if sticks[0] else []), *(change(int(k)) for k in ends)]
    times += [float(time[-1])] if sticks[-1] else []
    return [(begin, end) for begin, end in zip(times[::2], times[1::2], strict=True) if end > begin]


def _owner(results: Results, name: str) -> str:
    """What events call a friction: one at a stop by the name of that."""
    stem, _, tangent = name.rpartition(".")
    return stem if tangent in TANGENTS and stem in results.names("stops") else name


def _with_partner(results: Results, name: str) -> list[int]:
    """The column of a friction; of one at a stop those along both tangents."""
    names, owner = results.names("frictions"), _owner(results, name)
    own = [name] if owner == name else [f"{owner}.{tangent}" for tangent in TANGENTS]
    return [names.index(each) for each in own]


def _sticks(results: Results, owner: str, columns: Sequence[int]) -> Flags:
    """Which samples stick, (T,)."""
    still: Flags = (results["friction/state"][:, columns] == 0.0).all(axis=1)
    return still & (results.stop(owner).force > 0.0) if len(columns) > 1 else still


def _changes(results: Results, owner: str, columns: Sequence[int]) -> list[tuple[float, str]]:
    """When it began to stick or to slide, and which, within the time of the samples: by the events; by the samples
    where a file has no events, as of a run that was killed."""
    time = results.time
    if not len(time):
        return []
    whose, first, last = f"friction '{owner}'", float(time[0]), float(time[-1])
    if results.events:
        return [(each.time, each.kind) for each in results.events if each.name == whose and first <= each.time <= last]
    state = results["friction/state"][:, columns[0]]
    at = np.flatnonzero(np.diff(state)) + 1
    return [(float(time[k]), _kind(float(state[k - 1]), float(state[k]))) for k in at]


def _kind(before: float, after: float) -> str:
    """What leads from one state to another."""
    if after == 0.0:
        return "stick"
    return "slip" if before == 0.0 else "turn"


def in_words(rubbed: Rubbed) -> str:
    """One line on a friction."""
    held, force, energy = rubbed["sticking_seconds"], rubbed["largest_force"], rubbed["energy"]
    if held is None or force is None or energy is None:
        return "no samples"
    counts = {"began to stick": rubbed["sticks"], "slipped": rubbed["slips"], "turned": rubbed["turns"]}
    parts = [f"{what} {'once' if count == 1 else f'{count} times'}" for what, count in counts.items() if count]
    part = rubbed["sticking_part"]
    if part == 1.0:
        parts.append("stuck all the time")
    else:
        parts.append(f"stuck for {held:.4g} s" + (f" ({100 * part:.3g} %)" if part else ""))
    most = f"torque {force:.4g} N m" if rubbed["unit"] == "rad" else f"force {force:.4g} N"
    return ", ".join([*parts, f"{most} at most", f"lost {energy:.4g} J"])
