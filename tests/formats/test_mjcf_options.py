"""Flags and options of MJCF act or are named, and a keyframe's velocities are those of MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.mjcf import actuators, compiled, read, source
from mbproj.formats.mjcf.compiled import SWITCHES
from mbproj.formats.read import read_model

# Flags of a model that switch parts of its physics off act, and each other option of MuJoCo's has its row.

mujoco = pytest.importorskip("mujoco")

#: Two bodies in a chain and two carts have all that flags switch off: springs at rest and not, dampers, dry friction,
#: limits, contacts, an equality, compensated gravity; of joints and of a tendon.
MODEL = """<mujoco><compiler autolimits="true"/><option {own}>{flag}</option>
<worldbody><site name="post" pos="0.5 0 0.7"/><geom type="plane" size="2 2 0.1" pos="0 0 -0.9"/>
  <body name="thigh"><joint name="hip" axis="0 1 0" stiffness="6" springref="25" damping="0.2" frictionloss="0.15"
      armature="0.03" range="-15 100"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0.35 0 0" mass="1.2"/>
    <body name="shank" pos="0.35 0 0" gravcomp="0.4">
      <joint name="knee" axis="0 1 0" damping="0.1" stiffness="3"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.6"/><site name="tip" pos="0.3 0 0"/></body></body>
  <body name="cart" pos="0 1 0"><joint name="rail" type="slide" axis="1 0 0" range="-1 1"/><geom size="0.05"/></body>
  <body name="car" pos="0 2 0"><joint name="road" type="slide" axis="1 0 0"/><geom size="0.05"/></body></worldbody>
<tendon><spatial name="cord" stiffness="30" springlength="0.35" damping="1.5" range="0 2" frictionloss="0.1">
  <site site="post"/><site site="tip"/></spatial></tendon>
<equality><joint joint1="rail" joint2="road" polycoef="0 2 0 0 0"/></equality>
<actuator><position name="servo" joint="knee" kp="4" kv="0.3" group="3"/>
  <motor name="pull" joint="road" ctrlrange="-1 1" ctrllimited="true"/></actuator>
<keyframe><key name="begin" qpos="0.1 0 0 0" qvel="0.4 -0.3 0.8 0.4" ctrl="0.2 2.5"/></keyframe></mujoco>"""
#: The flags, and the names of forces and joints that the scene is then without. A spring has its damper in it, and the
#: limit of a tendon has the name of the tendon where there is no spring.
SCENES = {
    "": "",
    "spring": "hip_spring knee_spring",
    "damper": "",
    "spring damper": "hip_spring knee_spring cord_limit shank_compensation",
    "frictionloss": "hip_friction cord_friction cord_line_1",
    "equality": "coupler_1",
    "limit": "cord_limit",
    "contact": "",
    "constraint": "hip_friction cord_friction cord_line_1 coupler_1 cord_limit",
    "gravity": "shank_compensation",
    "clampctrl": "",
    "actuation": "servo pull",
}


def written(folder, flags="", own="", kind="disable"):
    given = " ".join(f'{flag}="{kind}"' for flag in flags.split())
    text = MODEL.format(own=own, flag=f"<flag {given}/>" if given else "")
    (folder / "model.xml").write_text(text, encoding="utf-8")
    return folder / "model.xml"


def imported(path):
    return mbproj.import_model(path, at="begin", hold=True)


@pytest.mark.parametrize("flags", SCENES)
def test_the_scene_is_without_what_a_flag_switches_off(flags, tmp_path):
    """It accelerates as MuJoCo's model does, at the start and beside it, and keeps all other parts."""
    path = written(tmp_path, flags)
    found, whole = imported(path), imported(written(tmp_path))
    assert found.agreement.acceleration_relative < 1e-10
    assert found.same
    parts = [{*each.mechanism.forces, *each.mechanism.joints} for each in (found, whole)]
    assert whole.mechanism.joints["hip"].keys["limits"]
    assert parts[1] - parts[0] == {*SCENES[flags].split()}
    off = flags.split()
    assert ("limits" in found.mechanism.joints["hip"].keys) == (not {*off} & {"limit", "constraint"})
    contacts = [row for row in found.mechanism.said if row.element.startswith("contacts")]
    assert bool(contacts) == (not {*off} & {"contact", "constraint"})
    for flag in off:
        (row,) = [row for row in found.mechanism.said if row.element == f"flag {flag}"]
        assert row.same.value == "yes"
        assert row.what.startswith("acts: ")
        assert str(row.place).endswith("model.xml:1")


