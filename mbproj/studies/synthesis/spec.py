"""The file of a synthesis, and the wanted points, angles or positions that it names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.scene.fields.fields import NameChoice, OneOf, Record, Text
from mbproj.scene.fields.quantities import Integer
from mbproj.scene.fields.reading import Reading, in_text_order
from mbproj.scene.ranges import read_mapping
from mbproj.studies.inverse.given_motion import CsvTable, read_columns
from mbproj.studies.synthesis.linkage import FUNCTION, PATH, POSITIONS

#: The columns of each kind, with their units. A path has times where its timing is given.
COLUMNS: Mapping[str, tuple[tuple[str, str], ...]] = {
    PATH: (("x", "m"), ("z", "m")),
    FUNCTION: (("input", "rad"), ("output", "rad")),
    POSITIONS: (("x", "m"), ("z", "m"), ("angle", "rad")),
}
TIME = ("time", "s")
GIVEN, FREE = "given", "free"
#: A path is closed where its ends are at most this many of its longest steps apart.
CLOSED = 2.0
FEWEST, MOST_POSITIONS = {PATH: 3, FUNCTION: 3, POSITIONS: 3}, 5
_WANTED: Record[dict[str, Any]] = Record(
    "what is wanted",
    {PATH: Text(), FUNCTION: Text(), POSITIONS: Text(), "timing": NameChoice("timing", lambda: (GIVEN, FREE))},
    dict,
    choices=(OneOf((PATH, FUNCTION, POSITIONS), needed=True, hint="one at a time; write another file for the other"),),
)
SYNTHESIS: Record[dict[str, Any]] = Record(
    "a synthesis",
    {
        "design": NameChoice("format version", lambda: ("1",)),
        "synthesis": _WANTED,
        "starts": Integer(1),
        "seed": Integer(0),
    },
    dict,
    required=("design", "synthesis"),
)
#: The default number of designs that are optimised for each assembly of a topology, and the default seed.
STARTS, SEED = 40, 0


@dataclass(frozen=True, eq=False)
class Wanted:
    """The task, from a table of N rows. `values` are points x, z of a path (N, 2), at `times` (N,), or input and output
    angles (N, 2), or positions x, z, angle (N, 3). `turns`: the path is closed, and the crank turns once. Without times
    the timing is free."""

    path: Path
    text: str
    kind: str
    values: Array
    times: Array | None
    turns: bool
    starts: int
    seed: int

    @property
    def centre(self) -> complex:
        """The centre of the points, x + iz; 0 for a function."""
        if self.kind == FUNCTION:
            return 0.0
        middle = 0.5 * (self.values.min(axis=0) + self.values.max(axis=0))
        return complex(middle[0], middle[1])

    @property
    def size(self) -> float:
        """The extent of the points in m; 1 m for a function."""
        return 1.0 if self.kind == FUNCTION else float(np.ptp(self.values[:, :2], axis=0).max())


def is_synthesis(path: Path) -> bool:
    """Whether the file asks for a synthesis."""
    return "synthesis" in read_mapping(path, SYNTHESIS.what, "it begins with 'design: 1'")[1].values


def read_wanted(path: Path) -> Wanted:
    """The task in the file at `path`. Raises InputError with all problems, each at its place in the file or in its
    table."""
    text, root, reading = read_mapping(path, SYNTHESIS.what, "it begins with 'design: 1'")
    if "synthesis" not in root.values:
        hint = "add synthesis: {path: FILE.csv}, or leave out --topologies"
        raise InputError(Problem("the file has no 'synthesis', which --topologies is for", root.place, hint))
    blocks = SYNTHESIS.read(root, (), reading)
    if blocks is None or reading.problems:
        raise InputError(in_text_order(reading.problems))
    wanted = blocks["synthesis"]
    kind = next(each for each in COLUMNS if each in wanted)
    if "timing" in wanted and kind != PATH:
        place = reading.places[("synthesis", "timing")]
        raise InputError(Problem(f"'timing' is of a path, not of {kind}", place, "leave it out"))
    table = read_columns(path.parent / wanted[kind], f"synthesis.{kind}")
    values = _values(table, COLUMNS[kind], path.parent / wanted[kind])
    times = _times(table, wanted, path.parent / wanted[kind], reading) if kind == PATH else None
    _check(kind, values, times, path.parent / wanted[kind])
    return Wanted(
        path=path,
        text=text,
        kind=kind,
        values=values,
        times=None if times is None else times - times[0],
        turns=kind == PATH and _is_closed(values),
        starts=blocks.get("starts", STARTS),
        seed=blocks.get("seed", SEED),
    )


def _values(table: CsvTable, wanted: tuple[tuple[str, str], ...], file: Path) -> Array:
    names = [name.removeprefix("position_") for name, _ in table.headings]
    columns, place = [], Place(str(file), table.heading_line)
    for name, unit in wanted:
        if name not in names:
            known = ", ".join(f"'{each}'" for each, _ in table.headings)
            hint = choose_from(name, names) or f"headings are {known}"
            raise InputError(Problem(f"there is no column '{name}'", place, hint))
        columns.append(table.column(names.index(name), unit, place))
    return np.stack(columns, axis=1)


def _times(table: CsvTable, wanted: Mapping[str, Any], file: Path, reading: Reading) -> Array | None:
    names = [name for name, _ in table.headings]
    timing = wanted.get("timing", GIVEN if TIME[0] in names else FREE)
    if timing == FREE:
        return None
    if TIME[0] not in names:
        place = reading.places[("synthesis", "timing")]
        raise InputError(Problem(f"'{file.name}' has no column 'time'", place, "add one, or say  timing: free"))
    return _values(table, (TIME,), file)[:, 0]


def _check(kind: str, values: Array, times: Array | None, file: Path) -> None:
    place = Place(str(file))
    if len(values) < FEWEST[kind]:
        raise InputError(Problem(f"it has {len(values)} rows, and a {kind} needs {FEWEST[kind]}", place, "give more"))
    if kind == POSITIONS and len(values) > MOST_POSITIONS:
        message = f"it has {len(values)} positions, and mechanisms are sought for {MOST_POSITIONS} at most"
        raise InputError(Problem(message, place, "leave some out"))
    if kind != FUNCTION and not np.ptp(values[:, :2], axis=0).max() > 0.0:
        raise InputError(Problem("all its points are one", place, "give points that are apart"))
    monotonic = times if times is not None else values[:, 0] if kind == FUNCTION else None
    if monotonic is not None and not (np.diff(monotonic) > 0.0).all():
        what = "times" if times is not None else "inputs"
        raise InputError(Problem(f"its {what} do not grow from row to row", place, "sort the rows"))


def _is_closed(points: Array) -> bool:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return len(points) > 3 and float(np.linalg.norm(points[-1] - points[0])) <= CLOSED * float(steps.max())
