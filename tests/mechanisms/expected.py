"""Values that the shipped mechanisms expect, and what formulas take of a run without one."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np

from mbproj import Scene, read_scene
from tests.support import ROOT


@cache
def scene(name: str) -> Scene:
    return read_scene(ROOT / "mechanisms" / f"{name}.yaml")


def expected(name: str, entry: str) -> np.ndarray:
    """The value of an expectation (k,)."""
    (found,) = (each for each in scene(name).expectations if each.name == entry)
    assert found.value is not None
    return np.array(found.value)


def bare(name: str) -> SimpleNamespace:
    """What the formulas of other tests take of a run: its scene and parameters."""
    return SimpleNamespace(scene=scene(name), parameters=scene(name).parameters)
