"""Sweeps of a small pendulum, as their tests write them."""

from __future__ import annotations

from pathlib import Path

from mbproj.base.errors import InputError
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.run import run_sweep
from mbproj.studies.sweep.spec import read_spec
from mbproj.studies.sweep.summary import entries

#: A pendulum that fails from 0.1 s on where `fails` is 1, and has a mass that nothing else depends on.
SCENE = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {length: 1 m, fails: 0}
simulation: {duration: 0.2, step: 0.01}
bodies:
  bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5 * length, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  f: {type: force, body: bar, force: [sqrt(0.1 + (1 - fails) - t), 0, 0]}
markers:
  end: {body: bar, location: [length, 0, 0]}
title: A pendulum
"""
MEASURE = "  drop: {marker: end, quantity: position, component: z, at: end}\n"


def write(folder: Path, vary: str, measure: str = MEASURE, more: str = "", scene: str = SCENE) -> Path:
    """The scene and folder/spec.yaml."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pendulum.yaml").write_text(scene, encoding="utf-8")
    path = folder / "spec.yaml"
    path.write_text(f"sweep: 1\nscene: pendulum.yaml\nvary:\n{vary}measure:\n{measure}{more}", encoding="utf-8")
    return path


def swept(path: Path, output: Path, fresh: bool = False, **options):
    """How far a sweep came, its entries, and its summary's cells."""
    spec = read_spec(path)
    folder = Folder(output, spec, fresh)
    with folder.store:
        reached = run_sweep(spec, folder, 1, **options)
        return reached, list(entries(spec, folder))


def complaints(path: Path) -> list[str]:
    """What is wrong with a spec: the lines without the file's name."""
    try:
        read_spec(path)
    except InputError as error:
        return [problem.line().removeprefix(f"{path}:") for problem in error.problems]
    return []
