"""Where the store is: a private folder in the user's folder for caches."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from platformdirs import user_cache_path


def folder() -> Path:
    """MBPROJ_CACHE, or `mbproj` in the user's folder for caches."""
    given = os.environ.get("MBPROJ_CACHE")
    return Path(given) if given else user_cache_path("mbproj", appauthor=False)


def private_folder() -> Path:
    """The folder `studies` in there, made where it is missing, that nobody else can read or write. Raises OSError where
    it cannot be made, or belongs to somebody else."""
    try:
        parent = folder().expanduser()
    except RuntimeError as error:
        raise FileNotFoundError(f"'{folder()}': the user has no home") from error
    parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    private = parent / "studies"
    private.mkdir(mode=0o700, exist_ok=True)
    found = private.stat()
    if hasattr(os, "getuid") and found.st_uid != os.getuid():
        raise PermissionError(f"'{private}' belongs to another user")
    if stat.S_IMODE(found.st_mode) != 0o700 and os.name == "posix":
        private.chmod(0o700)
    return private
