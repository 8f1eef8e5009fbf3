"""Tendons over sites, pulleys and shapes: ropes, telescopes and sums of them, with forces as MuJoCo's own."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.equations.assembly.compiled import compile_system
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.formats.signals import signals_of
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.planar.reduction import NotPlanar, planar_reduction
from tests.crossed import once, some
from tests.formats.agreement import agreement

mujoco = pytest.importorskip("mujoco")

#: Two arms that turn about y, and a cart; a drum and a ball that tendons bend around in the plane y = 0.1.
MODEL = """<mujoco><compiler angle="radian"/><worldbody>
  <site name="post" pos="-0.6 0.1 0.6"/><site name="far" pos="0.9 0.1 0.4"/><site name="off" pos="-0.6 0.3 0.6"/>
  <geom name="drum" type="cylinder" size="0.12 0.3" euler="1.5707963267948966 0 0" pos="0.1 0.3 0.5" contype="0"/>
  <site name="above" pos="0.1 0.1 0.9"/><site name="within" pos="0.1 0.1 0.55"/>
  <body name="arm"><joint name="turn" axis="0 1 0"/>
    <geom type="box" size="0.1 0.05 0.3" pos="0 0 -0.3" contype="0"/>
    <geom name="ball" size="0.1" pos="0.2 0.1 -0.2" contype="0"/><site name="over" pos="0.5 0.1 -0.2"/>
    <site name="hip" pos="0.2 0.1 0.1"/><site name="knee" pos="0.1 0.1 -0.4"/>
    <body name="leg" pos="0 0 -0.6"><joint name="bend" axis="0 1 0"/>
      <geom size="0.1" pos="0.2 0.1 -0.1" contype="0"/><site name="foot" pos="0.35 0.1 -0.1"/></body></body>
  <body name="cart" pos="0.7 0 0"><joint name="slide" type="slide" axis="0.6 0 0.8"/>
    <geom size="0.1" contype="0"/><site name="hook" pos="0 0.1 0.1"/></body>
</worldbody>
<tendon>{tendon}</tendon>{rest}</mujoco>"""
PATHS = {
    "sites": '<site site="post"/><site site="hip"/><site site="knee"/><site site="foot"/>',
    "a pulley": '<site site="post"/><site site="hip"/><pulley divisor="2"/><site site="far"/><site site="hook"/>'
    '<pulley divisor="2"/><site site="hip"/><site site="knee"/>',
    "a cylinder": '<site site="post"/><geom geom="drum" sidesite="above"/><site site="far"/><site site="hook"/>',
    "a cylinder behind a pulley": '<pulley divisor="3"/><site site="post"/><geom geom="drum" sidesite="above"/>'
    '<site site="hook"/>',
    "a ball": '<site site="hip"/><geom geom="ball" sidesite="over"/><site site="foot"/>',
    "several shapes": '<site site="post"/><geom geom="drum" sidesite="above"/><site site="hip"/><geom geom="ball" '
    'sidesite="over"/><site site="foot"/><site site="hook"/>',
}
ACTING = {
    "spring": ('stiffness="30" damping="4" springlength="0.9"', "", ()),
    "powers": ('stiffness="30 5 2" damping="4 1 0.5" springlength="0.2"', "", ()),
    "slack spring": ('stiffness="30" damping="1" springlength="0 0.9"', "", ()),
    "motor": ("", '<motor name="u" tendon="t" gear="-2"/>', (0.4,)),
    "servo": ("", '<position name="u" tendon="t" kp="30" kv="2" gear="0.5"/>', (0.4,)),
    "muscle": ("", '<muscle name="u" tendon="t" force="40" lengthrange="0.5 2.5"/>', (0.4,)),
}
if not hasattr(mujoco.MjModel, "tendon_stiffnesspoly"):
    del ACTING["powers"]


def written(folder, path, own="", actuator="", more=""):
    tendon = f'<spatial name="t" {own}>{PATHS.get(path, path)}</spatial>'
    rest = f"<actuator>{actuator}</actuator>{more}"
    (folder / "model.xml").write_text(MODEL.format(tendon=tendon, rest=rest), encoding="utf-8")
    return folder / "model.xml"


@pytest.mark.parametrize(("path", "name"), once([*PATHS], [*ACTING]))
def test_forces_along_tendons_are_mujocos(name, path, tmp_path):
    own, actuator, ctrl = ACTING[name]
    act = [0.3] if name == "muscle" else []
    home = '<keyframe><key name="home" act="0.3"/></keyframe>' if act else ""
    file = written(tmp_path, path, own, actuator, home)
    options = (
        ImportOptions("home" if act else None, controls=signals_of({"u": 0.4}, "controls")) if ctrl else ImportOptions()
    )
    said = {row.element: row.same.value for row in read_model(file, options).said}
    assert said.get("actuator 'u'", "yes") == "yes"
    assert said.get("tendon 't'", "yes") == ("until then" if "geom" in PATHS[path] else "yes")
    assert max(agreement(file, states=5, options=options, ctrl=ctrl, act=act, spread=0.2)) < 1e-11


NAMES = ("turn.angle", "bend.angle", "slide.displacement")
#: A pulley between parts of one tree of bodies: MuJoCo's armature couples no others.
IN_ONE_TREE = '<site site="post"/><site site="hip"/><pulley divisor="2"/><site site="hip"/><site site="foot"/>'


def moved(file, duration=0.1):
    """The model's coordinates (k, 3) of a run of the scene, and MuJoCo's model with its data."""
    results = mbproj.run(mbproj.import_model(file).scene, duration=duration, tolerance=1e-9)
    model = mujoco.MjModel.from_xml_path(str(file))
    return np.array([results.coordinate(name).value for name in NAMES]).T, model, mujoco.MjData(model)


def lengths(motion, model, data):
    """MuJoCo's lengths of the tendons at the poses."""
    found = []
    for pose in motion:
        data.qpos[:] = pose
        mujoco.mj_forward(model, data)
        found.append(np.array(data.ten_length))
    return np.array(found)


