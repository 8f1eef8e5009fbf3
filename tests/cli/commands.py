"""Runs the command line in a process of its own, as a user does."""

from __future__ import annotations

import subprocess
import sys
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
