"""The dry frictions of a run: how often and how long each stuck, its largest force, and the energy that it lost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from mbproj.arrays import Flags
from mbproj.results import Results

#: The kinds of events after which a friction slides.
SLIDES = ("slip", "turn")
#: The names of the two tangents in a stop's plane, along which its friction acts.
TANGENTS = ("1", "2")


class FrictionHistory(TypedDict):
    """The history of a friction. `unit` is that of its coordinate, m or rad. `sticks`, `slips` and `turns` count how
    often it began to stick, began to slip, and reversed its sliding. `sticking_part` is a part of the time.
    `largest_force` is in N or N m, `energy` the lost energy in J. Numbers from samples are None where there are
    none."""

    unit: str
    sticks: int
    slips: int
    turns: int
    sticking_seconds: float | None
    sticking_part: float | None
    largest_force: float | None
    energy: float | None


def friction_records(results: Results) -> dict[str, FrictionHistory]:
    """The history of each dry friction that can stick, by its name. The two tangents of a stop count as one, by the
    stop's name."""
    names = results.names("frictions")
    together = {_owner(results, name): _with_partner(results, name) for name in names}
    return {owner: _rubbed(results, owner, columns) for owner, columns in together.items()}


def _rubbed(results: Results, owner: str, columns: Sequence[int]) -> FrictionHistory:
    """The history of the friction in these columns."""
    time, unit = results.time, results.names("friction_units")[columns[0]]
    kinds = [kind for _, kind in _changes(results, owner, columns)]
    history = FrictionHistory(
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
        return history
    spans = sticking(results, results.names("frictions")[columns[0]])
    held, lasts = sum(end - begin for begin, end in spans), float(time[-1] - time[0])
    force, lost = (results[f"friction/{quantity}"][:, columns] for quantity in ("force", "dissipation"))
    history["sticking_seconds"], history["sticking_part"] = held, held / lasts if lasts > 0.0 else None
    history["largest_force"] = float(np.linalg.norm(force, axis=1).max())
    history["energy"] = float((lost[-1] - lost[0]).sum())
    return history


def sticking(results: Results, name: str) -> list[tuple[float, float]]:
    """The spans of time (begin, end), s, in which a friction sticks, within the samples. Friction at a stop counts only
    while the stop touches."""
    time, owner, columns = results.time, _owner(results, name), _with_partner(results, name)
    if not len(time):
        return []
    if len(columns) > 1:
        return _spans_by_samples(results, owner, _sticks(results, owner, columns))
    since = float(time[0]) if _sticks(results, owner, columns)[0] else None
    notes = []
    for at, kind in _changes(results, owner, columns):
        if kind == "stick" and since is None:
            since = at
        elif kind in SLIDES and since is not None:
            notes.append((since, at))
            since = None
    if since is not None:
        notes.append((since, float(time[-1])))
    return [(begin, end) for begin, end in notes if end > begin]


def _spans_by_samples(results: Results, owner: str, sticks: Flags) -> list[tuple[float, float]]:
    """The spans of successive samples that stick. They begin and end at events of the friction or its stop, where there
    are such."""
    time, owners = results.time, (f"friction '{owner}'", f"stop '{owner}'")
    happened = np.array([each.time for each in results.events if each.name in owners])

    def change(k: int) -> float:
        """The time of the change between the samples k - 1 and k, s."""
        between = happened[(happened >= time[k - 1]) & (happened <= time[k])]
        return float(between[-1]) if len(between) else float(time[k])

    ends = np.flatnonzero(np.diff(sticks)) + 1
    times = [*([float(time[0])] if sticks[0] else []), *(change(int(k)) for k in ends)]
    times += [float(time[-1])] if sticks[-1] else []
    return [(begin, end) for begin, end in zip(times[::2], times[1::2], strict=True) if end > begin]


def _owner(results: Results, name: str) -> str:
    """The name of a friction in events: that of its stop, for friction at a stop."""
    stem, _, tangent = name.rpartition(".")
    return stem if tangent in TANGENTS and stem in results.names("stops") else name


def _with_partner(results: Results, name: str) -> list[int]:
    """The column of a friction; for friction at a stop the columns of both tangents."""
    names, owner = results.names("frictions"), _owner(results, name)
    own = [name] if owner == name else [f"{owner}.{tangent}" for tangent in TANGENTS]
    return [names.index(each) for each in own]


def _sticks(results: Results, owner: str, columns: Sequence[int]) -> Flags:
    """Mark the samples at which the friction sticks, (T,)."""
    still: Flags = (results["friction/state"][:, columns] == 0.0).all(axis=1)
    return still & (results.stop(owner).force > 0.0) if len(columns) > 1 else still


def _changes(results: Results, owner: str, columns: Sequence[int]) -> list[tuple[float, str]]:
    """The times at which a friction began to stick, slip or reverse, with the kind, within the time of the samples.
    They come from events. They come from samples where a file has no events, as after a run was killed."""
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
    """The kind of event that leads from one state of a friction to another."""
    if after == 0.0:
        return "stick"
    return "slip" if before == 0.0 else "turn"


def in_words(record: FrictionHistory) -> str:
    """A line on the history of a friction."""
    held, force, energy = record["sticking_seconds"], record["largest_force"], record["energy"]
    if held is None or force is None or energy is None:
        return "no samples"
    counts = {"began to stick": record["sticks"], "slipped": record["slips"], "turned": record["turns"]}
    parts = [f"{what} {'once' if count == 1 else f'{count} times'}" for what, count in counts.items() if count]
    part = record["sticking_part"]
    if part == 1.0:
        parts.append("stuck all the time")
    else:
        parts.append(f"stuck for {held:.4g} s" + (f" ({100 * part:.3g} %)" if part else ""))
    most = f"torque {force:.4g} N m" if record["unit"] == "rad" else f"force {force:.4g} N"
    return ", ".join([*parts, f"{most} at most", f"lost {energy:.4g} J"])
