"""A scene as `mbproj run` runs it, in a process of its own: it may crash or not end, and the campaign goes on."""

from __future__ import annotations

import multiprocessing
import os
import pkgutil
import resource
import signal
import sys
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory

import h5py
import numpy as np

from mbproj.base.arrays import Array

from .scene import Watched

#: What a run says where it doubts its motion, as attributes of its results.
DOUBTS = ("decided_by_shares", "stiffness", "passed_over", "halved")
#: What a note says that doubts the motion, or the steps.
MOTION = ("the motion may be wrong", "fixed steps do not resolve")
#: What a run imports.
PACKAGES = (
    "mbproj.commands.report",
    "mbproj.commands",
    "mbproj.equations",
    "mbproj.functions",
    "mbproj.motion",
    "mbproj.model",
    "mbproj.results",
    "mbproj.scene",
)
#: Exit codes of a process that had no more time.
OUT_OF_TIME = (-signal.SIGKILL, -signal.SIGXCPU)
#: The groups of which checks take columns, with the datasets.
COLUMNS = {
    "stops": ("gap", "rate", "force"),
    "friction": ("rate", "force", "state", "dissipation"),
    "motions": ("force",),
}


@dataclass
class Outcome:
    """How a run ended, what it said, and what it recorded: `columns` by "dataset:name", as (T,) or (T, 3)."""

    said: str
    ended: str = "at the end"
    doubts: list[str] = field(default_factory=list)
    columns: dict[str, Array] = field(default_factory=dict)
    energy: dict[str, Array] = field(default_factory=dict)

    def along(self, watched: Watched) -> Array:
        """(T,) what is watched."""
        found = self.columns[f"{watched.dataset}:{watched.item}"]
        return found @ np.array(watched.direction) if watched.direction else found


@cache
def _preload() -> None:
    """Imports what runs import, once for all processes: half of the time of a short run."""
    for package in PACKAGES:
        found = import_module(package)
        for module in pkgutil.walk_packages(found.__path__, f"{package}."):
            import_module(module.name)


def run(text: str, seconds: float) -> Outcome:
    """Runs a scene; one that takes longer is killed."""
    _preload()
    with TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.yaml"
        scene.write_text(text, encoding="utf-8")
        process = multiprocessing.get_context("fork").Process(target=_run, args=(scene, seconds))
        process.start()
        process.join(10.0 * seconds)
        if process.is_alive():
            process.kill()
            process.join()
        code = process.exitcode or 0
        said = scene.with_suffix(".txt").read_text(encoding="utf-8", errors="replace").strip()
        outcome = Outcome(said.splitlines()[-1] if said else "")
        outcome.doubts = [
            line for line in said.splitlines() if line.startswith("note:") and any(word in line for word in MOTION)
        ]
        if code:
            outcome.ended = "not in time" if code in OUT_OF_TIME else f"signal {-code}" if code < 0 else f"exit {code}"
        if scene.with_suffix(".h5").exists():
            _read(scene.with_suffix(".h5"), outcome)
        return outcome


def _run(scene: Path, seconds: float) -> None:
    """In the process of the run, which has no end but this; the processor's time is bounded, not that of a clock."""
    from mbproj.commands.main import main

    resource.setrlimit(resource.RLIMIT_CPU, (ceil(seconds), ceil(seconds) + 1))
    said = os.open(scene.with_suffix(".txt"), os.O_WRONLY | os.O_CREAT)
    for stream in (1, 2):
        os.dup2(said, stream)
    sys.stdout, sys.stderr = (os.fdopen(os.dup(said), "w", encoding="utf-8") for _ in range(2))
    sys.argv = ["mbproj", "run", str(scene), "-o", str(scene.with_suffix(".h5"))]
    code: object = 1
    try:
        main()
        code = 0
    except SystemExit as left:
        code = left.code or 0
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(int(code) if isinstance(code, int) else 1)


def _read(path: Path, outcome: Outcome) -> None:
    with h5py.File(path) as file:
        outcome.doubts += [f"{name}: {file.attrs[name]}" for name in DOUBTS if file.attrs.get(name)]
        groups = COLUMNS | {"bodies": ("position", "velocity", "angular_velocity")}
        for group, datasets in groups.items():
            if group in file:
                names = [name.decode() for name in file[group]["names"][...]]
                for dataset in datasets:
                    values = file[group][dataset][...]
                    outcome.columns |= {f"{group}/{dataset}:{name}": values[:, k] for k, name in enumerate(names)}
        if "joints" in file:
            names = [name.decode() for name in file["joints/coordinate_names"][...]]
            angles = file["joints/coordinate"][...]
            outcome.columns |= {f"joints/coordinate:{name}": angles[:, k] for k, name in enumerate(names)}
        for name in ("kinetic_energy", "energy_balance", "dissipation", "work", "potential_energy"):
            outcome.energy[name] = file["diagnostics"][name][...]
        outcome.columns["time"] = file["time"][...]
