"""Ropes that pushed in a run. In a model a rope of constant length can push; a real rope goes slack."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from mbproj.results import Results
from mbproj.scene.read import Scene
from mbproj.thresholds import THRESHOLDS


class Pushed(TypedDict):
    """The largest push of a rope, in N, and its time, in s."""

    push: float
    time: float


def pushed_by_ropes(results: Results, scene: Scene) -> dict[str, Pushed]:
    """The largest push of each rope that pushes at a sample, by its name. A rope with limits is left out, because its
    limits may push."""
    pushed: dict[str, Pushed] = {}
    names = results.names("tensions")
    for joint in scene.joints:
        columns = [k for k, name in enumerate(names) if name.rpartition(".")[0] == joint.name]
        if not columns or joint.limits or not len(results.time):
            continue
        tension = results["ropes/tension"][:, columns]
        least = tension.min(axis=1)
        at = int(np.argmin(least))
        if least[at] < -THRESHOLDS.contact_pulls * np.abs(tension).max():
            pushed[joint.name] = Pushed(push=-float(least[at]), time=float(results.time[at]))
    return pushed


def in_words(name: str, pushed: Pushed) -> str:
    """A note on a rope that pushes."""
    hint = "give it a 'length' and slack: true, or a 'stiffness'"
    return f"rope '{name}' pushes with up to {pushed['push']:.4g} N, at {pushed['time']:.6g} s: no rope does; {hint}"
