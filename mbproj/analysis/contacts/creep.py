"""The creep of regularised dry friction, which moves slowly where exact friction would stick."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from mbproj.errors import InputError
from mbproj.results import Results
from mbproj.scene import read_scene_text
from mbproj.scene.read import Scene
from mbproj.scene.records import JointForce

#: The key of regularised friction: a scene text without it has none.
KEY = "regularised"


class CreepHistory(TypedDict):
    """The creep of a regularised friction. `width` is the rate up to which it is smoothed, rad/s or m/s by its `unit`.
    `seconds` is the time with a smaller rate, `creep` the distance moved in that time, rad or m."""

    unit: str
    width: float
    seconds: float
    creep: float


def creep_by_friction(results: Results, scene: Scene | None = None) -> dict[str, CreepHistory]:
    """The creep of each regularised friction by its name, from the samples. The scene is read from the results where it
    is not given. The answer is empty where it cannot be read."""
    if KEY not in results.scene_text:
        return {}
    try:
        what = scene or read_scene_text(results.scene_text, str(results.scene_path or results.path), results.overrides)
    except InputError:
        return {}
    histories: dict[str, CreepHistory] = {}
    for force in what.forces:
        for coordinate, dry in force.coulomb.items() if isinstance(force, JointForce) else ():
            assert isinstance(force, JointForce)
            name = force.called(coordinate)
            if dry.regularised is not None and name in results.names("forces"):
                histories[name] = _crept(results, name, dry.unit, dry.regularised)
    return histories


def _crept(results: Results, name: str, unit: str, width: float) -> CreepHistory:
    """The creep of a friction, over intervals at whose ends its rate is below `width`."""
    force, time = results.force(name), results.time
    slow = np.abs(force.rate) <= width
    rests = slow[1:] & slow[:-1]
    return CreepHistory(
        unit=unit,
        width=width,
        seconds=float(np.diff(time)[rests].sum()),
        creep=float(np.abs(np.diff(force.coordinate))[rests].sum()),
    )


def in_words(record: CreepHistory) -> str:
    """A line on the creep of a friction."""
    unit = record["unit"]
    if record["seconds"] == 0.0:
        return f"never slower than its {record['width']:.4g} {unit}/s"
    slower = f"slower than its {record['width']:.4g} {unit}/s"
    return f"crept by {record['creep']:.4g} {unit} in {record['seconds']:.4g} s, {slower}"
