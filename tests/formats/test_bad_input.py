"""Models that are wrong or hostile: a reader ends with a scene, or with a message at the line of the file."""

from __future__ import annotations

import copy
import random
import shutil
import subprocess
import sys
from itertools import pairwise
from xml.etree import ElementTree

import pytest

import mbproj
from mbproj import import_model
from mbproj.base.errors import InputError, MbprojWarning
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.formats.signals import read_signals
from mbproj.scene.scene import read_scene_text
from tests.cli.commands import mbproj as command
from tests.cli.commands import succeeds
from tests.crossed import some
from tests.support import ROOT

# Bad input: models changed at random, names that a shell or YAML misreads, files that are outside, huge or none.
#
# Whatever stands in a file, a reader ends with a scene that can be read back, or with InputError at a line of the file.

pytest.importorskip("mujoco")
DATA = ROOT / "tests" / "data" / "formats"
MODELS = sorted(path.name for path in DATA.iterdir() if path.suffix in (".xml", ".urdf", ".sdf"))
#: What stands in the place of an attribute or a text.
VALUES = (
    *("", " ", "nan", "inf", "-1", "0", "1e400", "1e308", "1 2", "0 0 0", "-1 -1 -1", "1,2,3", "0x10", "1_000", "true"),
    *("$(id)", "yes", "1e3", "a: b", "# x", "'", '"', "~", "é", "x" * 5000, "../x", "/etc/passwd", "%s", "world"),
)
BODY = '<body name="b"><joint axis="0 1 0"/><geom size="0.1" pos="0 0 1"/></body>'


def changed(text: str, rng: random.Random) -> str:
    """The model with one or two of its elements gone, twice, renamed, or with another value."""
    root = ElementTree.fromstring(text)
    for _ in range(rng.choice((1, 1, 2))):
        nodes = list(root.iter())
        parents = {child: parent for parent in nodes for child in parent}
        node, other = rng.choice(nodes), rng.choice(nodes)
        way = rng.randrange(6)
        if way == 0 and node in parents:
            parents[node].remove(node)
        elif way == 1 and node in parents:
            parents[node].append(copy.deepcopy(node))
        elif way == 2:
            node.tag, other.tag = other.tag, node.tag
        elif way == 3 and node.attrib:
            del node.attrib[rng.choice(sorted(node.attrib))]
        elif way == 4 and (node.text or "").strip():
            node.text = rng.choice(VALUES)
        elif node.attrib:
            node.set(rng.choice(sorted(node.attrib)), rng.choice(VALUES))
    return ElementTree.tostring(root, encoding="unicode").replace("><", ">\n<")


@pytest.mark.filterwarnings(f"ignore::{MbprojWarning.__module__}.{MbprojWarning.__name__}")
@pytest.mark.parametrize("name", some(MODELS, 8, 4))
def test_a_changed_model_is_a_scene_or_wrong_at_a_line_of_its(name, tmp_path):
    text, path = (DATA / name).read_text(encoding="utf-8"), tmp_path / name
    shutil.copytree(DATA / "rocker", tmp_path / "rocker")  # which one of them includes
    wrong = 0
    for seed in range(60):
        path.write_text(changed(text, random.Random(f"{name} {seed}")), encoding="utf-8")
        try:
            found = import_model(path)
        except InputError as error:
            wrong += 1
            for problem in error.problems:
                assert problem.place is not None
                assert problem.place.file.startswith(str(tmp_path)), f"seed {seed}"
                assert problem.place.line or problem.message == "no body of the model can move", f"seed {seed}"
        else:
            if not any(row.element == "the scene itself" for row in found.mechanism.said):
                read_scene_text(found.text)
    assert 5 < wrong < 55


@pytest.mark.parametrize("name", ["$(touch run).xml", "yes", "1e3", "-q.xml", "a: b # c.xml", "`id`.xml", "\u202e.xml"])
def test_names_mean_nothing_to_a_shell_or_to_yaml(name, tmp_path):
    """File, model, bodies and joints are called so; the scene is read back with as many."""
    text = (
        f'<mujoco model="{name}"><worldbody><body name="{name}"><joint name="{name}" axis="0 1 0"/>'
        '<geom size="0.1" pos="0 0 1"/></body><body name="null"><joint name="~" axis="0 1 0"/>'
        '<geom size="0.1" pos="0 0 1"/></body></worldbody></mujoco>'
    )
    (tmp_path / name).write_text(text, encoding="utf-8")
    succeeds("import", "--quiet", "--output", "scene.yaml", "--", name, folder=tmp_path)
    scene = read_scene_text((tmp_path / "scene.yaml").read_text(encoding="utf-8"))
    assert (scene.title, len(scene.bodies), len(scene.joints)) == (name, 2, 2)
    assert scene.bodies[1].name == "null"
    assert {path.name for path in tmp_path.iterdir()} == {name, "scene.yaml"}


