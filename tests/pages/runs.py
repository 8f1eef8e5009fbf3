"""Runs to show on pages, and what a page holds of them."""

from __future__ import annotations

import json
import re
import zlib
from base64 import b64decode
from pathlib import Path
from typing import Any

import numpy as np

from mbproj import Scene, read_scene, settings_to_run, simulate
from mbproj.results.writer import ResultsWriter
from tests.support import ROOT, assembled

# Runs of the five-bar to show.

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
#: A scene whose title is markup.
HOSTILE = """\
mbproj: 1
title: "</script><script>alert(1)</script> <!-- & \\u2028 ü"
gravity: [0, 0, -9.8]
simulation: {duration: 0.1, step: 0.01}
bodies: {bob: {mass: 1, inertia: [1, 1, 1], position: [0, 0, -1]}}
joints: {pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}}
"""


def recorded(scene: Scene, path: Path) -> Path:
    """The results of a scene, in a file."""
    system, state = assembled(scene)
    with ResultsWriter(path, scene, system.names.as_mapping()) as writer:
        simulate(system, state, settings_to_run(scene), writer)
    return path


def five_bar(path: Path, **simulation: Any) -> Path:
    """The results of the five-bar with these changes of its settings."""
    return recorded(read_scene(FIVE_BAR, simulation=simulation), path)


# The numbers and texts of a page, read back without the packer's code.


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