@pytest.mark.parametrize("flags", [flags for flags in SCENES if flags not in ("", "limit", "contact")])
def test_a_flag_that_is_dropped_is_seen_beside_mujoco(flags, tmp_path, monkeypatch):
    """Limits and contacts are not compared; everything else is."""
    import copy

    monkeypatch.setattr(compiled, "without_disabled", copy.copy)
    monkeypatch.setattr(actuators, "is_off", lambda *_: "")
    found = imported(written(tmp_path, flags))
    assert not found.same
    assert found.agreement.acceleration_relative > 1e-5
    (row,) = [row for row in found.mechanism.said if row.same.value == "no"]
    assert row.element == "accelerations beside MuJoCo's"
    assert row.what.startswith("differ by up to ")


def test_the_motion_without_springs_is_mujocos(tmp_path):
    """Over 0.2 s, with MuJoCo's Runge-Kutta steps of 0.02 ms."""
    path = written(tmp_path, "spring contact limit frictionloss")
    results = mbproj.run(imported(path).scene, duration=0.2, tolerance=1e-10)
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep, model.opt.integrator = 2e-5, int(mujoco.mjtIntegrator.mjINT_RK4)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)  # soft in MuJoCo, and of other bodies
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(10_000):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    for name in ("thigh", "shank"):
        np.testing.assert_allclose(results.body(name).position[-1], data.body(name).xipos, atol=1e-7)


def test_actuators_of_a_group_that_is_off_exert_nothing(tmp_path, monkeypatch):
    found = imported(written(tmp_path, own='actuatorgroupdisable="3"'))
    said = {row.element: (row.what, row.same.value) for row in found.mechanism.said}
    assert said["actuator 'servo'"] == ("left out: the model turns actuators of group 3 off", "yes")
    assert said["actuator 'pull'"][0].startswith("acts with")
    assert "servo" not in found.mechanism.forces
    assert found.agreement.acceleration_relative < 1e-10
    other = imported(written(tmp_path, own='actuatorgroupdisable="1 2 4"'))
    assert "servo" in other.mechanism.forces
    assert other.agreement.acceleration_relative < 1e-10
    monkeypatch.setattr(actuators, "is_off", lambda *_: "")
    assert not imported(written(tmp_path, own='actuatorgroupdisable="3"')).same


def test_passive_of_older_models_is_both_of_its_parts(tmp_path):
    """Older versions of MuJoCo have this flag for springs and dampers, and newer ones refuse it."""
    path = written(tmp_path, "passive")
    assert (
        imported(path).text.partition("bodies:")[2]
        == imported(written(tmp_path, "spring damper")).text.partition("bodies:")[2]
    )


COMPENSATED = """<mujoco><option>{}</option><worldbody><body name="a" gravcomp="1"><joint name="j" axis="0 1 0"
  actuatorgravcomp="true"/><geom size="0.1" pos="0.3 0 0"/>{}</body></worldbody>{}</mujoco>"""
MOTOR = '<actuator><motor joint="j"/></actuator>'
INNER = '<body name="b" pos="0.4 0 0" gravcomp="1"><joint axis="0 1 0"/><geom size="0.1" pos="0.3 0 0"/></body>'


