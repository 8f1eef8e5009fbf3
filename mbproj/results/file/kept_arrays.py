"""The arrays of a results file that stay in memory: those asked for last, as far as they are not large together."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, final

import numpy.typing as npt

Values: TypeAlias = npt.NDArray[Any]
#: What they take together at most, bytes; one alone may take more.
KEPT_BYTES = 2**25


@final
class KeptArrays:
    """By path; times are always kept."""

    def __init__(self) -> None:
        self._arrays: dict[str, Values] = {}

    def get(self, path: str, read: Callable[[], Values]) -> Values:
        """The array of a path, read where it is not here. Those that were not asked for longest may go."""
        found = self._arrays.pop(path, None)
        self._arrays[path] = found = read() if found is None else found
        size = sum(values.nbytes for values in self._arrays.values())
        for other in [other for other in list(self._arrays)[:-1] if other != "time"]:
            if size > KEPT_BYTES:
                size -= self._arrays.pop(other).nbytes
        return found
