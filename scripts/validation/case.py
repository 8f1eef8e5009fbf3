"""A validation case: where it comes from, how it is simulated, what is compared, and to which tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "mechanisms" / "validation"
TABLES = ROOT / "tests" / "data" / "validation"


@dataclass(frozen=True)
class Case:
    """A mechanism with results that others computed.

    `source` is its JSON file in the folder of references, without the ending, `origin` who computed it, `notes` the
    comment of its scene. `columns` says what mbproj records for the source's columns (see `quantities`); `grid` in s
    is what their times have to be multiples of, and of those every `every`-th row is kept. `tolerances` are absolute,
    by quantity; `relative` those of the other quantities, as a part of each column's largest magnitude. `short` in s
    is how far the projection methods are run that are not the default, with the settings `quick`. `loops` are the
    joints that close planar loops of spatial revolutes, whose rows are redundant in space. `moments` in kg m² stand for
    the zero ones of a point mass. `markers` are points of bodies in their axes, by name; without any the last body's
    centre of mass is one.
    """

    name: str
    title: str
    source: str
    origin: str
    notes: str
    columns: Mapping[str, str]
    simulation: Mapping[str, str]
    tolerances: Mapping[str, float]
    relative: Mapping[str, float] = field(default_factory=dict)
    grid: float = 0.01
    every: int = 1
    short: float = 0.5
    quick: Mapping[str, str] = field(default_factory=dict)
    loops: tuple[str, ...] = ()
    moments: float | None = None
    markers: Mapping[str, tuple[str, tuple[float, float, float]]] = field(default_factory=dict)

    @property
    def scene(self) -> Path:
        """Its scene file."""
        return SCENES / f"{self.name}.yaml"

    @property
    def table(self) -> Path:
        """Its reference table: a line on the origin, a header, rows."""
        return TABLES / f"{self.name}.csv"
