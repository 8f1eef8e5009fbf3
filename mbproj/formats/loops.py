"""Joints that close loops, with a frame of each of two links that need not meet where the model begins."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.formats.geometry import Frame
from mbproj.formats.mechanism import Connection, ImportedMechanism, ImportedNames, Same


@dataclass(frozen=True, eq=False)
class Loop:
    """A joint of the scene's `type` between frames of two links, given in theirs, with an `axis` in both frames."""

    name: str
    type: str
    links: tuple[str, str]
    frames: tuple[Frame, Frame]
    axis: Array
    place: Place


def add_loops(
    mechanism: ImportedMechanism,
    loops: list[Loop],
    frames: Mapping[str, Frame],
    called: Mapping[str, str],
    names: ImportedNames,
) -> None:
    """Add the joints of loops, with a point and an axis in each body. `frames` are the global poses of the links."""
    for loop in loops:
        bodies = (called[loop.links[0]], called[loop.links[1]])
        if bodies[0] == bodies[1]:
            mechanism.say(f"loop '{loop.name}'", loop.place, f"left out: both ends are on '{bodies[0]}'", Same.YES)
            continue
        points, axes, turns = np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3, 3))
        for side, (link, own) in enumerate(zip(loop.links, loop.frames, strict=True)):
            held, part = frames[link].then(own), mechanism.part(bodies[side])
            points[side], turns[side] = part.local(held.position), part.rotation.T @ held.rotation
            axes[side] = turns[side] @ loop.axis
        name = names.unused(loop.name)
        with_axis = axes if loop.type not in ("spherical", "fixed") else None
        with_turns = turns if loop.type == "fixed" else None
        mechanism.joints[name] = Connection(name, loop.type, bodies, points, with_axis, with_turns, {}, loop.place)
