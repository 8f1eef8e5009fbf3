"""Reads the meshes of a scene's appearances from their files, as triangles in the axes of their bodies."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, warn_once
from mbproj.scene.fields.rotations import to_matrix

if TYPE_CHECKING:
    from mbproj.scene.records import MeshFile
    from mbproj.scene.scene import Scene

#: The most triangles of all meshes of a scene, and the most bytes of one file.
MOST_TRIANGLES, MOST_BYTES = 200_000, 32_000_000
#: The largest distance of a vertex from the centre of mass, in m: pages square lengths in single precision.
FARTHEST = 1e15
FEWER = "take a coarser mesh, or reduce this one, with MeshLab's quadric edge collapse for instance"


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A mesh: vertices (k, 3) from the centre of mass in m, in body axes, and triangles (m, 3) of their numbers. The
    corners of a triangle are counter-clockwise as seen from outside."""

    vertices: Array
    triangles: Integers


def meshes_of(scene: Scene) -> dict[str, TriangleMesh]:
    """The meshes of a scene by body. Raises InputError with the place of each mesh that cannot be read or is too large.

    Where trimesh is not installed, or the scene has no file of its own, a warning says so and no mesh is read: meshes
    have no effect on the motion."""
    looks = {body.name: body.appearance for body in scene.bodies if body.appearance is not None}
    wanted = {name: look.mesh for name, look in looks.items() if look.mesh is not None}
    why_not = _why_not(scene)
    if wanted and why_not:
        warn_once(f"bodies are drawn without their meshes: {why_not}")
    if not wanted or why_not or scene.path is None:
        return {}
    meshes: dict[str, TriangleMesh] = {}
    problems = []
    for name, mesh in wanted.items():
        try:
            meshes[name] = _placed(_triangles(scene.path.parent, mesh.file), mesh)
        except Unreadable as error:
            place = scene.place("bodies", name, "appearance", "mesh")
            problems.append(Problem(f"the mesh '{mesh.file}' {error}", place, error.hint))
    if problems:
        raise InputError(problems)
    _refuse_many(scene, meshes)
    return meshes


class Unreadable(Exception):
    """The error of a mesh's file that cannot be read: the fault, and a hint."""

    def __init__(self, what: str, hint: str) -> None:
        super().__init__(what)
        self.hint = hint


def _why_not(scene: Scene) -> str:
    if scene.path is None or not scene.path.is_file():
        return "they stand beside the scene's file, which is not there"
    return "" if find_spec("trimesh") else "trimesh reads them: pip install 'mbproj[animate]'"


def _refuse_many(scene: Scene, meshes: Mapping[str, TriangleMesh]) -> None:
    count = sum(len(mesh.triangles) for mesh in meshes.values())
    if count > MOST_TRIANGLES:
        name = max(meshes, key=lambda body: len(meshes[body].triangles))
        said = f"the meshes have {count} triangles, the largest {len(meshes[name].triangles)}; at most {MOST_TRIANGLES}"
        raise InputError(Problem(f"{said} are drawn", scene.place("bodies", name, "appearance", "mesh"), FEWER))


def _triangles(folder: Path, name: str) -> tuple[Array, Integers]:
    """The vertices (k, 3), in the numbers of the file, and the triangles (m, 3) of them. Raises Unreadable."""
    import trimesh

    path = _inside(folder, name)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}", "look at its permissions") from error
    try:
        # Read from bytes and without materials, so that trimesh opens no other file that this one names.
        kind = path.suffix[1:].lower()
        read: Any = trimesh.load_mesh(BytesIO(data), file_type=kind, skip_materials=True, process=False)
        vertices, triangles = np.asarray(read.vertices, dtype=float), np.asarray(read.faces, dtype=np.intp)
    except Exception as error:  # any error of trimesh is the fault of the file
        raise Unreadable("is damaged", "write it again, as binary STL for instance") from error
    if not len(triangles) or not np.isfinite(vertices).all():
        what = "has numbers that are not finite" if len(triangles) else "has no triangle"
        raise Unreadable(what, "write it again, as binary STL for instance")
    vertices, same = np.unique(vertices, axis=0, return_inverse=True)  # STL repeats each corner in every triangle
    return vertices, same.reshape(-1)[triangles]


def _inside(folder: Path, name: str) -> Path:
    """The path of the file. Raises Unreadable where it is not in the scene's folder or below: a scene from somebody
    else must not open other files."""
    try:
        path, root = (folder / name).resolve(strict=True), folder.resolve()
    except (OSError, RuntimeError) as error:
        raise Unreadable("is not there", f"its path begins at the scene's folder, '{folder}'") from error
    if not path.is_relative_to(root):
        raise Unreadable("is outside of the scene's folder", f"copy it to '{folder}'")
    if not path.is_file():
        raise Unreadable("is no file", "give the path of a .stl or .obj file")
    if path.stat().st_size > MOST_BYTES:
        raise Unreadable(f"has {path.stat().st_size} bytes, and at most {MOST_BYTES} are read", FEWER)
    return path


def _placed(read: tuple[Array, Integers], mesh: MeshFile) -> TriangleMesh:
    """The mesh in m, placed on its body."""
    vertices, triangles = read
    placed: Array = mesh.scale * vertices @ np.array(to_matrix(mesh.orientation)).T + np.array(mesh.position)
    if np.abs(placed).max() > FARTHEST:
        raise Unreadable(f"has vertices beyond {FARTHEST:g} m", "look at its numbers, and at its 'scale'")
    return TriangleMesh(placed, triangles)
