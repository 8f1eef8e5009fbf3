"""The keys of a scene for a place and an orientation on a body."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.scene.fields.rotations import from_matrix


def quaternion(rotation: Array) -> Array:
    """The unit Euler parameters (4,) of a rotation matrix."""
    return np.array(from_matrix(tuple(map(tuple, rotation.tolist()))))  # type: ignore[arg-type]


def placed(position: Array, rotation: Array) -> dict[str, Any]:
    """The keys `position` and `orientation`; one that changes nothing is left out."""
    keys: dict[str, Any] = {}
    if np.abs(position).max() > 1e-15:
        keys["position"] = np.round(position, 9)
    turned = quaternion(rotation)
    if np.abs(turned[1:]).max() > 1e-9:
        keys["orientation"] = {"quaternion": np.round(turned, 9)}
    return keys
