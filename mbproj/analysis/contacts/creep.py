"""How far what is regularised has crept, where dry friction that is exact would have stuck."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from mbproj.errors import InputError
from mbproj.results import Results
from mbproj.scene import read_scene_text
from mbproj.scene.records import JointForce, Scene

#: A scene without this word has nothing that creeps.
KEY = "regularised"


class Crept(TypedDict):
    """The `width` of a smooth friction in rad/s or m/s, as its `unit` has it; for how many s it moved by less than
    that, and how far in that time, in rad or m."""

    unit: str
    width: float
    seconds: float
    creep: float


def crept_by_frictions(results: Results, scene: Scene | None = None) -> dict[str, Crept]:
    """By the names of the frictions that are regularised, over the samples. The scene is read from the results where it
    is not given; where it cannot be, there are none."""
    if KEY not in results.scene_text:
        return {}
    try:
        what = scene or read_scene_text(results.scene_text, str(results.scene_path or results.path), results.overrides)
    except InputError:
        return {}
    found: dict[str, Crept] = {}
    for force in what.forces:
        for coordinate, dry in force.coulomb.items() if isinstance(force, JointForce) else ():
            assert isinstance(force, JointForce)
            name = force.called(coordinate)
            if dry.regularised is not None and name in results.names("forces"):
                found[name] = _crept(results, name, dry.unit, dry.regularised)
    return found


def _crept(results: Results, name: str, unit: str, width: float) -> Crept:
    """From one sample to the next where both are slower."""
    force, time = results.force(name), results.time
    slow = np.abs(force.rate) <= width
    rests = slow[1:] & slow[:-1]
    return Crept(
        unit=unit,
        width=width,
        seconds=float(np.diff(time)[rests].sum()),
        creep=float(np.abs(np.diff(force.coordinate))[rests].sum()),
    )


def in_words(crept: Crept) -> str:
    """One line on a friction."""
    unit = crept["unit"]
    if crept["seconds"] == 0.0:
        return f"never slower than its {crept['width']:.4g} {unit}/s"
    slower = f"slower than its {crept['width']:.4g} {unit}/s"
    return f"crept by {crept['creep']:.4g} {unit} in {crept['seconds']:.4g} s, {slower}"
