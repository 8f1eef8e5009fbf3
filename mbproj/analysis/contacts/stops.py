"""The stops of a run: how often each was struck, its largest force, and the energy that it took."""

from __future__ import annotations

from typing import TypedDict

from mbproj.results import Results


class Seen(TypedDict):
    """The history of a stop. `unit` is that of its coordinate, m or rad. `least_gap` and `largest_force` are over the
    samples, or None without samples. `impacts` is their number, with the largest impulse (N s or N m s) and the energy
    (J) that all took."""

    unit: str
    least_gap: float | None
    largest_force: float | None
    impacts: int
    largest_impulse: float
    energy: float


def seen_by_stops(results: Results) -> dict[str, Seen]:
    """The history of each stop, by its name."""
    found: dict[str, Seen] = {}
    for column, (name, unit) in enumerate(zip(results.names("stops"), results.names("stop_units"), strict=True)):
        struck = [event for event in results.events if event.name == f"stop '{name}'" and event.impulse > 0.0]
        gap, force = (results[f"stops/{quantity}"][:, column] for quantity in ("gap", "force"))
        found[name] = Seen(
            unit=unit,
            least_gap=float(gap.min()) if len(gap) else None,
            largest_force=float(force.max()) if len(force) else None,
            impacts=len(struck),
            largest_impulse=max((event.impulse for event in struck), default=0.0),
            energy=sum(event.energy for event in struck),
        )
    return found


def in_words(seen: Seen) -> str:
    """A line on the history of a stop."""
    load, unit = ("N m" if seen["unit"] == "rad" else "N"), seen["unit"]
    parts = []
    if seen["least_gap"] is not None and seen["largest_force"] is not None:
        parts = [f"gap {seen['least_gap']:.4g} {unit} at least", f"force {seen['largest_force']:.4g} {load} at most"]
    if seen["impacts"]:
        once = "1 impact" if seen["impacts"] == 1 else f"{seen['impacts']} impacts"
        parts += [f"{once} of up to {seen['largest_impulse']:.4g} {load} s, which took {seen['energy']:.4g} J"]
    return ", ".join(parts) or "no samples"
