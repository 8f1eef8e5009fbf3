"""The array types that signatures name; shapes stand in the docstrings."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
Integers: TypeAlias = npt.NDArray[np.intp]
#: Real in a run; complex where a test differentiates by the complex step.
Numbers: TypeAlias = npt.NDArray[Any]
