"""The results files that are changed, and whether a changed one still has their numbers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from mbproj.base.errors import InputError
from mbproj.results.layout import DATASETS
from mbproj.results.reader import open_results
from mbproj.results.record import Results

from .watched import PROGRAM, ROOT

SCENE = """mbproj: 1
title: A pendulum
gravity: [0, 0, -9.81]
parameters: {length: 0.5 m}
simulation: {duration: 0.2 s, step: 10 ms}
bodies:
  bar: {mass: 1 kg, inertia: [0.01, 0.02, 0.02], position: [length, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  spring: {type: torsion_spring_damper, joint: pin, stiffness: 1, damping: 0.1}
markers:
  end: {body: bar, location: [2*length, 0, 0]}
"""
#: Waits after some samples, so that it can be killed.
KILLED = """
import sys, time
from mbproj.cli import main
from mbproj.results import ResultsWriter
write = ResultsWriter._flush
def wait(self):
    write(self)
    if self._samples:
        print("go", flush=True)
        time.sleep(600)
ResultsWriter._flush = wait
sys.argv[1:] = ["run", "scene.yaml", "--duration", "1", "-o", "killed.h5", "--quiet"]
main()
"""


@dataclass(frozen=True)
class Originals:
    """Results files in a folder, with the scene that was run."""

    folder: Path
    paths: tuple[Path, ...]

    @classmethod
    def made_in(cls, folder: Path) -> Originals:
        """A finished run, a certified and verified one, and what is left of one that was killed."""
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
        _mbproj(folder, "run", "scene.yaml", "-o", "whole.h5", "--quiet", "--set", "length=0.5")
        _mbproj(folder, "run", "scene.yaml", "-o", "certified.h5", "--quiet", "--certify")
        _mbproj(folder, "verify", "scene.yaml", "--store", "certified.h5")
        _killed(folder)
        return cls(folder, tuple(folder / name for name in ("whole.h5", "certified.h5", "killed.h5.part")))

    def furnish(self, work: Path) -> None:
        """A folder with what commands need beside the changed file: a scene, a sound file, a pipe."""
        work.mkdir(parents=True)
        shutil.copyfile(self.folder / "scene.yaml", work / "scene.yaml")
        shutil.copyfile(self.folder / "whole.h5", work / "whole.h5")
        os.mkfifo(work / "pipe")


def same_numbers(original: Path, changed: Path) -> bool:
    """Whether a file that passes its check has the samples, names, settings and status of the original."""
    try:
        with open_results(original) as one, open_results(changed) as other:
            return _all(one) == _all(other)
    except InputError:
        return False


def _all(results: Results) -> list[object]:
    series: list[object] = [results[dataset.path].tobytes() for dataset in DATASETS]
    attributes = dict(results.attributes)
    return [*series, results.settings, results.overrides, results.scene_text, results.names("joints"), attributes]


def _mbproj(folder: Path, *arguments: str) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MBPROJ_CACHE": str(folder / "cache")}
    subprocess.run(
        [sys.executable, "-c", PROGRAM, *arguments], cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL
    )


def _killed(folder: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MBPROJ_CACHE": str(folder / "cache")}
    process = subprocess.Popen([sys.executable, "-c", KILLED], cwd=folder, env=environment, stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    process.kill()
    process.wait()