@pytest.mark.parametrize(
    ("own", "path"),
    some(
        [
            *[("armature", path) for path in ("sites", IN_ONE_TREE)],
            *[("elastic", path) for path in ("sites", IN_ONE_TREE, "a cylinder")],
        ],
        2,
    ),
)
def test_motions_are_mujocos(own, path, tmp_path):
    """Of armature, and of a spring that only pulls, with the fourth-order method of MuJoCo."""
    free, model, data = moved(written(tmp_path, path))
    ((start,),) = lengths(free[:1], model, data)
    keys = {"armature": 'armature="5"', "elastic": f'stiffness="3000" springlength="0 {start}"'}
    motion, model, data = moved(written(tmp_path, path, keys[own]))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 5e-4
    for _ in range(200):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(motion[-1], data.qpos, atol=2e-7)
    assert np.abs(motion[-1] - free[-1]).max() > 1e-3


@pytest.mark.parametrize("path", some(PATHS, 2))
def test_a_limit_holds(path, tmp_path):
    """A tenth of a millimetre from the start, to where the tendon goes."""
    free = lengths(*moved(written(tmp_path, path)))[:, 0]
    end = free[0] + 1e-4 * np.sign(free[-1] - free[0])
    own = f'range="0 {end}"' if end > free[0] else f'range="{end} 9"'
    found = lengths(*moved(written(tmp_path, path, own)))[:, 0]
    assert np.abs(found - free[0]).max() == pytest.approx(1e-4, abs=1e-9)


@pytest.mark.parametrize("path", PATHS)
def test_an_equality_keeps_a_length(path, tmp_path):
    motion, *rest = moved(written(tmp_path, path, more='<equality><tendon tendon1="t"/></equality>'))
    found = lengths(motion, *rest)[:, 0]
    np.testing.assert_allclose(found, found[0], atol=1e-11)
    assert np.ptp(motion[:, 0]) > 1e-3


@pytest.mark.parametrize("path", ["sites", "a pulley", "of joints"])
def test_dry_friction_holds(path, tmp_path):
    """Strong enough that the tendon keeps its length."""
    own, more = 'frictionloss="1e4"', ""
    if path == "of joints":
        more = f'<tendon><fixed name="t" {own}>{JOINTS}</fixed></tendon>'
    file = written(tmp_path, path, own, more=more)
    if more:
        file.write_text(file.read_text().replace(f'<spatial name="t" {own}>of joints</spatial>', ""))
    motion, *rest = moved(file)
    found = lengths(motion, *rest)[:, 0]
    np.testing.assert_allclose(found, found[0], atol=1e-9)
    assert np.ptp(motion[:, 0]) > 1e-3


JOINTS = '<joint joint="turn" coef="0.7"/><joint joint="bend" coef="-0.2"/>'


