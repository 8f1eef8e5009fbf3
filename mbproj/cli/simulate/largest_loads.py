"""The largest loads of a run, as lines and for JSON (`info --loads`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees, isnan
from typing import Any

from mbproj.analysis.loads import cycle_of, duration_above, loads_of, recorded_in, samples_of, swings
from mbproj.cli.report.text import columns
from mbproj.results import Results
from mbproj.results.loads.largest import Load

HEADINGS = ("load", "largest", "unit", "at t (s)", "place", "mean", "rms")
#: A load below this part of the largest one in its unit counts as zero.
NOTHING = 1e-9


def facts(results: Results, over: str | None, level: float | None, *, rainflow: bool) -> dict[str, Any]:
    """The loads as a dictionary for JSON. `level` is a part of each largest load; the time above it is computed."""
    return {
        "file": str(results.path),
        "place_of": None if (place := place_of(results, over)) is None else place[0],
        "loads": [_facts(results, load, level, rainflow=rainflow) for load in loads_of(results, over)],
    }


def _facts(results: Results, load: Load, level: float | None, *, rainflow: bool) -> dict[str, Any]:
    entry: dict[str, Any] = load._asdict()
    if level is not None:
        entry["above"] = level * abs(load.largest)
        entry["duration_above"] = duration_above(results.time, samples_of(results, load), entry["above"])
    if rainflow:
        entry["rainflow"] = [swing._asdict() for swing in swings(samples_of(results, load))]
    return entry


def place_of(results: Results, over: str | None) -> tuple[str, str] | None:
    """The coordinate that tells the place in the cycle, and its unit: `over`, or that of the first motion; None without
    either."""
    cycle = cycle_of(results, over) if over else recorded_in(results).cycle()
    return None if cycle is None else (cycle.name, cycle.unit)


def lines(results: Results, over: str | None, level: float | None, *, rainflow: bool) -> Iterator[str]:
    """Yield a table of the loads, then works, durations and counts."""
    all_loads = loads_of(results, over)
    felt = [load for load in all_loads if not _is_round_off(load, all_loads)]
    if not felt:
        yield "nothing is loaded" if all_loads else "there are no joints, motions or forces that could be loaded"
        return
    place = place_of(results, over)
    yield columns(HEADINGS, [_row(load, place[1] if place else "") for load in felt])
    yield "\n± is the uncertainty between samples; the error of the run itself comes on top (run --certify)"
    if place is not None:
        yield f"place: {place[0]}{', modulo a turn' if place[1] == 'rad' else ''}"
    if any(not load.unique for load in felt):
        yield "*: redundant joints can share it in any proportion"
    works = [load for load in felt if not isnan(load.put_in)]
    if works:
        yield "\nworks"
        named = [(_name(load).removesuffix(" power"), f"{load.put_in:.6g}", f"{load.taken_out:.6g}") for load in works]
        yield columns(("of", "put in (J)", "taken out (J)"), named)
    if level is not None:
        yield f"\nduration above {level:g} of the largest"
        for load in felt:
            values = samples_of(results, load)
            yield f"  {_name(load)}: {duration_above(results.time, values, level * abs(load.largest)):.6g} s"
    if rainflow:
        for load in felt:
            yield f"\nswings of {_name(load)} ({load.unit})"
            counted = swings(samples_of(results, load))
            rows = [(f"{each.range:.5g}", f"{each.mean:.5g}", f"{each.cycles:g}") for each in counted]
            yield columns(("range", "mean", "cycles"), rows)


def _is_round_off(load: Load, loads: Sequence[Load]) -> bool:
    """Whether a load is zero apart from round-off, relative to the others in its unit. A torque is also compared with
    forces at an arm of 1 m."""
    units = {"N", "N m"} if load.unit == "N m" else {load.unit}
    largest = max(abs(other.largest) for other in loads if other.unit in units)
    return abs(load.largest) <= NOTHING * largest or load.largest == 0.0


def _name(load: Load) -> str:
    return f"{load.kind} '{load.name}' {load.quantity.replace('_', ' ')}"


def _row(load: Load, unit: str) -> tuple[str, ...]:
    place = f"{degrees(load.place):.1f}°" if unit == "rad" else f"{load.place:.5g} {unit}" if unit else "-"
    return cells(load, _name(load) + ("" if load.unique else " *"), place)


def cells(load: Load, name: str, place: str) -> tuple[str, ...]:
    """The row of a load in a table, with this name and its place in the cycle."""
    return (
        name,
        f"{load.largest:.6g} ± {load.uncertainty:.1g}",
        load.unit,
        f"{load.time:.6g}",
        place,
        f"{load.mean:.5g}",
        f"{load.rms:.5g}",
    )