def test_a_name_of_5000_letters_is_cut(tmp_path):
    long = BODY.replace('"b"', '"' + "x" * 5000 + '"')
    (tmp_path / "m.xml").write_text(f"<mujoco><worldbody>{long}</worldbody></mujoco>", encoding="utf-8")
    found = import_model(tmp_path / "m.xml")
    assert found.scene.bodies[0].name == "x" * 80
    assert max(map(len, found.text.splitlines())) < 200


ATTACHED = f"""<mujoco>
<asset><model name="other" file="{{}}"/></asset>
<worldbody>{BODY}<frame pos="1 0 0"><attach model="other" body="b" prefix="o_"/></frame></worldbody>
</mujoco>"""


def test_an_attached_model_is_read_from_the_folder(tmp_path):
    (tmp_path / "other.xml").write_text(f"<mujoco><worldbody>{BODY}</worldbody></mujoco>", encoding="utf-8")
    (tmp_path / "model.xml").write_text(ATTACHED.format("other.xml"), encoding="utf-8")
    assert list(read_model(tmp_path / "model.xml").parts) == ["b", "o_b"]


OUTSIDE = {
    "a model": (ATTACHED.format("../other.xml"), "model.xml:2: error: the file '../other.xml' is outside of"),
    "a circle": (ATTACHED.format("model.xml"), "model.xml:2: error: the files include each other in a circle"),
    "an absolute path": (
        f'<mujoco>\n<include file="/etc/hostname"/><worldbody>{BODY}</worldbody></mujoco>',
        "model.xml:2: error: the file '/etc/hostname' is outside of",
    ),
    "no number": (
        f'<mujoco><worldbody>{BODY}\n<body pos="0 0 nan"/></worldbody></mujoco>',
        "model.xml:2: error: 'pos' of <body> is not finite",
    ),
}


