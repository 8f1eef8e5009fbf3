"""Reactions and contact forces that are not unique, in words: redundant joints, stops and frictions share them
arbitrarily."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from mbproj.errors import shortened
from mbproj.results import Results

Marks = npt.NDArray[np.bool_]
#: The paths of reactions in the results.
REACTIONS = ("joints/reaction_force", "joints/reaction_torque")
#: The most joints that are listed with the same components.
SHOWN = 8


def open_components(joints: Sequence[str], force_unique: Marks, torque_unique: Marks) -> dict[str, str]:
    """The components that are not unique, as "Fy Tx Tz", by joint. `force_unique` and `torque_unique` (nj, 3) mark the
    unique ones. Joints with unique reactions are left out."""
    words = {}
    for name, *marks in zip(joints, force_unique, torque_unique, strict=True):
        pairs = zip("FT", marks, strict=True)
        components = [kind + "xyz"[axis] for kind, unique in pairs for axis in np.flatnonzero(~unique)]
        if components:
            words[name] = " ".join(components)
    return words


def reactions_not_unique(results: Results) -> dict[str, str] | None:
    """The components that are not unique in a results file, as "Fy Tx Tz", by joint; None where the file has no
    marks."""
    marks = [results.constant(f"{path}_unique") for path in REACTIONS]
    if marks[0] is None or marks[1] is None:
        return None
    return open_components(results.names("joints"), marks[0], marks[1])


def shared_at_contacts(results: Results) -> dict[str, float]:
    """The first time (s) at which contacts share a force arbitrarily, by its owner: "stop 'a'", "friction 'b'", "joint
    'C'"."""
    first: dict[str, float] = {}
    for event in results.events:
        if event.kind == "shared" and event.direction == 1:
            first.setdefault(event.name, event.time)
    return first


def in_words(components: Mapping[str, str]) -> str:
    """A text of the components by joint. Joints with the same components stand together: "Fy Tx Tz of A, B, C, D"."""
    joints: dict[str, list[str]] = {}
    for joint, open_ in components.items():
        joints.setdefault(open_, []).append(joint)
    return "; ".join(f"{open_} of {shortened(names, SHOWN)}" for open_, names in joints.items())
