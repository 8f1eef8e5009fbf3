"""Builds a wheel that runs on other machines, installs it into a fresh environment, and runs a mechanism with it there.

    python scripts/test_wheel.py

One compiler at a time, as on a machine with little memory. Needs pip, a C++ compiler and PyPI. Says what the build took
(time, processor time, memory of the largest process) and how large the wheel is; ends with an error where one of the
steps fails, or where the installed mbproj has no kernel.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).parents[1]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        wheel = built(Path(folder))
        installed(wheel, Path(folder) / "environment")


def built(folder: Path) -> Path:
    """The wheel, compiled for every processor of this family."""
    environment = dict(os.environ, MBPROJ_KERNEL="1", MBPROJ_PORTABLE="1", CMAKE_BUILD_PARALLEL_LEVEL="1")
    start = perf_counter()
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(folder), str(ROOT)]
    subprocess.run(command, env=environment, check=True)
    (wheel,) = folder.glob("*.whl")
    took = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(
        f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB, built in {perf_counter() - start:.0f} s: "
        f"{took.ru_utime + took.ru_stime:.0f} s of processor time, at most {took.ru_maxrss / 1024:.0f} MB a process",
        flush=True,
    )
    return wheel


def installed(wheel: Path, environment: Path) -> None:
    """Installs it where nothing else is, and runs what comes with it, outside of the checkout."""
    venv.create(environment, with_pip=True)
    folder = environment / ("Scripts" if os.name == "nt" else "bin")
    steps: list[list[str | Path]] = [
        [folder / "pip", "install", "--quiet", wheel],
        [folder / "mbproj", "info", "--build"],
        [folder / "mbproj", "examples", "--copy", "mechanisms"],
        [folder / "mbproj", "run", "mechanisms/five_bar.yaml", "--formulation", "planar"],
    ]
    for step in steps:
        subprocess.run(step, cwd=environment, check=True)


if __name__ == "__main__":
    main()
