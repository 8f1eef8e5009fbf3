"""One threshold: a number with its unit, its use and its source."""

from __future__ import annotations

from dataclasses import field
from typing import Literal, TypeVar

Number = TypeVar("Number", int, float)
#: Where a threshold is used.
UsedBy = Literal["both", "kernel", "numpy"]


def threshold(value: Number, unit: str, used_by: UsedBy, why: str, source: str) -> Number:
    """A field of a dataclass with this default. `unit`: "1" for a part of something, "-" for a count; `why`: what it
    decides, and on which side the margin is; `source`: where the value comes from."""
    metadata = {"unit": unit, "used_by": used_by, "why": why, "source": source}
    declared: Number = field(default=value, metadata=metadata)
    return declared
