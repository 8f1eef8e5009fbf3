"""Tendons, muscles, controllers and signals that are wrong: a message at the file's line; names mean nothing."""

from __future__ import annotations

import subprocess
import sys

import pytest

import mbproj
from mbproj.base.errors import InputError
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.formats.signals import read_signals

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
