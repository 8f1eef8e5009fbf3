"""A case of a sweep: its key, a hash of all data that determine its numbers; its result, a row of the table; and the
stored form of this row."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from enum import Enum
from math import isnan
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.kernel import build_info
from mbproj.plugins import marks
from mbproj.scene.ranges import Item
from mbproj.scene.records import Expectation
from mbproj.version import __version__

#: The bytes of a key: two of 1e9 cases do not agree by chance.
SIZE = 16


class Status(str, Enum):
    """The end of a case. A restarted sweep runs cases again that took too long, or lost their process, memory or disk
    space. Failed cases would fail again."""

    DONE = "done"
    FAILED = "failed"
    TIMEOUT = "timeout"
    CRASHED = "crashed"


@dataclass(frozen=True)
class CaseRow:
    """The result of a case: its status, and its measures in their order, empty for a case that is not done. For a
    failure: `message`, `time` in s and `joint`, where known. `seconds` is the duration by the clock, `kept` whether the
    results file is kept. `by_arrays` tells whether the case ran in arrays, and is not stored."""

    status: Status
    values: tuple[float, ...] = ()
    message: str = ""
    time: float | None = None
    joint: str = ""
    formulation: str = ""
    seconds: float = 0.0
    kept: bool = False
    by_arrays: bool = False


#: The columns of a stored case, with the types that SQLite may return.
_KINDS: Mapping[str, tuple[type, ...]] = {
    "key": (str,),
    "parameters": (str,),
    "status": (str,),
    "measures": (str,),
    "message": (str,),
    "time": (float, type(None)),
    "joint": (str,),
    "formulation": (str,),
    "seconds": (float,),
    "kept": (int,),
}


def as_stored(key: str, parameters: Mapping[str, Any], names: Sequence[str], row: CaseRow) -> list[Any]:
    """The columns of a case, whose measures have these names in the store."""
    values = {name: None if isnan(value) else value for name, value in zip(names, row.values, strict=False)}
    time = None if row.time is None or isnan(row.time) else float(row.time)
    texts = [key, json.dumps(dict(parameters)), row.status.value, json.dumps(values)]
    return [*texts, row.message, time, row.joint, row.formulation, float(row.seconds), int(row.kept)]


def from_stored(columns: Sequence[Any]) -> tuple[dict[str, float | None], CaseRow]:
    """The measures of a stored case by their names, and its row without them. Raises ValueError for columns that
    `as_stored` has not made."""
    kinds = _KINDS.values()
    if len(columns) != len(kinds) or not all(map(isinstance, columns, kinds)):
        raise ValueError("a column has another type")
    _, parameters, status, measures, message, time, joint, formulation, seconds, kept = columns
    values = json.loads(measures)
    numbers = values.values() if isinstance(values, dict) else [""]
    if not isinstance(json.loads(parameters), dict) or not all(isinstance(each, float | None) for each in numbers):
        raise ValueError("parameters or measures are not what they should be")
    return values, CaseRow(Status(status), (), message, time, joint, formulation, seconds, bool(kept))


class Keys:
    """The keys of cases of a scene's text in which these paths vary; mbproj's version and build are part of them."""

    def __init__(self, text: str, paths: Sequence[str]) -> None:
        common = json.dumps([__version__, build_info(), text, *marks()])
        self._common = hashlib.blake2b(common.encode(), digest_size=SIZE)
        self._paths = tuple(paths)

    def of(self, values: Sequence[Item]) -> str:
        """The key of the case with these values, in hexadecimal digits; it does not depend on the order of the
        paths."""
        digest = self._common.copy()
        digest.update(json.dumps(sorted(zip(self._paths, values, strict=True))).encode())
        return digest.hexdigest()


def identity(measure: Expectation) -> str:
    """The identity of a measure, which does not depend on its name: its object, quantity, component and time."""
    further = [measure.over, *measure.between] if measure.over or measure.between else []
    return json.dumps([measure.of, measure.item, measure.quantity, measure.component, measure.at, *further])
