"""A scene with its bodies, joints, markers, forces and motions in another order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from mbproj.scene.records import Scene

Item = TypeVar("Item")


def renumbered(scene: Scene, seed: int = 0) -> Scene:
    """The same scene with its parts in a random order."""
    random = np.random.default_rng(seed)

    def shuffled(items: Sequence[Item]) -> tuple[Item, ...]:
        return tuple(items[number] for number in random.permutation(len(items)))

    return replace(
        scene,
        bodies=shuffled(scene.bodies),
        joints=shuffled(scene.joints),
        markers=shuffled(scene.markers),
        forces=shuffled(scene.forces),
        motions=shuffled(scene.motions),
    )