def test_limit_and_armature_of_a_sum_of_joints(tmp_path):
    """A massless slider follows the sum; its limit is met, and the armature is MuJoCo's."""
    fixed = f'<tendon><fixed name="sum" armature="2" range="-0.003 0.003">{JOINTS}</fixed></tendon>'
    file = written(tmp_path, "sites", more=fixed)
    motion, model, data = moved(file)
    found = lengths(motion, model, data)[:, 1]
    np.testing.assert_allclose(found, motion[:, 0] * 0.7 - motion[:, 1] * 0.2, atol=1e-12)
    assert np.abs(found).max() == pytest.approx(0.003, abs=1e-9)
    free = written(tmp_path, "sites", more=fixed.replace(' range="-0.003 0.003"', ""))
    motion, model, data = moved(free)
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 5e-4
    for _ in range(200):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(motion[-1], data.qpos, atol=2e-7)


@pytest.mark.parametrize("polynomial", ["0.01 0.5 0 0 0", "0.01 0.5 -0.4 0.3 0"])
def test_a_tendon_follows_another_one(polynomial, tmp_path):
    other = f'<tendon><spatial name="other">{PATHS["a pulley"]}</spatial></tendon>'
    rule = f'<equality><tendon tendon1="t" tendon2="other" polycoef="{polynomial}"/></equality>'
    motion, model, data = moved(written(tmp_path, "sites", more=other + rule))
    y, x = (lengths(motion, model, data) - model.tendon_length0).T
    np.testing.assert_allclose(y, np.polynomial.Polynomial(np.fromstring(polynomial, sep=" "))(x), atol=1e-10)
    assert np.ptp(x) > 1e-3


def test_a_path_over_points_lies_in_the_plane_of_the_turns(tmp_path):
    """Where its parts are in the plane of others, too: the scene is planar as the model."""
    path = '<site site="below"/><site site="knee"/><site site="foot"/>'
    file = written(tmp_path, path, 'stiffness="3"')
    text = file.read_text().replace('<site name="post"', '<site name="below" pos="0.1 0.1 -2"/><site name="post"')
    file.write_text(text, encoding="utf-8")
    found = mbproj.import_model(file)
    np.testing.assert_allclose(found.mechanism.joints["t"].keys["normal"], [0, 1, 0], atol=1e-12)
    system = compile_system(found.scene)
    plane = planar_reduction(system, initial_guess(found.scene, system).q)
    assert not isinstance(plane, NotPlanar), plane


OTHERWISE = {
    "it runs inside of 'drum'": '<site site="above"/><geom geom="drum" sidesite="within"/><site site="hip"/>',
    "it runs around 'drum' along a helix, and a rope in a plane": '<site site="off"/><geom geom="drum" '
    'sidesite="above"/><site site="far"/><site site="hook"/>',
    "what it touches moves out of the plane of 'drum', and a rope stays in it": '<site site="post"/><geom geom="drum" '
    'sidesite="above"/><site site="out"/>',
    "it runs over 16 places, and a rope over 14 at most": '<site site="post"/><site site="hip"/>' * 8,
}


@pytest.mark.parametrize("why", OTHERWISE)
def test_what_no_rope_says_is_said_at_its_line(why, tmp_path):
    file = written(tmp_path, OTHERWISE[why], 'stiffness="3"', '<motor name="u" tendon="t"/>')
    out = '<body pos="0.9 0.1 0.4"><joint axis="0 0 1"/><geom size="0.1" contype="0" pos="0 0.1 0"/>'
    text = file.read_text().replace("</worldbody>", f'{out}<site name="out"/></body></worldbody>')
    file.write_text(text, encoding="utf-8")
    said = {row.element: row for row in read_model(file, ImportOptions(controls={})).said}
    assert said["actuator 'u'"].what == f"left out: {why}"
    assert (said["tendon 't'"].what, said["tendon 't'"].same.value) == (f"left out with its spring: {why}", "no")
    assert said["tendon 't'"].place.line == 14


def test_shapes_that_a_tendon_does_not_touch_are_said(tmp_path):
    path = '<site site="post"/><geom geom="drum"/><site site="hip"/>'
    (row,) = [each for each in read_model(written(tmp_path, path, 'stiffness="3"')).said if "tendon" in each.element]
    assert (row.what.partition(":")[0], row.same.value) == ("runs past drum", "until then")


def test_a_slider_whose_sum_has_no_measure_goes_with_it(tmp_path):
    """Weights of three turns that are no whole numbers to each other, so that turns of the row cannot be told."""
    odd = JOINTS.replace("0.7", "0.7390851332151607").replace("0.2", "0.2718281828459045")
    file = written(tmp_path, "sites", more=f'<tendon><fixed name="sum" frictionloss="2">{odd}</fixed></tendon>')
    found = mbproj.import_model(file)
    assert not any("sum" in name for name in (*found.mechanism.parts, *found.mechanism.joints, *found.mechanism.forces))
    (row,) = [each for each in found.mechanism.said if "sum" in each.element]
    assert row.same.value == "no"
