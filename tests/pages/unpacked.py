"""The numbers and texts of a page, read back without the packer's code."""

from __future__ import annotations

import json
import re
import zlib
from base64 import b64decode
from typing import Any

import numpy as np


def data_of(page: str) -> Any:
    """What the page's JSON says."""
    found = re.search(r'<script type="application/json" id="mechanism">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found[1])


def bytes_of(page: str) -> bytes:
    """The page's numbers."""
    found = re.search(r'<script type="text/plain" id="motion">(.*?)</script>', page, re.S)
    assert found
    return zlib.decompress(b64decode(found[1]))


def block_of(packed: bytes, block: dict[str, Any]) -> np.ndarray:
    """A block's numbers (T, c): byte planes to whole numbers, sums of differences, times the steps."""
    rows, columns = block["rows"], block["columns"]
    count = rows * columns
    planes = np.frombuffer(packed, np.uint8, 4 * count, block["at"]).reshape(4, columns, rows).astype(np.uint64)
    unsigned = sum(planes[k] << np.uint64(8 * k) for k in range(4))
    whole = np.where(unsigned & np.uint64(1), -((unsigned >> np.uint64(1)).astype(np.int64)) - 1, unsigned >> 1)
    whole = whole.astype(np.int64)
    for turn in reversed(range(min(block["order"], max(rows - 1, 0)))):
        whole[:, turn:] = np.cumsum(whole[:, turn:], axis=1)
    whole = (whole + 2**31) % 2**32 - 2**31
    values = whole * np.array(block["steps"])[:, None]
    return np.where(whole == -(2**31), np.nan, values).T
