"""Numbers as compact bytes: whole multiples of a step, as differences in time, byte by byte, compressed.

A smooth motion has small differences of the second or third order, most bytes of which are zero. Everything is exact
in the multiples: no error adds up. `browser/unpack.js` reads what is written here.
"""

from __future__ import annotations

import zlib
from base64 import b64encode
from dataclasses import field

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass

#: The multiple that stands for what is no number.
NO_NUMBER = -(2**31)
#: Multiples stay below this, so that no number is the mark and differences fit into 32 bits with wrap-around.
LARGEST = 2**30
#: Orders of differences that are tried.
ORDERS = range(4)


@dataclass
class Packer:
    """Collects blocks of numbers; `blocks` describes them for the page, `text` is all their bytes."""

    blocks: list[dict[str, object]] = field(default_factory=list)
    _bytes: list[bytes] = field(default_factory=list)
    _length: int = 0

    def add(self, values: Array, step: float | Array) -> int:
        """Adds values (T, c), each within half a `step` (one, or one a column); the number of the block."""
        steps = np.broadcast_to(np.asarray(step, dtype=float), (values.shape[1],))
        whole = multiples(values, steps)
        order = min(ORDERS, key=lambda order: _cost(_differences(whole, order)))
        data = _planes(_differences(whole, order))
        same = bool((steps == steps[:1]).all())
        self.blocks.append(
            {
                "at": self._length,
                "rows": int(values.shape[0]),
                "columns": int(values.shape[1]),
                "order": order,
                "steps": [float(steps[0])] if same and len(steps) else steps.tolist(),
            }
        )
        self._bytes.append(data)
        self._length += len(data)
        return len(self.blocks) - 1

    def text(self) -> str:
        """All bytes, compressed as zlib does, in base 64."""
        return b64encode(zlib.compress(b"".join(self._bytes), 9)).decode("ascii")


def multiples(values: Array, steps: Array) -> np.ndarray:
    """The nearest multiples (T, c) of the steps, NO_NUMBER for what is not finite or too large."""
    with np.errstate(invalid="ignore", over="ignore"):
        scaled = np.rint(values / steps)
        fits = np.abs(scaled) < LARGEST  # False for what is no number
    return np.where(fits, scaled, NO_NUMBER).astype(np.int64).astype(np.int32)


def step_of(values: Array, digits: int) -> Array:
    """The step (c,) of each column that keeps so many binary digits of its largest number; 1 where all are zero."""
    with np.errstate(invalid="ignore"):
        largest = np.max(np.abs(values), axis=0, where=np.isfinite(values), initial=0.0)
    _, exponent = np.frexp(largest)
    found: Array = np.where(largest > 0.0, np.ldexp(1.0, np.clip(exponent - digits, -1000, 1000)), 1.0)
    return found


def _differences(whole: np.ndarray, order: int) -> np.ndarray:
    """The differences along time, the first rows of each order kept; 32 bits with wrap-around."""
    found = whole.copy()
    for turn in range(min(order, max(len(whole) - 1, 0))):
        found[turn + 1 :] = found[turn + 1 :] - found[turn:-1]
    return found


def _cost(differences: np.ndarray) -> float:
    """About how many bits the differences need."""
    return float(np.log2(1.0 + np.abs(differences.astype(float))).sum())


def _planes(differences: np.ndarray) -> bytes:
    """Column after column, small numbers of either sign as small numbers without one; first all lowest bytes."""
    flat = np.ascontiguousarray(differences.T).ravel()
    unsigned = ((flat << 1) ^ (flat >> 31)).astype("<u4")
    return np.ascontiguousarray(unsigned.view(np.uint8).reshape(-1, 4).T).tobytes()