@pytest.mark.parametrize(
    ("flag", "inner", "motor", "kept", "same"),
    [
        ("", "", MOTOR, True, True),
        ('<flag actuation="disable"/>', "", MOTOR, False, True),
        ("", "", "", False, True),
        ('<flag actuation="disable"/>', INNER, MOTOR, True, False),
    ],
)
def test_gravity_that_actuators_compensate_needs_one(flag, inner, motor, kept, same, tmp_path):
    """Where only some joints have such compensation, a force on the body cannot tell, and a row says so."""
    (tmp_path / "model.xml").write_text(COMPENSATED.format(flag, inner, motor), encoding="utf-8")
    found = mbproj.import_model(tmp_path / "model.xml", hold=True)
    assert ("a_compensation" in found.mechanism.forces) == kept
    assert found.same == same
    assert (found.agreement.acceleration_relative < 1e-10) == same


#: Values of options that are not MuJoCo's own.
VALUES = {
    "timestep": "0.004", "impratio": "3", "tolerance": "1e-6", "ls_tolerance": "0.1", "noslip_tolerance": "1e-3",
    "ccd_tolerance": "1e-3", "sleep_tolerance": "0.1", "gravity": "0 0 -3", "wind": "1 0 0", "magnetic": "1 0 0",
    "density": "1.2", "viscosity": "0.1", "o_margin": "0.1", "o_solref": "0.1 1", "o_solimp": "0.8 0.9 0.01 0.5 2",
    "o_friction": "0.5 0.5 0.01 0.01 0.01", "integrator": "RK4", "cone": "elliptic", "jacobian": "dense",
    "solver": "CG", "iterations": "7", "ls_iterations": "7", "noslip_iterations": "7", "ccd_iterations": "7",
    "sdf_initpoints": "7", "sdf_iterations": "7", "actuatorgroupdisable": "3",
}  # fmt: skip
#: The rows of those that act, or that have a row of their own.
OWN = {"gravity": "", "actuatorgroupdisable": "actuator 'servo'", "sleep_tolerance": "", "density": "medium"} | {
    "viscosity": "medium",
    "wind": "option wind",
}


def test_the_list_of_options_is_mujocos():
    names = {name for name in dir(mujoco.MjOption()) if not name.startswith("_")}
    names -= {"disableflags", "enableflags", "disableactuator"}
    assert names <= VALUES.keys()
    assert names <= {*read.OTHERS, *read.ELSEWHERE}


@pytest.mark.parametrize("name", VALUES)
def test_each_option_acts_or_has_a_row(name, tmp_path):
    found = read_model(written(tmp_path, own=f'{name}="{VALUES[name]}"'), ImportOptions())
    rows = [row for row in found.said if name in row.element.replace(",", " ").split()]
    if name == "gravity":
        np.testing.assert_array_equal(found.gravity, [0.0, 0.0, -3.0])
    elif name in OWN:
        assert not OWN[name] or [row for row in found.said if row.element.startswith(OWN[name])]
    else:
        (row,) = rows
        assert row.what.startswith("left out")


def flags_of(kind, beginning):
    return [name.removeprefix(beginning) for name in kind.__members__ if name.startswith(beginning)]


@pytest.mark.parametrize("name", flags_of(mujoco.mjtDisableBit, "mjDSBL_"))
def test_each_flag_that_disables_acts_or_has_a_row(name, tmp_path):
    said = read_model(written(tmp_path, name.lower()), ImportOptions()).said
    (row,) = [row for row in said if f"flag {name.lower()}" in row.element]
    assert row.what.startswith("acts" if name in SWITCHES else "left out")


@pytest.mark.parametrize("name", flags_of(mujoco.mjtEnableBit, "mjENBL_"))
def test_each_flag_that_enables_has_a_row(name, tmp_path):
    own = 'integrator="discrete"' if name == "IPC" else ""  # which MuJoCo asks for
    said = read_model(written(tmp_path, name.lower(), own, kind="enable"), ImportOptions()).said
    (row,) = [row for row in said if f"flag {name.lower()}" in row.element]
    assert row.what.startswith("left out")
    assert row.same.value == ("yes" if read.OTHERS.get(name) in (read.SOLVER, read.SENSORS) else "until then")


