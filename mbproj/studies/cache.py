"""What took long to compute, kept on disk: arrays by the hash of all that they follow from."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

from mbproj.arrays import Array
from mbproj.kernel import build_info
from mbproj.version import __version__


def folder() -> Path:
    """Where it is kept: MBPROJ_CACHE, or `mbproj` in the user's folder for caches."""
    if "MBPROJ_CACHE" in os.environ:
        return Path(os.environ["MBPROJ_CACHE"])
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mbproj"


def cached(what: Any, compute: Callable[[], dict[str, Array]]) -> dict[str, Array]:
    """The arrays that `compute` gives for `what` (anything JSON can hold), from the disk where they are there.

    Version and build of mbproj count as part of `what`. A folder that cannot be written only costs the time.
    """
    key = hashlib.sha256(json.dumps([__version__, build_info(), what]).encode()).hexdigest()
    path = folder() / f"{key}.npz"
    try:
        with np.load(path) as kept:
            return dict(kept)
    except (OSError, ValueError):
        arrays = compute()
    draft = path.with_name(f"{uuid4().hex}.npz")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(draft, **arrays)  # type: ignore[arg-type]
        draft.replace(path)
    except OSError:
        draft.unlink(missing_ok=True)
    return arrays
