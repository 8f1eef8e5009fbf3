"""A record that tests of the store keep."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, eq=False)
class Drawn:
    """A record of the tests."""

    name: str
    values: Any
    inner: Any = None