def test_sleep_has_a_row_with_its_tolerance(tmp_path):
    said = read_model(written(tmp_path, "sleep", 'sleep_tolerance="0.1"', kind="enable"), ImportOptions()).said
    assert [row.same.value for row in said if "sleep" in row.element] == ["until then"]
    assert not [row for row in said if "does not know" in row.what]


def test_an_option_that_mbproj_does_not_know_may_move_the_model_otherwise(tmp_path, monkeypatch):
    """As one of a later version of MuJoCo would."""
    path = written(tmp_path, "warmstart", 'impratio="3"')
    monkeypatch.setattr(read, "OTHERS", {})
    (row,) = [row for row in read_model(path, ImportOptions()).said if row.element.startswith("options")]
    assert (row.element, row.same.value) == ("options flag warmstart, impratio", "no")


def test_a_medium_is_left_out_unless_flags_turn_it_off(tmp_path):
    """Without springs and dampers MuJoCo computes no passive forces at all."""
    for flags, expected in (("", ["medium with density or viscosity"]), ("spring damper", [])):
        found = imported(written(tmp_path, flags, 'density="900"'))
        left = [row.element for row in found.mechanism.said if row.same.value == "no"]
        assert [each for each in left if "beside" not in each] == expected
        assert found.same == (not expected)


def test_springs_that_yield_and_those_of_free_bodies_are_said(tmp_path):
    free = '<body name="f" pos="0 0 1"><joint type="free" stiffness="4"/><geom size="0.1"/></body>'
    (tmp_path / "free.xml").write_text(f"<mujoco><worldbody>{free}</worldbody></mujoco>", encoding="utf-8")
    found = mbproj.import_model(tmp_path / "free.xml")
    left = [row.element for row in found.mechanism.said if row.same.value == "no"]
    assert left == ["spring of the free body 'f'", "accelerations beside MuJoCo's"]
    if not hasattr(mujoco.MjModel.from_xml_string("<mujoco/>"), "jnt_springyield"):
        return
    text = MODEL.format(own="", flag="").replace('stiffness="3"', 'stiffness="3" springyield="0.2"')
    (tmp_path / "yields.xml").write_text(text, encoding="utf-8")
    (row,) = [each for each in read_model(tmp_path / "yields.xml").said if "springyield" in each.element]
    assert (row.element, row.same.value) == ("springyield of joint 'knee'", "until then")


def test_pairs_of_shapes_and_those_that_touch_at_the_start_are_said(tmp_path):
    """A ball that rests on the floor moves otherwise from the start on, unless a stop holds it."""
    ball = '<body name="b" pos="0 0 {}"><freejoint/><geom name="g" size="0.1" {}/></body>'
    floor = '<geom name="floor" type="plane" size="1 1 1" {}/>'
    off = 'contype="0" conaffinity="0"'
    pair = '<contact><pair geom1="g" geom2="floor"/></contact>'
    for height, own, more, expected in (
        ("0.2", "", "", ["until then"]),
        ("0.0999", "", "", ["until then", "no"]),
        ("0.2", off, "", []),
        ("0.2", off, pair, ["until then"]),
        ("0.0999", off, pair, ["until then", "no"]),
    ):
        world = f"<worldbody>{floor.format(own)}{ball.format(height, own)}</worldbody>"
        (tmp_path / "model.xml").write_text(f"<mujoco>{world}{more}</mujoco>", encoding="utf-8")
        said = read_model(tmp_path / "model.xml", ImportOptions()).said
        assert [row.same.value for row in said if row.element.startswith("contacts")] == expected
    path = tmp_path / "model.xml"
    path.write_text(path.read_text().replace(off, "").replace(pair, ""), encoding="utf-8")
    said = read_model(path, ImportOptions(contacts=True)).said
    assert [row.same.value for row in said if row.element.startswith("contacts")] == ["until then"]
    # A sphere stands for a mesh whose file is missing: whether that touches the floor, nobody knows.
    mesh = path.read_text().replace(
        '<geom name="g" size="0.1"',
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom name="g" type="mesh" mesh="gone"',
    )
    path.write_text(mesh.replace("<worldbody>", '<asset><mesh name="gone" file="gone.stl"/></asset><worldbody>'))
    path.write_text(path.read_text().replace('pos="0 0 0.0999"', 'pos="0 0 0.001"'), encoding="utf-8")
    said = read_model(path, ImportOptions()).said
    assert [row.same.value for row in said if row.element.startswith("contacts")] == ["until then"]


