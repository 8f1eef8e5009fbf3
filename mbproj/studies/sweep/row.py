"""What became of a case: a row of the sweep's table."""

from __future__ import annotations

from enum import Enum

from mbproj.dataclass import dataclass


class Status(str, Enum):
    """How a case ended. What took too long, or lost its process, is run again when the sweep is started again; what
    failed would fail again."""

    DONE = "done"
    FAILED = "failed"
    TIMEOUT = "timeout"
    CRASHED = "crashed"


@dataclass(frozen=True)
class Row:
    """The status of a case, its measures in their order (empty where it is not done), why it failed, when in s and at
    which joint, where that is known; the formulation that ran; how long it took, in s of the clock; whether its results
    file is kept."""

    status: Status
    values: tuple[float, ...] = ()
    message: str = ""
    time: float | None = None
    joint: str = ""
    formulation: str = ""
    seconds: float = 0.0
    kept: bool = False
