"""The one record of every number that was chosen, not derived: what counts as dependent, closed, near, at rest.

Each has a value, a unit, a reason and a source. NumPy's code reads `THRESHOLDS`; the kernel gets those that it uses as
one struct with each model. `mbproj info --thresholds` prints the table. Numbers that are mathematics stand where they
are used: 4 ε, 2π, the coefficients of a method, and how many rows a message shows.
A source that begins with "no case" names a test that holds with quite another value: such a threshold may go.
"""

from __future__ import annotations

from dataclasses import Field
from functools import cache
from typing import Any, NamedTuple, final

from mbproj.dataclass import dataclass
from mbproj.thresholds.closing import Closing
from mbproj.thresholds.common import Common
from mbproj.thresholds.contact import Contact
from mbproj.thresholds.curves import Curves, Ropes
from mbproj.thresholds.dependence import Dependence
from mbproj.thresholds.elimination import Elimination
from mbproj.thresholds.invariants import Invariants
from mbproj.thresholds.linear import Linear
from mbproj.thresholds.passages import Passages
from mbproj.thresholds.searches import Looks, Searches
from mbproj.thresholds.steps import Automatic, Steps

__all__ = ["THRESHOLDS", "ThresholdRow", "Thresholds", "of_the_kernel", "table"]


@final
@dataclass(frozen=True)
class Thresholds(
    Common,
    Automatic,
    Linear,
    Contact,
    Looks,
    Searches,
    Steps,
    Invariants,
    Closing,
    Passages,
    Elimination,
    Curves,
    Ropes,
    Dependence,
):
    """All of them, each under its name."""

    def __init__(self, **others: float) -> None:
        """As chosen, but for `others`. A function with each of them as a parameter would take 6 ms to compile."""
        chosen = {name: entry.default for name, entry in _DECLARED.items()}
        unknown = others.keys() - chosen.keys()
        if unknown:
            raise TypeError(f"there is no threshold '{min(unknown)}'")
        vars(self).update(chosen | others)


#: As the groups declare them. `fields` would look at each declaration twice, 5 ms in each process.
_DECLARED: dict[str, Field[Any]] = {
    name: entry
    for group in reversed(Thresholds.__mro__)
    for name, entry in vars(group).items()
    if isinstance(entry, Field)
}
THRESHOLDS = Thresholds()


class ThresholdRow(NamedTuple):
    """One threshold; `used_by` says whether NumPy's code, the kernel's, or both have it."""

    name: str
    value: float
    unit: str
    used_by: str
    why: str
    source: str


def table() -> list[ThresholdRow]:
    """All thresholds, group by group."""
    return [
        ThresholdRow(
            name,
            getattr(THRESHOLDS, name),
            **{key: entry.metadata[key] for key in ("unit", "used_by", "why", "source")},
        )
        for name, entry in _DECLARED.items()
    ]


def of_the_kernel(thresholds: Thresholds = THRESHOLDS) -> dict[str, Any]:
    """Those that the kernel uses, by name."""
    return {name: getattr(thresholds, name) for name in _kernel_names()}


@cache
def _kernel_names() -> tuple[str, ...]:
    return tuple(row.name for row in table() if row.used_by != "numpy")
