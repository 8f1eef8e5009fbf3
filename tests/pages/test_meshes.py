"""Meshes of bodies: they stand in the body's axes, go with the results, and a file that does not fit is named."""

from __future__ import annotations

import shutil

import h5py
import numpy as np
import pytest

from mbproj.base.errors import InputError, MbprojWarning
from mbproj.results.check import check_results
from mbproj.results.reader import open_results
from mbproj.scene import meshes
from mbproj.scene.meshes import meshes_of
from mbproj.scene.scene import read_scene
from mbproj.show.page.pages import page_of
from mbproj.show.page.write import html
from tests.cli.commands import mbproj
from tests.pages.runs import block_of, bytes_of, data_of, recorded

#: A tetrahedron: the same in both formats, in mm.
CORNERS = np.array([[0, 0, 0], [100, 0, 0], [0, 200, 0], [0, 0, 300]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
STL = (
    "solid t\n"
    + "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS[face])
        + "endloop\nendfacet\n"
        for face in FACES
    )
    + "endsolid t\n"
)
OBJ = (
    "mtllib /etc/passwd\n"
    + "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    + "".join("f {} {} {}\n".format(*face + 1) for face in FACES)
)
SCENE = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 0.1, step: 0.01}
bodies:
  bob:
    mass: 1
    inertia: [1, 1, 1]
    position: [0, 0, -1]
    appearance: {mesh: MESH}
