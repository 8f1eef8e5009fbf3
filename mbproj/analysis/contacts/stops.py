"""The stops of a run: how often each was struck, its largest force, and the energy that it took."""

from __future__ import annotations

from typing import TypedDict

from mbproj.results import Results


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


def in_words(record: StopHistory) -> str:
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
