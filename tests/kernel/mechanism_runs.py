"""Runs of the shipped mechanisms in memory, and their bits."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np

from mbproj import Scene
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.motion.report import Report
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from tests.kernel.scenes import assembled
from tests.support import MECHANISMS, Recorder

PATHS = {path.stem: path for path in MECHANISMS}


def run(scene: Scene, **keys) -> tuple[Recorder, Report]:
    projection = ProjectionSettings(**keys.pop("projection", {}))
    recorder = Recorder()
    return recorder, simulate(*assembled(scene), Settings(projection=projection, **keys), recorder)


def mechanism(name: str) -> Scene:
    return read_scene(PATHS[name])


def bits(blocks: list[Mapping[str, np.ndarray]]) -> str:
    digest = hashlib.sha256()
    for path in sorted(blocks[0]):
        digest.update(np.concatenate([block[path] for block in blocks]).tobytes())
    return digest.hexdigest()


def print_bits() -> None:
    """For a process of its own."""
    print(*(bits(run(mechanism(name), duration=0.3, **keys)[0].blocks) for name, keys in REPEATED))


REPEATED = [
    ("five_bar", {"step": 0.01}),
    ("five_bar", {"step": 0.01, "formulation": "reduced"}),
    ("stewart_platform", {"tolerance": 1e-8, "integrator": "dopri5", "output_step": 0.01}),
]
