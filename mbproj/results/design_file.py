"""`design.json` in the folder of a design: the data of its pictures, so that they can be drawn again."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem

FILE = "design.json"
FORMAT = "mbproj design 1"
#: The most bytes of a file that is read.
LARGEST = 200_000_000
AGAIN = "write it again with: mbproj fit SPEC, or mbproj optimise SPEC"


@dataclass(frozen=True, eq=False)
class Matched:
    """The data of one match: the curves `given` and `reached` (N, k) over `abscissa` (N,), or in a plane where that is
    None."""

    name: str
    abscissa: Array | None
    along: str
    unit: str
    components: tuple[str, ...]
    given: Array
    reached: Array


@dataclass(frozen=True, eq=False)
class Drawn:
    """The data of a design's pictures; a part that the design does not have is empty. `matches`; the `traces` (n, 2) of
    searches: runs and `value`; the `correlation` (d, d) of `names`; the `front` (n, g) of several `goals`, whose first
    row is the design chosen."""

    remark: str
    value: str
    names: tuple[str, ...]
    matches: tuple[Matched, ...] = ()
    traces: tuple[Array, ...] = ()
    correlation: Array | None = None
    goals: tuple[str, ...] = ()
    front: Array | None = None

    def text(self) -> str:
        """The text of the file."""
        return json.dumps({"format": FORMAT, **asdict(self)}, default=lambda array: array.tolist()) + "\n"


def read_drawn(folder: Path) -> Drawn:
    """Read `design.json` in the folder of a design. Raises InputError where it does not exist or is damaged."""
    path = folder / FILE
    try:
        if path.stat().st_size > LARGEST:
            raise ValueError
        contents = json.loads(path.read_text(encoding="utf-8"))
        if contents.pop("format") != FORMAT:
            raise ValueError
        return _read_record(contents)
    except OSError as error:
        raise InputError(Problem(f"cannot read it: {error.strerror}", Place(str(path)), AGAIN)) from error
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        message = "it is not what mbproj wrote of a design"
        raise InputError(Problem(message, Place(str(path)), AGAIN)) from error


def _read_record(contents: dict[str, Any]) -> Drawn:
    """The record, with every shape checked. Raises ValueError, TypeError or KeyError where the data are wrong."""
    matches = tuple(_matched(each) for each in contents["matches"])
    names, goals = tuple(map(str, contents["names"])), tuple(map(str, contents["goals"]))
    return Drawn(
        remark=str(contents["remark"]),
        value=str(contents["value"]),
        names=names,
        matches=matches,
        traces=tuple(_array(each, (len(each), 2)) for each in contents["traces"]),
        correlation=_optional(contents["correlation"], (len(names), len(names))),
        goals=goals,
        front=None if contents["front"] is None else _array(contents["front"], (len(contents["front"]), len(goals))),
    )


def _matched(contents: dict[str, Any]) -> Matched:
    components = tuple(map(str, contents["components"]))
    size = len(contents["given"]), len(components)
    given, reached = _array(contents["given"], size), _array(contents["reached"], size)
    abscissa = _optional(contents["abscissa"], size[:1])
    return Matched(
        str(contents["name"]), abscissa, str(contents["along"]), str(contents["unit"]), components, given, reached
    )


def _optional(values: Any, shape: tuple[int, ...]) -> Array | None:
    return None if values is None else _array(values, shape)


def _array(values: Any, shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=float)
    return array.reshape(shape) if array.size == 0 else _of_shape(array, shape)


def _of_shape(array: Array, shape: tuple[int, ...]) -> Array:
    if array.shape != shape:
        raise ValueError
    return array
