"""What a run did where bodies touch or pull: the histories of dry frictions, of regularised frictions that crept, of
stops, and of ropes that pushed.

Each part takes the results, in SI units, and gives plain data by name, for JSON and for words. Numbers of samples are
over the T samples; counts, impulses and lost energies are from the events of the run.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from mbproj.base.arrays import Flags
from mbproj.base.errors import InputError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.results.record import Results
from mbproj.scene.records import JointForce
from mbproj.scene.scene import Scene, read_scene_text

# --- Dry friction: how often and how long each stuck, its largest force, and the energy that it lost ------------------

#: The kinds of events after which a friction slides.
SLIDES = ("slip", "turn")
#: Friction at a stop is two frictions in the results, along the two tangents of its plane: "stop.1" and "stop.2".
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
    columns_of = {_owner(results, name): _with_partner(results, name) for name in names}
    return {owner: _friction_history(results, owner, columns) for owner, columns in columns_of.items()}


def _friction_history(results: Results, owner: str, columns: Sequence[int]) -> FrictionHistory:
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
    stuck, duration = sum(end - begin for begin, end in spans), float(time[-1] - time[0])
    force, lost = (results[f"friction/{quantity}"][:, columns] for quantity in ("force", "dissipation"))
    history["sticking_seconds"], history["sticking_part"] = stuck, stuck / duration if duration > 0.0 else None
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
    spans = []
    for at, kind in _changes(results, owner, columns):
        if kind == "stick" and since is None:
            since = at
        elif kind in SLIDES and since is not None:
            spans.append((since, at))
            since = None
    if since is not None:
        spans.append((since, float(time[-1])))
    return [(begin, end) for begin, end in spans if end > begin]


def _spans_by_samples(results: Results, owner: str, sticks: Flags) -> list[tuple[float, float]]:
    """The spans of successive samples that stick. They begin and end at events of the friction or its stop, where there
    are such. `sticks` (T,) are the samples that stick."""
    time, owners = results.time, (f"friction '{owner}'", f"stop '{owner}'")
    event_times = np.array([event.time for event in results.events if event.name in owners])

    def change(k: int) -> float:
        """The time of the change between the samples k - 1 and k, s."""
        between = event_times[(event_times >= time[k - 1]) & (event_times <= time[k])]
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
    columns = [name] if owner == name else [f"{owner}.{tangent}" for tangent in TANGENTS]
    return [names.index(column) for column in columns]


def _sticks(results: Results, owner: str, columns: Sequence[int]) -> Flags:
    """Mark the samples at which the friction sticks, (T,): its state is 0 there, and at a stop the stop pushes."""
    still: Flags = (results["friction/state"][:, columns] == 0.0).all(axis=1)
    return still & (results.stop(owner).force > 0.0) if len(columns) > 1 else still


def _changes(results: Results, owner: str, columns: Sequence[int]) -> list[tuple[float, str]]:
    """The times at which a friction began to stick, slip or reverse, with the kind, within the time of the samples.
    They come from events. They come from samples where a file has no events, as after a run was killed."""
    time = results.time
    if not len(time):
        return []
    name, first, last = f"friction '{owner}'", float(time[0]), float(time[-1])
    if results.events:
        events = [event for event in results.events if event.name == name and first <= event.time <= last]
        return [(event.time, event.kind) for event in events]
    state = results["friction/state"][:, columns[0]]
    at = np.flatnonzero(np.diff(state)) + 1
    return [(float(time[k]), _kind(float(state[k - 1]), float(state[k]))) for k in at]


def _kind(before: float, after: float) -> str:
    """The kind of event that leads from one state of a friction to another."""
    if after == 0.0:
        return "stick"
    return "slip" if before == 0.0 else "turn"


def friction_in_words(record: FrictionHistory) -> str:
    """A line on the history of a friction."""
    stuck, force, energy = record["sticking_seconds"], record["largest_force"], record["energy"]
    if stuck is None or force is None or energy is None:
        return "no samples"
    counts = {"began to stick": record["sticks"], "slipped": record["slips"], "turned": record["turns"]}
    parts = [f"{what} {'once' if count == 1 else f'{count} times'}" for what, count in counts.items() if count]
    part = record["sticking_part"]
    if part == 1.0:
        parts.append("stuck all the time")
    else:
        parts.append(f"stuck for {stuck:.4g} s" + (f" ({100 * part:.3g} %)" if part else ""))
    most = f"torque {force:.4g} N m" if record["unit"] == "rad" else f"force {force:.4g} N"
    return ", ".join([*parts, f"{most} at most", f"lost {energy:.4g} J"])


# --- The creep of regularised dry friction, which moves slowly where exact friction would stick -----------------------

#: The key of regularised friction: a scene text without it has none.
KEY = "regularised"


class CreepHistory(TypedDict):
    """The creep of a regularised friction. `width` is the rate up to which it is smoothed, rad/s or m/s by its `unit`.
    `seconds` is the time with a smaller rate, `creep` the distance moved in that time, rad or m."""

    unit: str
    width: float
    seconds: float
    creep: float


def creep_by_friction(results: Results, scene: Scene | None = None) -> dict[str, CreepHistory]:
    """The creep of each regularised friction by its name, from the samples. The scene is read from the results where it
    is not given. The answer is empty where it cannot be read."""
    if KEY not in results.scene_text:
        return {}
    try:
        scene = scene or read_scene_text(results.scene_text, str(results.scene_path or results.path), results.overrides)
    except InputError:
        return {}
    histories: dict[str, CreepHistory] = {}
    for force in scene.forces:
        for coordinate, dry in force.coulomb.items() if isinstance(force, JointForce) else ():
            assert isinstance(force, JointForce)
            name = force.called(coordinate)
            if dry.regularised is not None and name in results.names("forces"):
                histories[name] = _creep_history(results, name, dry.unit, dry.regularised)
    return histories


def _creep_history(results: Results, name: str, unit: str, width: float) -> CreepHistory:
    """The creep of a friction, over intervals at whose ends its rate is below `width`."""
    force, time = results.force(name), results.time
    slow = np.abs(force.rate) <= width
    rests = slow[1:] & slow[:-1]
    return CreepHistory(
        unit=unit,
        width=width,
        seconds=float(np.diff(time)[rests].sum()),
        creep=float(np.abs(np.diff(force.coordinate))[rests].sum()),
    )


def creep_in_words(record: CreepHistory) -> str:
    """A line on the creep of a friction."""
    unit = record["unit"]
    if record["seconds"] == 0.0:
        return f"never slower than its {record['width']:.4g} {unit}/s"
    slower = f"slower than its {record['width']:.4g} {unit}/s"
    return f"crept by {record['creep']:.4g} {unit} in {record['seconds']:.4g} s, {slower}"


# --- Stops: how often each was struck, its largest force, and the energy that it took ---------------------------------


#: A stop is said to pull where it does by more than this part of its largest force, and of the tolerance.
PULLS = 1e-4


class StopHistory(TypedDict):
    """The history of a stop. `unit` is that of its coordinate, m or rad. `least_gap` and `largest_force` are over the
    samples, or None without samples. `impacts` is the number of impacts. The impulse is the largest of them (N s or N m
    s), the energy the sum of their losses (J)."""

    unit: str
    least_gap: float | None
    largest_force: float | None
    impacts: int
    largest_impulse: float
    energy: float


def stop_records(results: Results) -> dict[str, StopHistory]:
    """The history of each stop, by its name."""
    records: dict[str, StopHistory] = {}
    for column, (name, unit) in enumerate(zip(results.names("stops"), results.names("stop_units"), strict=True)):
        struck = [event for event in results.events if event.name == f"stop '{name}'" and event.impulse > 0.0]
        gap, force = (results[f"stops/{quantity}"][:, column] for quantity in ("gap", "force"))
        records[name] = StopHistory(
            unit=unit,
            least_gap=float(gap.min()) if len(gap) else None,
            largest_force=float(force.max()) if len(force) else None,
            impacts=len(struck),
            largest_impulse=max((event.impulse for event in struck), default=0.0),
            energy=sum(event.energy for event in struck),
        )
    return records


def stop_in_words(record: StopHistory) -> str:
    """A line on the history of a stop."""
    load, unit = ("N m" if record["unit"] == "rad" else "N"), record["unit"]
    parts = []
    if record["least_gap"] is not None and record["largest_force"] is not None:
        parts = [
            f"gap {record['least_gap']:.4g} {unit} at least",
            f"force {record['largest_force']:.4g} {load} at most",
        ]
    if record["impacts"]:
        once = "1 impact" if record["impacts"] == 1 else f"{record['impacts']} impacts"
        parts += [f"{once} of up to {record['largest_impulse']:.4g} {load} s, which took {record['energy']:.4g} J"]
    return ", ".join(parts) or "no samples"


def pulls_of_stops(results: Results) -> dict[str, Pushed]:
    """The largest pull of each stop that pulls at a sample, by its name: a release that no step has found."""
    found: dict[str, Pushed] = {}
    for column, name in enumerate(results.names("stops") if len(results.time) else ()):
        force = results["stops/force"][:, column]
        at = int(np.argmin(force))
        if force[at] < -max(PULLS, results.settings.tolerance or 0.0) * np.abs(force).max():
            found[name] = Pushed(push=-float(force[at]), time=float(results.time[at]))
    return found


def pulls_in_words(name: str, pull: Pushed) -> str:
    """A note on a stop that pulls."""
    least = f"stop '{name}' pulls with up to {pull['push']:.4g} N or N m, at {pull['time']:.6g} s"
    return f"{least}: it should have opened there; take a smaller tolerance or step"


# --- Ropes that pushed: in a model a rope of constant length can push; a real rope goes slack -------------------------


class Pushed(TypedDict):
    """The largest push of a rope, or pull of a stop, in N or N m, and its time, in s."""

    push: float
    time: float


def pushed_by_ropes(results: Results, scene: Scene) -> dict[str, Pushed]:
    """The largest push of each rope that pushes at a sample, by its name. A rope with limits is left out, because its
    limits may push."""
    pushed: dict[str, Pushed] = {}
    names = results.names("tensions")
    for joint in scene.joints:
        columns = [k for k, name in enumerate(names) if name.rpartition(".")[0] == joint.name]
        if not columns or joint.limits or not len(results.time):
            continue
        tension = results["ropes/tension"][:, columns]
        least = tension.min(axis=1)
        at = int(np.argmin(least))
        if least[at] < -THRESHOLDS.contact_pulls * np.abs(tension).max():
            pushed[joint.name] = Pushed(push=-float(least[at]), time=float(results.time[at]))
    return pushed


def rope_in_words(name: str, pushed: Pushed) -> str:
    """A note on a rope that pushes."""
    hint = "give it a 'length' and slack: true, or a 'stiffness'"
    return f"rope '{name}' pushes with up to {pushed['push']:.4g} N, at {pushed['time']:.6g} s: no rope does; {hint}"
