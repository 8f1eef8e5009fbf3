"""Numbers as compact bytes: integer multiples of a step, stored as differences in time, byte by byte, compressed.

A smooth motion has small differences of second or third order, whose bytes are mostly zero. The integers are stored
exactly, so no error adds up. `browser/unpack.js` reads the bytes.
"""

from __future__ import annotations

import zlib
from base64 import b64encode
from dataclasses import field

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass

#: The integer that stands for NaN and infinity.
NO_NUMBER = -(2**31)
#: The bound on all integers, so that none equals NO_NUMBER, and differences fit into 32 bits with wrap-around.
LARGEST = 2**30
#: The orders of differences that are tried.
ORDERS = range(4)


@dataclass
class Packer:
    """A collector of blocks of numbers. `blocks` describes them for the page; `text` is all their bytes."""

    blocks: list[dict[str, object]] = field(default_factory=list)
    _bytes: list[bytes] = field(default_factory=list)
    _length: int = 0

    def add(self, values: Array, step: float | Array) -> int:
        """Add values (T, c), each rounded to a multiple of `step` (one for all, or one for each column). Return the
        number of the block."""
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
        """All bytes, compressed by zlib, in base 64."""
        return b64encode(zlib.compress(b"".join(self._bytes), 9)).decode("ascii")


def multiples(values: Array, steps: Array) -> np.ndarray:
    """The nearest multiples (T, c) of the steps; NO_NUMBER where a value is not finite or too large."""
    with np.errstate(invalid="ignore", over="ignore"):
        scaled = np.rint(values / steps)
        fits = np.abs(scaled) < LARGEST  # False for NaN
    return np.where(fits, scaled, NO_NUMBER).astype(np.int64).astype(np.int32)


def step_of(values: Array, digits: int) -> Array:
    """The step (c,) with which each column keeps `digits` binary digits of its largest number; 1 where all are zero."""
    with np.errstate(invalid="ignore"):
        largest = np.max(np.abs(values), axis=0, where=np.isfinite(values), initial=0.0)
    _, exponent = np.frexp(largest)
    steps: Array = np.where(largest > 0.0, np.ldexp(1.0, np.clip(exponent - digits, -1000, 1000)), 1.0)
    return steps


def _differences(whole: np.ndarray, order: int) -> np.ndarray:
    """The differences of an order along time, in 32 bits with wrap-around. The first rows stay, so that they can be
    summed again."""
    differences = whole.copy()
    for turn in range(min(order, max(len(whole) - 1, 0))):
        differences[turn + 1 :] = differences[turn + 1 :] - differences[turn:-1]
    return differences


def _cost(differences: np.ndarray) -> float:
    """About the number of bits that the differences need."""
    return float(np.log2(1.0 + np.abs(differences.astype(float))).sum())


def _planes(differences: np.ndarray) -> bytes:
    """The bytes of the differences, column after column: first all lowest bytes. A sign bit at the low end keeps small
    numbers of both signs small."""
    flat = np.ascontiguousarray(differences.T).ravel()
    unsigned = ((flat << 1) ^ (flat >> 31)).astype("<u4")
    return np.ascontiguousarray(unsigned.view(np.uint8).reshape(-1, 4).T).tobytes()
