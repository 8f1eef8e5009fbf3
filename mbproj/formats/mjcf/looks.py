"""What an MJCF model looks like: geoms as shapes and meshes of bodies, sites as markers. No say in the motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.formats.mechanism import Mechanism, Same
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.parts import Called
from mbproj.formats.placed import placed

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)


def add_looks(compiled: Compiled, mechanism: Mechanism, called: Called) -> None:
    """Gives bodies an appearance, of geoms that can be drawn; what cannot is said once."""
    model, data = compiled.model, compiled.data
    shapes: dict[str, list[dict[str, Any]]] = {}
    colours: dict[str, Array] = {}
    undrawn: dict[str, int] = {}
    for geom in range(model.ngeom):
        body, kind = called[int(model.geom_bodyid[geom])], int(model.geom_type[geom])
        if body not in mechanism.parts:
            continue
        part = mechanism.parts[body]
        found = _shapes(kind, model.geom_size[geom])
        if not found:
            word = {MESH: "meshes", ELLIPSOID: "ellipsoids"}.get(kind, "other shapes")
            undrawn[word] = undrawn.get(word, 0) + 1
            continue
        rotation = part.rotation.T @ data.geom_xmat[geom].reshape(3, 3)
        for shape, shift in found:
            along = part.rotation.T @ (data.geom_xmat[geom].reshape(3, 3) @ shift)
            turned = np.eye(3) if "sphere" in shape else rotation
            shapes.setdefault(body, []).append(shape | placed(part.local(data.geom_xpos[geom]) + along, turned))
        material = int(model.geom_matid[geom])
        colours.setdefault(body, model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])
    for body, own in shapes.items():
        part = mechanism.parts[body]
        mechanism.parts[body] = _looking(part, {"colour": _hex(colours[body]), "shapes": own})
    for word, count in undrawn.items():
        what = "not drawn: a scene shows one mesh file of a body in its folder; add 'appearance' by hand"
        mechanism.say(f"{count} {word}", None, what if word == "meshes" else "not drawn", Same.YES)


def _looking(part: Any, look: dict[str, Any]) -> Any:
    from dataclasses import replace

    return replace(part, look=look)


def _shapes(kind: int, size: Array) -> list[tuple[dict[str, Any], Array]]:
    """Shapes of a scene, each with its shift in the geom's axes. A capsule is a cylinder and two spheres."""
    none, up = np.zeros(3), np.array([0.0, 0.0, 1.0])
    if kind == SPHERE:
        return [({"sphere": float(size[0])}, none)]
    if kind == BOX:
        return [({"box": 2.0 * size[:3]}, none)]
    if kind in (CYLINDER, CAPSULE):
        tube = {"cylinder": {"radius": float(size[0]), "length": float(2.0 * size[1])}}
        ends = [({"sphere": float(size[0])}, sign * size[1] * up) for sign in (-1.0, 1.0)]
        return [(tube, none), *(ends if kind == CAPSULE else [])]
    return []


def _hex(rgba: Array) -> str:
    return "#" + "".join(f"{round(255 * min(1.0, max(0.0, float(part)))):02x}" for part in rgba[:3])


def add_markers(compiled: Compiled, mechanism: Mechanism, called: Called) -> None:
    """Sites of bodies that move become markers."""
    model, still = compiled.model, 0
    for site in range(model.nsite):
        body = called[int(model.site_bodyid[site])]
        if body not in mechanism.parts:
            still += 1
            continue
        mechanism.mark(compiled.name("site", site) or f"site_{site}", body, compiled.data.site_xpos[site])
    if still:
        mechanism.say(f"{still} sites of the ground", None, "left out: a marker is of a body that moves", Same.YES)
