"""What took long to compute, kept on disk by the hash of all that it follows from."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
from collections.abc import Callable
from pathlib import Path
from tempfile import gettempdir
from typing import Any, TypeVar
from uuid import uuid4

from mbproj.errors import InputError
from mbproj.kernel import build_info
from mbproj.studies.journal import Journal
from mbproj.version import __version__

Value = TypeVar("Value")


def folder() -> Path:
    """Where it is kept: MBPROJ_CACHE, or `mbproj` in the user's folder for caches."""
    if "MBPROJ_CACHE" in os.environ:
        return Path(os.environ["MBPROJ_CACHE"])
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # a user without a home
        home = Path(gettempdir())
    return home / "mbproj"


def cached(what: Any, compute: Callable[[], Value]) -> Value:
    """The value that `compute` gives for `what` (anything JSON can hold), from the disk where it is there.

    Version and build of mbproj count as part of `what`. A folder that cannot be written only costs the time.
    """
    path = _place(what, "pickle")
    try:
        kept: Value = pickle.loads(path.read_bytes())
    except Exception:  # nothing is there, or it was cut short: what pickle raises then can be anything
        value = compute()
    else:
        return kept
    draft = path.with_name(f"{uuid4().hex}.pickle")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft.write_bytes(pickle.dumps(value))
        draft.replace(path)
    except OSError:
        draft.unlink(missing_ok=True)
    return value


def journal_of(what: Any) -> Journal:
    """The journal of `what` (as of `cached`) in the same folder; in memory where that cannot be written."""
    path = _place(what, "jsonl")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return Journal(path, {"key": path.stem})
    except (OSError, InputError):
        return Journal(None, {})


def _place(what: Any, ending: str) -> Path:
    key = hashlib.sha256(json.dumps([__version__, build_info(), what]).encode()).hexdigest()
    return folder() / f"{key}.{ending}"
