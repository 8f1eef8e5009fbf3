"""json_text(): the JSON text that a command prints with --json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any


def json_text(contents: Any, indent: int | None = None) -> str:
    """Convert `contents` to JSON. NumPy's arrays become lists and paths become text; NaN and infinity, which JSON
    lacks, become null."""
    return json.dumps(_plain(contents), indent=indent, ensure_ascii=False, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not isfinite(value) else value
