"""The goals that the kernel is held to, against what was measured. Of each time the fastest repetition counts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

Tables = Mapping[str, list[dict[str, Any]]]

#: µs a step of the five-bar by formulation.
FIVE_BAR = {"reduced": 6.0, "planar": 2.0}
#: µs a step and body of a chain of 10 000 over that of 5; Pinocchio's for long open chains, RK4 and no projection.
GROWTH, PINOCCHIO = 2.0, 1.5
#: Bytes a body.
MEMORY = 4000


def verdicts(tables: Tables) -> Iterator[tuple[str, str, bool]]:
    """Each goal that was measured, the value, and whether it is met."""
    for formulation, goal in FIVE_BAR.items():
        for row in tables["paper"]:
            if (row["size"], row["formulation"]) == ("five_bar", formulation):
                value = row["fastest"]
                yield f"five-bar, {formulation}: {goal:g} µs a step", f"{value:.3g} µs", value <= goal
    for formulation in FIVE_BAR:
        chains = {
            row["size"]: row["fastest"] / row["bodies"]
            for row in tables.get("chain", [])
            if row["formulation"] == formulation
        }
        if 5 in chains and 10_000 in chains:
            ratio = chains[10_000] / chains[5]
            yield f"chain of 10 000 over 5 links, a body, {formulation}: {GROWTH:g}", f"{ratio:.2f}", ratio <= GROWTH
        for size in (size for size in chains if size >= 100):
            value = chains[size]
            yield f"chain of {size}, {formulation}: {PINOCCHIO} µs a body", f"{value:.3g} µs", value <= PINOCCHIO
    for row in tables.get("memory", []):
        value = row["resident"]
        yield f"memory, {row['formulation']}: {MEMORY} bytes a body", f"{value:.0f}", value <= MEMORY