joints: {pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}}
"""
PLACED = "{file: t.stl, scale: 0.001, position: [0, 0, 0.5], orientation: {axis: [0, 0, 1], angle: 90 deg}}"


def scene_with(folder, mesh, **files):
    (folder / "bob.yaml").write_text(SCENE.replace("MESH", mesh), encoding="utf-8")
    for name, text in files.items():
        (folder / name.replace("_", ".")).write_text(text, encoding="utf-8")
    return read_scene(folder / "bob.yaml")


def spanned(mesh):
    """The corners of each triangle (m, 9), in an order of their own."""
    return np.array(sorted(mesh.vertices[mesh.triangles].reshape(-1, 9).round(9).tolist()))


def test_a_mesh_is_scaled_turned_and_shifted_from_the_centre_of_mass(tmp_path):
    (mesh,) = meshes_of(scene_with(tmp_path, PLACED, t_stl=STL)).values()
    x, y, z = CORNERS.T / 1000.0
    there = np.column_stack([-y, x, z + 0.5])
    expected = np.array(sorted(there[FACES].reshape(-1, 9).round(9).tolist()))
    assert np.allclose(spanned(mesh), expected, atol=1e-8)


def test_both_formats_give_the_same_and_what_they_name_is_not_opened(tmp_path):
    one = meshes_of(scene_with(tmp_path, "t.stl", t_stl=STL))["bob"]
    other = meshes_of(scene_with(tmp_path, "t.obj", t_obj=OBJ))["bob"]
    assert np.allclose(spanned(one), spanned(other))


def test_results_show_the_mesh_wherever_they_go(tmp_path):
    scene = scene_with(tmp_path, PLACED, t_stl=STL)
    path = recorded(scene, tmp_path / "bob.h5")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    shutil.move(path, elsewhere / "bob.h5")
    (tmp_path / "t.stl").unlink()
    with open_results(elsewhere / "bob.h5") as results:
        assert check_results(results).faults == ()
        page = page_of([results], ["bob"])
        kept = results.meshes()["bob"]
    text = html(page.title, page.data, page.packer)
    (run,), packed = data_of(text)["runs"], bytes_of(text)
    (part,) = [part for part in run["look"]["parts"] if part["layer"] == "bodies"]
    drawn = run["look"]["meshes"][part["mesh"]]
    vertices = block_of(packed, run["blocks"][drawn["vertices"]])
    assert np.abs(vertices - kept.vertices).max() <= 2.0**-16
    assert (block_of(packed, run["blocks"][drawn["triangles"]]) == kept.triangles).all()


@pytest.mark.parametrize(
    ("mesh", "files", "said"),
    [
        ("t.stl", {}, "the mesh 't.stl' is not there; its path begins at the scene's folder"),
        ("t.stl", {"t_stl": "solid t\nendsolid t\n"}, "the mesh 't.stl' (has no triangle|is damaged)"),
        ("t.obj", {"t_obj": "v 1 2\nf 1 2 3 99\n"}, "the mesh 't.obj' (has no triangle|is damaged)"),
        ("t.obj", {"t_obj": OBJ.replace("v 100", "v nan")}, "the mesh 't.obj' has numbers that are not finite"),
        ("../t.stl", {}, r"the mesh '../t.stl' is (not there|outside of the scene's folder)"),
        ("/etc/t.stl", {}, r"the mesh '/etc/t.stl' is not there"),
    ],
)
def test_a_mesh_that_cannot_be_read_is_said_with_its_place(tmp_path, mesh, files, said):
    with pytest.raises(InputError, match=rf"bob.yaml:9:24: error: {said}"):
        recorded(scene_with(tmp_path, mesh, **files), tmp_path / "bob.h5")
    assert not (tmp_path / "bob.h5").exists()


def test_a_link_out_of_the_scenes_folder_is_not_followed(tmp_path):
    folder = tmp_path / "scene"
    folder.mkdir()
    (tmp_path / "t.stl").write_text(STL)
    (folder / "t.stl").symlink_to(tmp_path / "t.stl")
    with pytest.raises(InputError, match=r"the mesh 't.stl' is outside of the scene's folder; copy it to"):
        meshes_of(scene_with(folder, "t.stl"))


def test_too_many_triangles_and_bytes_are_refused(tmp_path, monkeypatch):
    scene = scene_with(tmp_path, "t.stl", t_stl=STL)
    monkeypatch.setattr(meshes, "MOST_TRIANGLES", 3)
    with pytest.raises(
        InputError, match=r"yaml:9:24: error: the meshes have 4 triangles, the largest 4; at most 3 are"
    ):
        meshes_of(scene)
    monkeypatch.setattr(meshes, "MOST_BYTES", 100)
    with pytest.raises(InputError, match=r"has \d+ bytes, and at most 100 are read; take a coarser mesh"):
        meshes_of(scene)


def test_without_trimesh_a_run_goes_on_and_says_what_is_not_shown(tmp_path, monkeypatch):
    scene = scene_with(tmp_path, "t.stl", t_stl=STL)
    monkeypatch.setattr(meshes, "find_spec", lambda name: None)
    with pytest.warns(MbprojWarning, match="drawn without their meshes: trimesh reads them: pip install"):
        path = recorded(scene, tmp_path / "bob.h5")
    with open_results(path) as results:
        assert results.meshes() == {}
        assert page_of([results], ["bob"]).data["runs"][0]["look"]["bodies"][0]["name"] == "bob"


def test_a_file_whose_triangles_have_no_corners_is_damaged(tmp_path):
    path = recorded(scene_with(tmp_path, "t.stl", t_stl=STL), tmp_path / "bob.h5")
    with h5py.File(path, "r+") as file:
        corners = file["scene/meshes/0/triangles"]
        corners[0, 0] = 99
        for name in list(corners.attrs):
            del corners.attrs[name]
    with open_results(path) as results, pytest.raises(InputError, match="'scene/meshes/0' is no mesh"):
        results.meshes()


@pytest.mark.parametrize(("scale", "size"), [(1.0, 1e30), (1e49, 1.0)])
def test_vertices_that_no_page_can_show_are_refused(tmp_path, scale, size):
    far = STL.replace("vertex 100 0 0", f"vertex {100 * size} 0 0")
    with pytest.raises(InputError, match="has vertices beyond 1e\\+15 m; look at its numbers, and at its 'scale'"):
        meshes_of(scene_with(tmp_path, f"{{file: t.stl, scale: {scale}}}", t_stl=far))
    assert mbproj("run", "bob.yaml", "-o", "bob.h5", folder=tmp_path).returncode == 2
    done = mbproj("check", "bob.yaml", folder=tmp_path)
    assert (done.returncode, "error: the mesh 't.stl' has vertices beyond" in done.stderr) == (2, True)
    assert not list(tmp_path.glob("bob.h5*"))
