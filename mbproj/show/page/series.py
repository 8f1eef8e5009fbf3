"""The data of a mechanism and its run for a page: plain data for JSON, and blocks of packed numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.pages.appearance.mechanism import DrawnSpan, Look
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.appearance.view import View
from mbproj.pages.data.packing import Packer, step_of
from mbproj.pages.data.series import SeriesGroup

#: Binary digits of positions relative to the mechanism (as in float32), of Euler parameters, of series, and of vertices
#: of meshes. Then the largest distance of a position from the middle, as a power of two of its step.
POSITION, TURN, SERIES, VERTEX, FARTHEST = 24, 19, 18, 16, 29
#: The step of logarithms of sizes, and the size that replaces zero.
LOGARITHM, ZERO = 2.0**-10, 1e-18


def view_data(view: View) -> dict[str, Any]:
    """The data of a view. The page's axes have their origin at its middle."""
    return {
        "middle": _numbers(view.middle),
        "eye": _numbers(view.eye),
        "up": _numbers(view.up),
        "radius": float(view.radius),
        "flat": view.flat,
        "points": [_short(point - view.middle) for point in view.points],
    }


def look_data(look: Look, packer: Packer) -> dict[str, Any]:
    """The data of a look. Parts refer to meshes by their numbers."""
    meshes: list[dict[str, Any]] = []
    parts = []
    for drawn in look.drawn:
        part = drawn.part
        entry: dict[str, Any] = {
            "kind": part.kind,
            "size": _short(part.size),
            "position": _short(part.position),
            "orientation": _short(part.orientation),
            "carrier": drawn.carrier,
            "layer": drawn.layer,
            "item": drawn.item,
        }
        if part.mesh is not None:
            entry["mesh"] = len(meshes)
            step = float(step_of(part.mesh.vertices.reshape(-1, 1), VERTEX)[0])
            corners = packer.add(part.mesh.vertices, step), packer.add(part.mesh.triangles.astype(float), 1.0)
            meshes.append(dict(zip(("vertices", "triangles"), corners, strict=True)))
        parts.append(entry)
    return {
        "bodies": [{"name": body.name, "colour": body.colour, "opacity": body.opacity} for body in look.bodies],
        "joints": [
            {"name": joint.name, "type": joint.type, "bodies": list(joint.bodies), "point": _short(joint.point)}
            for joint in look.joints
        ],
        "markers": [
            {"name": marker.name, "body": marker.body, "point": _numbers(marker.point)} for marker in look.markers
        ],
        "spans": [
            {
                "kind": span.kind,
                "name": span.name,
                "carriers": list(span.carriers),
                "points": [_short(point) for point in span.points],
                "radius": span.radius,
                **_rope_data(span),
            }
            for span in look.spans
        ],
        "forces": list(look.forces),
        "loads": [
            {"name": load.name, "body": load.body, "point": _short(load.point), "torque": load.torque}
            for load in look.loads
        ],
        "parts": parts,
        "meshes": meshes,
        "thickness": look.thickness,
        "gravity": _numbers(look.gravity),
    }


def motion_data(motion: PoseHistory, size: float, packer: Packer) -> dict[str, Any]:
    """The data of a motion: poses with positions relative to their middle. `size` is that of the mechanism in m."""
    count = len(motion.time)
    low, high = motion.position.min(axis=(0, 1)), motion.position.max(axis=(0, 1))
    centre = 0.5 * (low + high)
    travel = 0.5 * float((high - low).max(initial=0.0))
    step = max(2.0 ** (np.ceil(np.log2(size)) - POSITION), 2.0 ** (np.ceil(np.log2(travel or size)) - FARTHEST))
    time = motion.time[:, None]
    return {
        "time": packer.add(time, step_of(time, FARTHEST)),
        "position": packer.add((motion.position - centre).reshape(count, -1), step),
        "orientation": packer.add(_steady(motion.orientation).reshape(count, -1), 2.0**-TURN),
        "centre": _numbers(centre),
    }


def path_data(look: Look, motion: PoseHistory, packer: Packer) -> list[dict[str, Any]]:
    """The paths of the points at which rolling joints touch, global, in m."""
    paths = ((each.name, each.path(motion)) for each in look.touching)
    return [{"name": name, "block": packer.add(path, step_of(path, POSITION))} for name, path in paths]


def group_data(group: SeriesGroup, values: Array, packer: Packer) -> dict[str, Any]:
    """The data of a group with its series (F, c); logarithmic series become powers of ten."""
    powers = np.log10(np.maximum(np.abs(values), ZERO)) if group.logarithmic else values
    return {
        "name": group.name,
        "kind": group.kind,
        "owners": list(group.owners),
        "components": list(group.components),
        "units": list(group.units),
        "logarithmic": group.logarithmic,
        "block": packer.add(powers, LOGARITHM if group.logarithmic else step_of(values, SERIES)),
    }


def _steady(orientation: Array) -> Array:
    """Euler parameters (T, n, 4) with signs that do not jump from sample to sample."""
    turns = np.einsum("tnk,tnk->tn", orientation[1:], orientation[:-1])
    signs = np.cumprod(np.where(turns < 0.0, -1.0, 1.0), axis=0)
    steady = orientation.copy()
    steady[1:] *= signs[..., None]
    return steady


def _numbers(values: Sequence[float] | Array) -> list[float]:
    return [float(value) for value in values]


def _rope_data(span: DrawnSpan) -> dict[str, Any]:
    """The data of the circles that a part of a rope touches."""
    if span.normal is None:
        return {}
    return {"radii": list(span.radii), "normal": _numbers(span.normal), "frame": span.frame}


def _short(values: Sequence[float] | Array) -> list[float]:
    """The values with seven digits, which are enough to draw."""
    return [float(f"{value:.7g}") for value in values]
