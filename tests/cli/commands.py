"""Runs the command line in a process of its own, as a user does."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

from tests.support import ROOT

FIVE_BAR = str(ROOT / "mechanisms" / "five_bar.yaml")
SLIDER_CRANK = str(ROOT / "mechanisms" / "spatial_slider_crank.yaml")


def mbproj(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """`mbproj ARGUMENTS` in `folder`."""
    program = [sys.executable, "-c", "from mbproj.cli import main; main()"]
    environment = {"PYTHONPATH": str(ROOT), "MBPROJ_CACHE": str(folder / "cache")}
    return subprocess.run(
        [*program, *arguments], capture_output=True, text=True, cwd=folder, check=False, env=environment
    )


def kept(cache: Path) -> list[str]:
    """The names of what studies have kept in this folder for caches."""
    path = cache / "studies" / "store.sqlite3"
    if not path.exists():
        return []
    with closing(sqlite3.connect(path, timeout=30.0)) as database:
        try:
            return [name for (name,) in database.execute("SELECT item FROM kept ORDER BY item")]
        except sqlite3.OperationalError:  # its tables are still to be made
            return []