def test_the_source_keeps_what_a_new_flag_says(tmp_path):
    """An explicit `spring` stands above an old `passive` beside it."""
    flag = '<flag passive="disable" spring="enable"/>'
    (tmp_path / "model.xml").write_text(MODEL.format(own="", flag=flag), encoding="utf-8")
    elements = source.source_of(_root(tmp_path / "model.xml"), tmp_path / "model.xml").root.all("option")
    assert elements[0].all("flag")[0].attributes == {"spring": "enable", "damper": "disable"}


def _root(path):
    from mbproj.formats.xml import parse

    return parse(path.read_bytes(), str(path))


# Velocities of a keyframe: each body begins with that of its centre of mass, which lies off its frame.

MASS = '<inertial pos="{}" mass="{}" diaginertia="0.02 0.03 0.04" euler="20 10 -30"/>'
#: A chain of all kinds of joints, each with its centre of mass off its frame.
CHAIN = f"""<mujoco><worldbody>
  <body name="base" pos="0.2 0.1 0.5" euler="10 -20 30"><freejoint/>{MASS.format("0.11 -0.05 0.07", 2.0)}
    <body name="upper" pos="0.3 0 0.1" euler="0 40 0"><joint type="hinge" axis="0.3 1 0.2" pos="0.02 0 0.05"/>
      {MASS.format("-0.2 0.15 0.04", 1.2)}
      <body name="lower" pos="0 0.4 0"><joint type="ball" pos="0 0.03 0.01"/>{MASS.format("0.1 0.1 -0.3", 0.7)}
        <body name="welded" pos="0 0 -0.2" euler="30 0 10">{MASS.format("0.05 0.02 0.09", 0.3)}</body>
        <body name="tip" pos="0.1 0 -0.5"><joint type="slide" axis="0 0.6 0.8"/><joint type="hinge" axis="1 0.2 0"/>
          {MASS.format("0.06 -0.1 0.02", 0.4)}</body></body></body></body>
</worldbody><keyframe><key name="moving" qpos="{{}}" qvel="{{}}"/></keyframe></mujoco>"""
HINGE = f"""<mujoco><worldbody>
  <body name="arm"><joint name="pivot" axis="0 1 0"/>{MASS.format("0.2 0 -0.4", 3.0)}</body>
</worldbody><keyframe><key name="moving" qpos="{{}}" qvel="{{}}"/></keyframe></mujoco>"""


def moving(text, folder, seed):
    """A model with a random keyframe of unit quaternions, and MuJoCo's model of it."""
    random = np.random.default_rng(seed)
    still = mujoco.MjModel.from_xml_string(text.split("<keyframe>")[0] + "</mujoco>")
    qpos, qvel = still.qpos0.copy(), random.normal(size=still.nv)
    mujoco.mj_integratePos(still, qpos, random.uniform(-0.6, 0.6, size=still.nv), 1.0)
    numbers = [" ".join(map(repr, each.tolist())) for each in (qpos, qvel)]
    (folder / "model.xml").write_text(text.format(*numbers), encoding="utf-8")
    return folder / "model.xml", mujoco.MjModel.from_xml_path(str(folder / "model.xml"))


def differenced(model, number, h=1e-6):
    """The velocity of a centre of mass, and ω in the axes of its body, from MuJoCo's poses at ±h."""
    data, poses = mujoco.MjData(model), []
    for sign in (1.0, -1.0):
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_integratePos(model, data.qpos, data.qvel, sign * h)
        mujoco.mj_kinematics(model, data)
        poses.append((data.xipos[number].copy(), data.xmat[number].reshape(3, 3).copy()))
    (after, ahead), (before, behind) = poses
    turn = 0.5 * (ahead + behind).T @ (ahead - behind) / (2.0 * h)
    return (after - before) / (2.0 * h), np.array([turn[2, 1], turn[0, 2], turn[1, 0]])