@pytest.mark.parametrize("what", OUTSIDE)
def test_what_is_outside_is_said_at_its_line(what, tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    (tmp_path / "other.xml").write_text(f"<mujoco><worldbody>{BODY}</worldbody></mujoco>", encoding="utf-8")
    text, said = OUTSIDE[what]
    (folder / "model.xml").write_text(text, encoding="utf-8")
    done = command("import", "model.xml", folder=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(said)


DOUBLING = {
    "sdf": '<sdf version="1.9"><model name="m"><link name="l"/>\n{}</model></sdf>',
    "xml": f"<mujoco>{{}}<worldbody>{BODY}</worldbody></mujoco>",
    "attached.xml": f"<mujoco><asset>\n{{}}</asset><worldbody>{BODY}</worldbody></mujoco>",
}
NAMING_NEXT = {
    "sdf": "<include><name>{0}</name><uri>{1}</uri></include>",
    "xml": '<include file="{1}"/>',
    "attached.xml": '<model name="{0}" file="{1}"/>',
}


@pytest.mark.parametrize("kind", DOUBLING)
def test_files_that_include_the_next_one_twice_are_bounded(kind, tmp_path):
    """Twenty of them have a million files to read."""
    for at in range(20):
        following = "".join(NAMING_NEXT[kind].format(name, f"{at + 1}.{kind}") for name in "ab") if at < 19 else ""
        (tmp_path / f"{at}.{kind}").write_text(DOUBLING[kind].format(following), encoding="utf-8")
    with pytest.raises(InputError, match="the model includes more than 1000 files, 32 MB or 500000 elements") as raised:
        import_model(tmp_path / f"0.{kind}")
    assert all(problem.place.file.startswith(str(tmp_path)) for problem in raised.value.problems)


@pytest.mark.parametrize(("kind", "levels"), [("sdf", "<model name='{}'>"), ("xml", "<body name='{}'>")])
def test_levels_of_files_that_include_each_other_are_bounded(kind, levels, tmp_path):
    tag = levels[1:].partition(" ")[0]
    for at in range(20):
        inner = NAMING_NEXT[kind].format("inner", f"{at + 1}.{kind}") if at < 19 else ""
        text = "".join(levels.format(f"l{at}_{level}") for level in range(150)) + inner + f"</{tag}>" * 150
        text = text if kind == "sdf" or at else f"<worldbody>{text}</worldbody>"
        root = '<sdf version="1.9">{}</sdf>' if kind == "sdf" else "<mujoco>{}</mujoco>"
        (tmp_path / f"{at}.{kind}").write_text(root.format(text), encoding="utf-8")
    with pytest.raises(InputError, match="the elements are nested too deep"):
        import_model(tmp_path / f"0.{kind}")


AXES = ("0 0 1e-300", "1e308 0 0", "0 0 0", "nan 0 0")


@pytest.mark.parametrize("axis", AXES)
def test_an_axis_without_a_direction_is_said_at_its_line(axis, tmp_path):
    text = (DATA / "closing.urdf").read_text(encoding="utf-8")
    first = text.index("<axis xyz=")
    (tmp_path / "m.urdf").write_text(f'{text[:first]}\n<axis xyz="{axis}"/>\n{text[text.index(">", first) + 1 :]}')
    line = text[:first].count("\n") + 2
    with pytest.raises(InputError, match=rf"m.urdf:{line}: error: (the axis has no direction|'xyz' of <axis> takes 3)"):
        import_model(tmp_path / "m.urdf")


LONG = {
    "comments without an end": ("<robot>" + "<!--" * 100_000, "m.urdf:1:8: error: no well-formed XML"),
    "text between elements": (
        "<robot>" + ("x" * 70 + "<b/>") * 400_000 + "</robot>",
        "m.urdf:1: error: the model has no",
    ),
}


@pytest.mark.parametrize("what", LONG)
def test_the_time_to_read_grows_no_faster_than_the_file(what, tmp_path):
    """In the square of its length these files would take minutes."""
    text, said = LONG[what]
    (tmp_path / "m.urdf").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as raised:
        import_model(tmp_path / "m.urdf")
    assert said in str(raised.value)


def test_flexible_bodies_are_left_out_and_their_files_not_read(tmp_path):
    flex = '<flexcomp name="cloth" type="mesh" file="/etc/passwd" dim="2"/>'
    text = f"<mujoco><worldbody>{BODY.replace('</body>', flex + '</body>')}</worldbody></mujoco>"
    (tmp_path / "model.xml").write_text(text, encoding="utf-8")
    (row,) = [each for each in read_model(tmp_path / "model.xml").said if each.element == "flexcomp 'cloth'"]
    assert (row.what, row.same.value) == ("left out: a scene has no flexible bodies", "no")


FILES = {
    "empty": (b"", "{}:1:1: error: no well-formed XML: no element found"),
    "binary": (bytes(range(256)), "{}:1:1: error: no well-formed XML: not well-formed"),
    "another encoding": (b'<?xml version="1.0" encoding="ebcdic-99"?><robot/>', "{}:1: error: no XML that can be read"),
    "many elements": (b"<robot>" + b"<link/>" * 600_000 + b"</robot>", "{}:1: error: the file has more than 500000"),
}


@pytest.mark.parametrize("what", FILES)
def test_files_that_are_no_models_end_with_2(what, tmp_path):
    data, said = FILES[what]
    (tmp_path / "m.urdf").write_bytes(data)
    done = command("import", "m.urdf", folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(said.format("m.urdf"))


def test_aliases_in_a_file_of_loops_are_bounded(tmp_path):
    (tmp_path / "m.urdf").write_text((DATA / "closed_loop.urdf").read_text(encoding="utf-8"), encoding="utf-8")
    rows = ["a: &a [x, x, x, x, x, x, x, x, x]"]
    rows += [f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]" for before, name in pairwise("abcdefghi")]
    (tmp_path / "bomb.yaml").write_text("\n".join([*rows, "closed_loop: *i"]), encoding="utf-8")
    done = command("import", "m.urdf", "--loops", "bomb.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert "error: more than 500000 values, with aliases counted" in done.stderr


# Tendons, muscles, controllers and signals that are wrong: a message at the file's line; names mean nothing.

mujoco = pytest.importorskip("mujoco")

MODEL = """<mujoco><worldbody><site name="w" pos="0 0 1"/><geom name="box" type="box" size=".1 .1 .1" pos="3 0 0"/>
<body name="a"><joint name="j" axis="0 1 0"/><geom size=".1" pos=".3 0 0" contype="0"/><site name="s" pos=".3 0 .2"/>
</body></worldbody>
{}
</mujoco>"""
LINE = '<site site="w"/><site site="s"/>'


def tendon(own, path=LINE):
    return f'<tendon><spatial name="t" {own}>{path}</spatial></tendon>'


WRONG = {
    tendon("", '<site site="w"/><site site="nix"/>'): "site 'nix' not found",
    tendon("", f'{LINE}<pulley divisor="-2"/>{LINE}'): "pulley divisor must be positive",
    tendon("", '<site site="w"/><geom geom="box"/><site site="s"/>'): "is not sphere or cylinder",
    tendon('stiffness="nan"'): "'stiffness' of <spatial> is not finite",
    tendon('stiffness="-5"'): "'stiffness' of <spatial> is negative; give 0 or more",
    tendon('frictionloss="-5"'): "'frictionloss' of <spatial> is negative; give 0 or more",
    tendon('damping="-5 0 0"'): "'damping' of <spatial> is negative; give 0 or more",
    '<default><joint damping="-1"/></default>': "'damping' of <joint> is negative; give 0 or more",
    '<actuator><muscle name="m" joint="j" range="1 1" lengthrange="0 1"/></actuator>': "range",
    '<actuator><muscle name="m" joint="j" lengthrange="2 1"/></actuator>': "Lengthrange computation did not converge",
    '<extension><plugin plugin="mujoco.nix"/></extension>': "plugin mujoco.nix not found",
}


@pytest.mark.parametrize("part", WRONG)
def test_a_part_that_is_wrong_is_said_at_its_line(part, tmp_path):
    (tmp_path / "model.xml").write_text(MODEL.format(part), encoding="utf-8")
    with pytest.raises(InputError) as raised:
        read_model(tmp_path / "model.xml", ImportOptions())
    message = str(raised.value)
    assert "model.xml:4: error: " in message
    assert WRONG[part] in message


@pytest.mark.parametrize("name", ["yes", "1e3", "$(touch run)`id`: # \u202e"])
def test_names_of_tendons_mean_nothing(name, tmp_path):
    """Of one that is a rope, a spring, a limit and dry friction."""
    own = 'stiffness="3" springlength="0 9" range="0 9" frictionloss="1"'
    part = tendon(own, f'{LINE}<site site="w"/>').replace('"t"', f'"{name}"')
    (tmp_path / "model.xml").write_text(MODEL.format(part), encoding="utf-8")
    found = mbproj.import_model(tmp_path / "model.xml")
    assert found.scene.joints
    assert not [row for row in found.mechanism.said if row.same.value == "no"]
    assert not (tmp_path / "run").exists()


SIGNALS = {
    "m: &a [1, 1]\nn: *a\n": "the expression ends too early",
    "m: " + "(" * 600 + "t" + ")" * 600: "at most 1000 are allowed",
    "m: 9**9**9**9": "the result is too large",
    "m: [1,": "not valid YAML",
    "m: 1\nm: 2": "duplicate key 'm'",
    "m: .nan": "m",
    'm: __import__("os")': "unexpected",
    "- 1": "signals are a mapping of names and expressions of t",
}


@pytest.mark.parametrize("text", SIGNALS)
def test_signals_that_are_wrong_are_said_at_their_line(text, tmp_path):
    (tmp_path / "u.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as raised:
        read_signals(tmp_path / "u.yaml")
    assert "u.yaml:" in str(raised.value)
    assert SIGNALS[text] in str(raised.value)


FIXED = '<site site="w"/><site site="v"/>'
ON_IT = ('frictionloss="1"', 'armature="0.2"', 'range="0 1" limited="true"', 'stiffness="3"', 'damping="2"', "")


@pytest.mark.parametrize("own", ON_IT)
@pytest.mark.parametrize("path", [FIXED, '<site site="s"/><site site="u"/>'], ids=["of the ground", "of one body"])
def test_a_tendon_that_nothing_changes_is_left_out(own, path, tmp_path):
    """It has no force, whatever acts along it; nor does an equality of two of them, or an actuator."""
    text = MODEL.format(
        f'<tendon><spatial name="t" {own}>{path}</spatial><spatial name="r">{path}</spatial></tendon>'
        '<equality><tendon tendon1="t" tendon2="r"/></equality>'
        '<actuator><motor name="m" tendon="t"/></actuator>'
    )
    text = text.replace('<site name="w"', '<site name="v" pos="1 0 1"/><site name="w"')
    text = text.replace('<site name="s"', '<site name="u" pos=".1 0 .1"/><site name="s"')
    (tmp_path / "model.xml").write_text(text, encoding="utf-8")
    found = mbproj.import_model(tmp_path / "model.xml")
    said = {row.element: (row.what, row.same.value) for row in found.mechanism.said}
    assert said["tendon 't'"] == ("left out: nothing changes its length", "yes")
    assert said["equality '0' (tendon)"] == ("left out: nothing changes the length of its tendons", "yes")
    assert [*found.mechanism.joints] == ["j"]
    assert not found.mechanism.forces
    assert found.agreement.acceleration_relative < 1e-12


@pytest.mark.parametrize("what", ["", "raise ImportError('libmujoco.so: no such file')"])
def test_a_mujoco_that_cannot_be_loaded_is_no_fault_of_mbproj(what, tmp_path):
    """A folder of its name without its core, or one whose library is missing."""
    (tmp_path / "mujoco").mkdir()
    (tmp_path / "mujoco" / "__init__.py").write_text(what, encoding="utf-8")
    (tmp_path / "model.xml").write_text(MODEL.format(""), encoding="utf-8")
    program = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\nfrom mbproj.commands.main import main; main()"
    command = [sys.executable, "-c", program, "import", "model.xml"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("model.xml: error: MuJoCo compiles MJCF, and cannot be loaded: ")
    assert "Traceback" not in done.stderr
