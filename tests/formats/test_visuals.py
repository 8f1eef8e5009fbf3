"""What models look like: shapes of the three formats, meshes in the place where their program shows them."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.scene.fields.rotations import to_matrix
from mbproj.scene.meshes import meshes_of
from mbproj.scene.scene import read_scene

INERTIAL = '<inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
URDF = f"""<robot name="m"><material name="red"><color rgba="1 0 0 1"/></material><link name="base"/>
<link name="arm">{INERTIAL}{{}}</link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="1 0 0"/></joint></robot>"""
SDF = """<sdf version="1.9"><model name="m"><link name="arm"><pose>1 0 0 0 0 0</pose>
<inertial><pose>0.1 0.2 0.3 0 0 0</pose><mass>2</mass></inertial>{}</link></model></sdf>"""
SHAPES = {
    "urdf": (
        '<visual><origin xyz="0 0 {z}"/><geometry><{kind} {keys}/></geometry><material name="red"/></visual>',
        URDF,
    ),
    "sdf": (
        '<visual name="{kind}"><pose>0 0 {z} 0 0 0</pose><geometry><{kind}>{tags}</{kind}></geometry>'
        "<material><diffuse>1 0 0 1</diffuse></material></visual>",
        SDF,
    ),
}
SIZES = {
    "box": ({"size": "1 2 3"}, [{"box": [1, 2, 3]}]),
    "sphere": ({"radius": "0.5"}, [{"sphere": 0.5}]),
    "cylinder": ({"radius": "0.5", "length": "2"}, [{"cylinder": {"radius": 0.5, "length": 2}}]),
    "capsule": (
        {"radius": "0.5", "length": "2"},
        [{"cylinder": {"radius": 0.5, "length": 2}}, {"sphere": 0.5, "z": -1}, {"sphere": 0.5, "z": 1}],
    ),
}


@pytest.mark.parametrize("kind", SIZES)
@pytest.mark.parametrize("ending", SHAPES)
def test_shapes_stand_where_the_model_has_them(ending, kind, tmp_path):
    """From the centre of mass, which is at (0.1, 0.2, 0.3) m of the link: the shape is at 0.7 m along z."""
    sizes, expected = SIZES[kind]
    element, text = SHAPES[ending]
    keys = " ".join(f'{name}="{value}"' for name, value in sizes.items())
    tags = "".join(f"<{name}>{value}</{name}>" for name, value in sizes.items())
    path = tmp_path / f"m.{ending}"
    path.write_text(text.format(element.format(kind=kind, keys=keys, tags=tags, z=0.7)), encoding="utf-8")
    mechanism = read_model(path)
    (part,) = mechanism.parts.values()
    assert part.look["colour"] == "#ff0000"
    for shape, wanted in zip(part.look["shapes"], expected, strict=True):
        wanted = dict(wanted)
        np.testing.assert_allclose(shape["position"], [-0.1, -0.2, 0.4 + wanted.pop("z", 0.0)], atol=1e-9)
        assert {key: value for key, value in shape.items() if key != "position"} == wanted
    assert not [row for row in mechanism.said if "drawn" in row.what]


TETRAHEDRON = "v 0 0 0\nv 100 0 0\nv 0 200 0\nv 0 0 300\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MJCF = """<mujoco><compiler meshdir="meshes"/>
<asset><mesh name="part" file="part.obj" scale="0.001 0.001 0.001"/></asset>
<worldbody><body name="arm" pos="1 0 0" euler="10 20 30"><joint axis="0 1 0"/>
<geom type="mesh" mesh="part" pos="0 0.1 0" euler="40 0 5"/></body></worldbody></mujoco>"""


def test_a_mesh_stands_where_mujoco_shows_it(tmp_path):
    """MuJoCo moves it to its centre and principal axes; the scene takes the file as it is, in mm, by its path."""
    mujoco = pytest.importorskip("mujoco")
    pytest.importorskip("trimesh")
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "part.obj").write_text(TETRAHEDRON, encoding="utf-8")
    (tmp_path / "m.xml").write_text(MJCF, encoding="utf-8")
    (tmp_path / "scene.yaml").write_text(scene_text(read_model(tmp_path / "m.xml"), "1"), encoding="utf-8")
    scene = read_scene(tmp_path / "scene.yaml")
    (body,) = scene.bodies
    assert (body.appearance.mesh.file, body.appearance.mesh.scale) == ("meshes/part.obj", 0.001)
    ours = meshes_of(scene)["arm"].vertices @ np.array(to_matrix(body.orientation)).T + np.array(body.position)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "m.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    theirs = model.mesh_vert @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    np.testing.assert_allclose(sorted(map(tuple, ours.round(6))), sorted(map(tuple, theirs.round(6))), atol=2e-6)


@pytest.mark.parametrize("name", ["package://robot/part.obj", "meshes/part.obj", "package://meshes/part.obj"])
def test_a_mesh_is_named_from_the_scenes_folder(name, tmp_path):
    folder = tmp_path / "model"
    (folder / "meshes").mkdir(parents=True)
    for file in (folder / "part.obj", folder / "meshes" / "part.obj"):
        file.write_text(TETRAHEDRON, encoding="utf-8")
    visual = f'<visual><geometry><mesh filename="{name}" scale="0.001 0.001 0.001"/></geometry></visual>'
    (folder / "m.urdf").write_text(URDF.format(visual), encoding="utf-8")
    above, beside = read_model(folder / "m.urdf", ImportOptions(folder=tmp_path)), read_model(folder / "m.urdf")
    file = above.parts["arm"].look["mesh"]["file"]
    assert file == f"model/{beside.parts['arm'].look['mesh']['file']}"
    assert (tmp_path / file).is_file()
    np.testing.assert_allclose(above.parts["arm"].look["mesh"]["position"], [-0.1, -0.2, -0.3], atol=1e-9)
    elsewhere = read_model(folder / "m.urdf", ImportOptions(folder=tmp_path / "other"))
    assert not elsewhere.parts["arm"].look
    assert [row.element for row in elsewhere.said] == ["1 meshes"]


@pytest.mark.parametrize(
    "name", ["../part.obj", "/etc/passwd", "package://../part.obj", "part.dae", "gone.stl", "a\0.stl"[:1]]
)
def test_what_cannot_be_drawn_is_said(name, tmp_path):
    folder = tmp_path / "model"
    folder.mkdir()
    for file in (tmp_path / "part.obj", folder / "part.dae"):
        file.write_text(TETRAHEDRON, encoding="utf-8")
    mesh, flat = f'<mesh filename="{name}"/>', '<box size="0 1 1"/>'
    visual = "".join(f"<visual><geometry>{each}</geometry></visual>" for each in (mesh, flat))
    (folder / "m.urdf").write_text(URDF.format(visual), encoding="utf-8")
    mechanism = read_model(folder / "m.urdf", ImportOptions(folder=tmp_path))
    assert not mechanism.parts["arm"].look
    assert {row.element: row.same.value for row in mechanism.said} == {"1 meshes": "yes", "1 other shapes": "yes"}
