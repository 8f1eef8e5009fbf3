"""A cache of the arrays of a results file: the most recently used stay in memory, up to a size."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, final

import numpy.typing as npt

Values: TypeAlias = npt.NDArray[Any]
#: The most bytes of all arrays together; one alone may take more.
KEPT_BYTES = 2**25


@final
class KeptArrays:
    """The arrays by path, those used last at the end; the times always stay."""

    def __init__(self) -> None:
        self._arrays: dict[str, Values] = {}

    def get(self, path: str, read: Callable[[], Values]) -> Values:
        """The array of a path, which is read where it is not here. Those that were not used for longest may be
        dropped."""
        array = self._arrays.pop(path, None)
        self._arrays[path] = array = read() if array is None else array
        size = sum(values.nbytes for values in self._arrays.values())
        for other in [other for other in list(self._arrays)[:-1] if other != "time"]:
            if size > KEPT_BYTES:
                size -= self._arrays.pop(other).nbytes
        return array
