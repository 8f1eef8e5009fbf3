"""The appearance of an MJCF model: geoms as shapes and meshes of bodies, sites as markers, with no effect on motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array
from mbproj.formats.geometry import Frame, from_quaternion
from mbproj.formats.mechanism import ImportedMechanism, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.mjcf.parts import Called
from mbproj.formats.visuals import Shapes, Visual, box, capsule, colour, cylinder, sphere

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)
WORDS = {MESH: "meshes", ELLIPSOID: "ellipsoids"}


def visuals(compiled: CompiledMjcf, called: Called) -> Iterator[Visual]:
    """Yield the geoms of bodies, at the pose of the start."""
    model, data = compiled.model, compiled.data
    for geom in range(model.ngeom):
        kind, material = int(model.geom_type[geom]), int(model.geom_matid[geom])
        pose = Frame(data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3))
        look = colour(model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])
        body, mesh, scale = called[int(model.geom_bodyid[geom])], None, 1.0
        if kind == MESH:
            number = int(model.geom_dataid[geom])
            mesh = compiled.source.files.get(model.mesh(number).name)
            scales = np.array(model.mesh_scale[number])
            scale, mesh = float(scales[0]), mesh if (scales == scales[0]).all() else None
            # MuJoCo's frame of a mesh has the mesh's centre of mass and principal axes.
            moved = Frame(np.array(model.mesh_pos[number]), from_quaternion(model.mesh_quat[number]))
            pose = pose.then(moved.inverse())
        yield Visual(
            body, pose, _shapes(kind, model.geom_size[geom]), mesh, scale, look, WORDS.get(kind, "other shapes")
        )


def _shapes(kind: int, size: Array) -> Shapes:
    if kind == SPHERE:
        return sphere(size[0])
    if kind == BOX:
        return box(2.0 * size[:3])
    if kind in (CYLINDER, CAPSULE):
        return (cylinder if kind == CYLINDER else capsule)(size[0], 2.0 * size[1])
    return ()


def add_markers(compiled: CompiledMjcf, mechanism: ImportedMechanism, called: Called) -> None:
    """Add a marker for each site of a body that moves."""
    model, still = compiled.model, 0
    for site in range(model.nsite):
        body = called[int(model.site_bodyid[site])]
        if body not in mechanism.parts:
            still += 1
            continue
        mechanism.mark(compiled.name("site", site) or f"site_{site}", body, compiled.data.site_xpos[site])
    if still:
        mechanism.say(f"{still} sites of the ground", None, "left out: a marker is of a body that moves", Same.YES)