@pytest.mark.parametrize("text", [HINGE, CHAIN], ids=["hinge", "chain"])
@pytest.mark.parametrize("seed", [1, 2])
def test_bodies_begin_with_the_velocities_of_their_centres_of_mass(text, seed, tmp_path):
    path, model = moving(text, tmp_path, seed)
    parts = read_model(path, ImportOptions("moving")).parts
    for number in range(1, model.nbody):
        velocity, omega = differenced(model, number)
        part = parts[model.body(number).name]
        np.testing.assert_allclose(part.velocity, velocity, atol=1e-7)
        np.testing.assert_allclose(part.angular_velocity, omega, atol=1e-7)


@pytest.mark.parametrize("text", [HINGE, CHAIN], ids=["hinge", "chain"])
def test_assembly_changes_none_of_them(text, tmp_path):
    """They are those that the joints allow: the scene's start has them, and accelerates as MuJoCo's does."""
    found = mbproj.import_model(moving(text, tmp_path, 3)[0], at="moving")
    assert found.same
    assert found.agreement.velocity < 1e-13
    assert found.agreement.angular_velocity < 1e-13
    assert found.agreement.acceleration_relative < 1e-12


def test_a_turning_bar_keeps_its_rate(tmp_path):
    """A bar of 2 kg whose centre of mass is 0.25 m from a vertical hinge turns at 1.5 rad/s, and nothing changes that:
    its centre has 0.375 m/s."""
    inertial = '<inertial pos="0.25 0 0" mass="2" diaginertia="0.01 0.02 0.02"/>'
    (tmp_path / "bar.xml").write_text(
        f'<mujoco><worldbody><body name="bar"><joint axis="0 0 1"/>{inertial}</body></worldbody>'
        '<keyframe><key name="k" qvel="1.5"/></keyframe></mujoco>'
    )
    results = mbproj.run(mbproj.import_model(tmp_path / "bar.xml", at="k").scene, duration=0.2)
    np.testing.assert_allclose(np.linalg.norm(results.body("bar").velocity, axis=1), 0.375, rtol=1e-9)


TENDONS = """<mujoco><worldbody><site name="post" pos="0 0 1.2"/>
  <body name="arm"><joint name="turn" type="ball" pos="0 0.05 0"/>{}<site name="hand" pos="0.4 0.1 0"/>
    <body name="slider" pos="0.3 0 0"><joint name="slide" type="slide" axis="1 0.2 0"/>{}
      <joint name="spin" axis="0 1 0"/><site name="end" pos="0 0.2 0.1"/></body></body></worldbody>
<tendon><spatial name="path" frictionloss="0.7" armature="0.3"><site site="post"/><site site="hand"/><site site="end"/>
  </spatial><fixed name="sum" frictionloss="0.2"><joint joint="slide" coef="2"/><joint joint="spin" coef="0.5"/></fixed>
</tendon><keyframe><key name="moving" qvel="0.3 -0.8 0.6 0.5 -0.9"/></keyframe></mujoco>""".format(
    MASS.format("0.2 0.1 0", 1.0), MASS.format("0.1 -0.05 0.2", 0.6)
)


def test_what_measures_a_tendon_begins_with_its_rate(tmp_path):
    """A massless slider follows the length of a tendon with dry friction. If it began at rest, assembly would share the
    difference with the bodies."""
    (tmp_path / "model.xml").write_text(TENDONS, encoding="utf-8")
    found = mbproj.import_model(tmp_path / "model.xml", at="moving")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    for number, name in enumerate(("path", "sum")):
        speed = np.linalg.norm(found.mechanism.parts[f"{name}_slider"].velocity)
        assert speed == pytest.approx(abs(data.ten_velocity[number]), rel=1e-12)
    assert found.agreement.velocity < 1e-13
    assert found.agreement.acceleration_relative < 1e-10
