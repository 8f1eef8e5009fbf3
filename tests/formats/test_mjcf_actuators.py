"""Actuators of MJCF, with states and without: forces and motions as MuJoCo's own, and what has no counterpart."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.base.errors import InputError
from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.formats.signals import signals_of
from mbproj.scene.scene import read_scene_text
from tests.cli.commands import mbproj as command
from tests.crossed import once, some
from tests.formats.agreement import agreement

# Actuators and motions on request: forces as MuJoCo's own, signals of time, and what has no counterpart is said.

mujoco = pytest.importorskip("mujoco")

MODEL = """<mujoco><compiler angle="radian"/>
<worldbody>
  <site name="post" pos="0 0 1"/>
  <body name="arm" pos="0.1 0 0" euler="0.1 0.2 0.3"><joint name="turn" axis="0 1 0.2"/>
    <geom type="box" size="0.1 0.05 0.3" pos="0 0 -0.3"/><site name="eye" pos="0.1 0 -0.4" euler="0.4 0 0.2"/>
    <body name="cart" pos="0 0 -0.6"><joint name="slide" type="slide" axis="1 0 0.3"/>
      <geom size="0.1" pos="0 0.1 0"/></body></body>
  <body name="ship" pos="2 0 0" euler="0.3 0.1 0"><freejoint name="loose"/><geom type="box" size="0.2 0.1 0.05"
      pos="0.05 0 0"/></body>
</worldbody>
<tendon><fixed name="both"><joint joint="turn" coef="0.7"/><joint joint="slide" coef="-2"/></fixed>
  <fixed name="one"><joint joint="slide" coef="-2"/></fixed>
  <spatial name="line"><site site="post"/><site site="eye"/></spatial></tendon>
<actuator>{}</actuator>
<keyframe><key name="home" qpos="0.3 -0.2 2 0 0 1 0 0 0" ctrl="{}"/></keyframe></mujoco>"""

ACTING = {
    "motor": '<motor name="u" joint="turn" gear="2.5"/>',
    "position": '<position name="u" joint="turn" kp="30" kv="2" gear="0.5"/>',
    "position of a slide": '<position name="u" joint="slide" kp="30" ctrlrange="-0.1 0.2"/>',
    "velocity": '<velocity name="u" joint="slide" kv="4" gear="-1.5"/>',
    "damper": '<damper name="u" joint="turn" kv="2" ctrlrange="0 1"/>',
    "affine": '<general name="u" joint="turn" gaintype="affine" gainprm="2 0.3 -0.4" biastype="affine"'
    ' biasprm="1 0.5 -0.2" gear="1.3"/>',
    "limited force": '<position name="u" joint="turn" kp="30" kv="2" gear="-0.5" forcerange="-3 2"/>',
    "constant push": '<general name="u" joint="turn" biastype="affine" biasprm="2 0 0"/>',
    "motor of two joints": '<motor name="u" tendon="both" gear="1.5"/>',
    "servo of two joints": '<position name="u" tendon="both" kp="3" kv="0.4" gear="1.5"/>',
    "affine, of two joints, limited": '<general name="u" tendon="both" gaintype="affine" gainprm="2 0.3 -0.4"'
    ' biastype="affine" biasprm="1 0.5 -0.2" forcerange="-2 2"/>',
    "servo of a tendon": '<position name="u" tendon="one" kp="3" kv="0.4"/>',
    "servo of a line": '<position name="u" tendon="line" kp="3" kv="0.4"/>',
    "motor of a line": '<motor name="u" tendon="line" gear="-2"/>',
    "thruster": '<motor name="u" site="eye" gear="1 -2 3 0.4 0.5 -0.6"/>',
    "free body": '<motor name="u" joint="loose" gear="1 -2 3 0.4 0.5 -0.6"/>',
}


def written(folder, actuator, ctrl="0.4"):
    (folder / "model.xml").write_text(MODEL.format(actuator, ctrl), encoding="utf-8")
    return folder / "model.xml"


@pytest.mark.parametrize(("name", "signal"), once([*ACTING], ["0.4", "0.4 * cos(3*t)"]))
def test_forces_are_mujocos(name, signal, tmp_path):
    path = written(tmp_path, ACTING[name])
    options = ImportOptions(controls=signals_of({"u": signal}, "controls"))
    (row,) = [each for each in read_model(path, options).said if each.element == "actuator 'u'"]
    assert row.same.value == "yes"
    assert max(agreement(path, options=options, ctrl=[0.4])) < 1e-12
    other = ImportOptions(controls=signals_of({"u": "-0.35"}, "controls"))
    assert max(agreement(path, options=other, ctrl=[0.4])) > 1e-6


@pytest.mark.skipif(not hasattr(mujoco.mjtGain, "mjGAIN_DCMOTOR"), reason="this MuJoCo has no DC motors")
def test_a_dc_motor_is_its_constant_over_its_resistance(tmp_path):
    path = written(tmp_path, '<dcmotor name="u" joint="turn" motorconst="0.5" resistance="2" gear="3"/>')
    options = ImportOptions(controls=signals_of({"u": 24}, "controls"))
    assert max(agreement(path, options=options, ctrl=[24.0])) < 1e-12


@pytest.mark.skipif(not hasattr(mujoco.mjtTrn, "mjTRN_SO3"), reason="this MuJoCo has no servos of orientations")
def test_actuators_behind_one_with_several_forces_keep_their_numbers(tmp_path):
    """MuJoCo orders gears, and ranges of lengths, by forces, and an `orientation` has three."""
    text = """<mujoco><worldbody><body name="a"><joint name="ball" type="ball"/><geom size="0.1" pos="0.1 0 0"/>
      <body name="b" pos="0.5 0 0"><joint name="turn" axis="0 1 0"/><geom size="0.1" pos="0.2 0 0.1"/></body>
      </body></worldbody><actuator><orientation name="o" joint="ball" kp="2"/>
      <motor name="m" joint="turn" gear="3.5" forcelimited="true" forcerange="-0.4 0.6"/>
      <muscle name="u" joint="turn" force="30" lengthrange="-2 3"/></actuator></mujoco>"""
    (tmp_path / "model.xml").write_text(text, encoding="utf-8")
    found = mbproj.import_model(tmp_path / "model.xml", controls={"m": 0.5, "u": 0.7})
    said = {row.element: row.same.value for row in found.mechanism.said}
    assert [said[f"actuator '{name}'"] for name in "omu"] == ["no", "yes", "yes"]
    assert found.mechanism.forces["m"]["torque"] == "min(max(3.5*0.5, -1.4), 2.1)"
    off = text.replace('kp="2"', 'kp="0"')
    (tmp_path / "model.xml").write_text(off, encoding="utf-8")
    beside = mbproj.import_model(tmp_path / "model.xml", controls={"m": 0.5, "u": 0.7}).agreement
    assert beside.acceleration_relative < 1e-12


@pytest.mark.parametrize(
    ("own", "expected"),
    [
        ('dyntype="integrator"', lambda t: 0.4 * t),
        ('dyntype="filter" dynprm="0.5"', lambda t: 0.4 * (1 - np.exp(-t / 0.5))),
        ('dyntype="filterexact" dynprm="0.5"', lambda t: 0.4 * (1 - np.exp(-t / 0.5))),
    ],
)
def test_a_constant_signal_goes_through_a_filter_in_closed_form(own, expected, tmp_path):
    """A force of so many N on 3 kg that nothing else accelerates: the second integral of the signal."""
    text = (
        '<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="x" type="slide" axis="1 0 0"/>'
        f'<geom size="0.1" mass="3"/></body></worldbody><actuator><general name="u" joint="x" {own}/></actuator>'
        "</mujoco>"
    )
    (tmp_path / "m.xml").write_text(text, encoding="utf-8")
    found = mbproj.import_model(tmp_path / "m.xml", controls={"u": 0.4})
    results = mbproj.run(found.scene, duration=1.0, tolerance=1e-12)
    times = np.linspace(0.0, 1.0, 20001)
    speed = np.concatenate([[0.0], np.cumsum(0.5 * (expected(times)[1:] + expected(times)[:-1]) * np.diff(times))]) / 3
    assert results.body("body_1").velocity[-1][0] == pytest.approx(speed[-1], rel=1e-8)


def test_without_a_request_what_acts_is_left_out_and_said(tmp_path):
    """A servo moves the model, and so does a signal of the keyframe; a motor without one does not."""
    path = written(tmp_path, ACTING["motor"] + ACTING["position"].replace('"u"', '"p"'), "0.4 0")
    said = {
        key: {row.element: row.same.value for row in read_model(path, ImportOptions(key)).said}
        for key in (None, "home")
    }
    assert [said[key]["actuator 'u'"] for key in (None, "home")] == ["until then", "no"]
    assert [said[key]["actuator 'p'"] for key in (None, "home")] == ["no", "no"]
    assert not read_model(path, ImportOptions("home")).forces


def test_a_servo_that_holds_is_a_spring_to_its_control_signal(tmp_path):
    """kp (ctrl - q) - kv q' with ctrl = 0.4 at q = 0.3: free 0.1 rad ahead of the start."""
    path = written(tmp_path, '<position name="p" joint="turn" kp="3" kv="0.5"/>')
    forces = read_model(path, ImportOptions("home", controls={})).forces
    assert list(forces) == ["p"]
    assert (forces["p"]["stiffness"].value, forces["p"]["damping"].value) == (3.0, 0.5)
    assert forces["p"]["free_angle"].value == pytest.approx(0.1)


@pytest.mark.parametrize(
    "actuator",
    [
        '<adhesion name="u" body="arm" gain="3" ctrlrange="0 1"/>',
        '<position name="u" site="eye" refsite="post" kp="3"/>',
    ],
)
def test_what_has_no_counterpart_is_said_at_its_line(actuator, tmp_path):
    path = written(tmp_path, f"\n{actuator}")
    mechanism = read_model(path, ImportOptions(controls={}))
    (row,) = [each for each in mechanism.said if each.element == "actuator 'u'"]
    assert (row.same.value, row.place.line) == ("no", 15)
    assert row.what.startswith("left out: ")
    assert not mechanism.forces


def test_joints_are_driven_by_functions_of_time(tmp_path):
    """The model's coordinate, which is 0.3 rad at the start of the keyframe."""
    path = written(tmp_path, ACTING["motor"])
    found = mbproj.import_model(path, at="home", motions={"turn": "0.3 + 0.1*sin(2*t)", "slide": "-0.2"})
    results = mbproj.run(found.scene, duration=0.5)
    angle = results.coordinate("turn.angle").value
    np.testing.assert_allclose(angle, 0.1 * np.sin(2 * results.time), atol=1e-12)


WRONG = {
    "controls": [("v: 1", "'v' is no actuator of the model; choose from: u"), ("u: x + 1", "'u': unknown name 'x'")],
    "motions": [
        ("torn: 1", "'torn' is no joint of the model with a coordinate; did you mean 'turn'?"),
        ("turn: 2 *", "'turn': the expression ends"),
    ],
}


@pytest.mark.parametrize(("option", "text", "said"), [(key, *each) for key, rows in WRONG.items() for each in rows])
def test_a_wrong_signal_is_said_at_its_line(option, text, said, tmp_path):
    written(tmp_path, ACTING["motor"])
    (tmp_path / "given.yaml").write_text(f"# of mine\n{text}\n", encoding="utf-8")
    done = command("import", "model.xml", f"--{option}", "given.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert "given.yaml:2:" in done.stderr
    assert said in done.stderr


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("m.urdf", ImportOptions("home"), "a model in URDF has no keyframes"),
        ("m.urdf", ImportOptions(controls={}), "a model in URDF has no actuators"),
        ("m.sdf", ImportOptions(contacts=True), "a model in SDF has no contacts"),
        ("m.urdf", ImportOptions(meet=True), "a model in URDF has no frames of joints that may meet"),
    ],
)
def test_an_option_of_another_format_is_refused(name, options, said, tmp_path):
    root = {"urdf": "robot", "sdf": "sdf"}[name.partition(".")[2]]
    (tmp_path / name).write_text(f"<{root}/>", encoding="utf-8")
    with pytest.raises(InputError, match=said):
        read_model(tmp_path / name, options)


def test_the_scene_with_signals_reads_as_written(tmp_path):
    folder = tmp_path / "a_folder_with_a_long_name"
    folder.mkdir()
    path = written(folder, ACTING["limited force"])
    text = scene_text(read_model(path, ImportOptions(controls=signals_of({"u": "sin(t)"}, "controls"))), "1")
    assert [line for line in text.splitlines() if len(line) > 100 and str(tmp_path) not in line] == []
    assert text.splitlines()[:2] == ["# Imported by mbproj 1 from MJCF,", f"#   {path}"]
    assert [force.name for force in read_scene_text(text).forces] == ["u"]


def test_a_servo_of_two_joints_runs_and_its_force_is_a_signal(tmp_path):
    """kp (u - L) - kv L' of the length 0.7 turn - 2 slide, at all samples; its results can be read."""
    path = written(tmp_path, '<position name="u" tendon="both" kp="3" kv="0.4"/>')
    results = mbproj.run(mbproj.import_model(path, controls={"u": 0.4}).scene, duration=0.2)
    turn, slide = (results.coordinate(name) for name in ("turn.angle", "slide.displacement"))
    length, rate = 0.7 * turn.value - 2.0 * slide.value, 0.7 * turn.speed - 2.0 * slide.speed
    np.testing.assert_allclose(results["signals/value"][:, 0], 3.0 * (0.4 - length) - 0.4 * rate, atol=1e-12)


# Actuators with states: forces and motions as MuJoCo's own, of servos, filters, PID controllers and muscles.

MODEL_WITH_STATES = """<mujoco><compiler angle="radian"/><option timestep="{step}" integrator="RK4"/>{plugin}
<worldbody><site name="post" pos="0 0 1"/>
  <body name="arm" pos="0.1 0 0" euler="0.1 0.2 0.3"><joint name="turn" axis="0 1 0.2"/>
    <geom type="box" size="0.1 0.05 0.3" pos="0 0 -0.3" contype="0"/><site name="eye" pos="0.1 0 -0.4"/>
    <body name="cart" pos="0 0 -0.6"><joint name="slide" type="slide" axis="1 0 0.3"/>
      <geom size="0.1" pos="0 0.1 0" contype="0"/></body></body></worldbody>
<tendon><fixed name="both"><joint joint="turn" coef="0.7"/><joint joint="slide" coef="-2"/></fixed>
  <spatial name="line"><site site="post"/><site site="eye"/></spatial></tendon>
<actuator>{actuator}</actuator>
<keyframe><key name="home" qpos="0.3 -0.2" {key}/></keyframe></mujoco>"""
PLUGIN = '<extension><plugin plugin="mujoco.pid"/></extension>'


def numbers(**given):
    return "".join(f'<config key="{key}" value="{value}"/>' for key, value in given.items())


#: The actuator, its activations at the start.
WITH_STATES = {
    "integrator": ('<general name="u" joint="turn" dyntype="integrator" gainprm="5"/>', "0.2"),
    "filter": ('<general name="u" joint="slide" dyntype="filter" dynprm="0.3" gainprm="5" gear="-2"/>', "0.2"),
    "exact filter": ('<position name="u" joint="turn" kp="30" kv="2" timeconst="0.2"/>', "0.2"),
    "integrated velocity": ('<intvelocity name="u" joint="turn" kp="30" kv="2" actrange="-0.1 0.25"/>', "0.2"),
    "of two joints": ('<intvelocity name="u" tendon="both" kp="30" kv="2" actrange="-1 1"/>', "0.2"),
    "of a line": ('<position name="u" tendon="line" kp="30" kv="2" timeconst="0.2"/>', "0.2"),
    "limited force": ('<position name="u" joint="turn" kp="30" timeconst="0.2" forcerange="-1 2"/>', "0.2"),
    "thruster": ('<general name="u" site="eye" gear="1 2 0 0 0 3" dyntype="filter" dynprm="0.3"/>', "0.2"),
    "plugin": (
        f'<plugin name="u" joint="turn" plugin="mujoco.pid" actdim="1">{numbers(kp=30, ki=8, kd=3)}</plugin>',
        "0.2",
    ),
    "plugin with limits": (
        '<plugin name="u" joint="slide" gear="-2" plugin="mujoco.pid" actdim="1" ctrlrange="-0.5 0.3"'
        f' forcerange="-50 60">{numbers(kp=30, ki=8, kd=3, imax=2)}</plugin>',
        "0.2",
    ),
    "plugin behind a filter": (
        '<plugin name="u" joint="turn" plugin="mujoco.pid" actdim="2" dyntype="filter" dynprm="0.3">'
        f"{numbers(kp=30, ki=8, kd=3)}</plugin>",
        "0.1 0.2",
    ),
    "muscle": ('<muscle name="u" joint="turn" force="40" lengthrange="-2 3"/>', "0.2"),
    "muscle that is smoothed": ('<muscle name="u" joint="turn" scale="20" tausmooth="0.5" lengthrange="-2 3"/>', "0.6"),
    "muscle of two joints": ('<muscle name="u" tendon="both" force="40" range="0.6 1.2" lengthrange="-3 3"/>', "0.2"),
    "muscle of a line": ('<muscle name="u" tendon="line" force="40" lengthrange="0.8 1.8"/>', "0.2"),
}
if hasattr(mujoco.mjtGain, "mjGAIN_PID"):
    WITH_STATES |= {
        "pid": ('<pid name="u" joint="turn" kp="30" ki="8" kv="3" input="pos"/>', "0.2"),
        "pid with limits": ('<pid name="u" joint="slide" kp="30" ki="8" imax="0.25" input="pos" gear="-2"/>', "0.2"),
        "pid of two joints": ('<pid name="u" tendon="both" kp="30" ki="8" kv="3" input="pos"/>', "0.2"),
        "pid that is slow": ('<pid name="u" joint="turn" kp="30" kv="3" slewmax="0.3" input="pos"/>', "0.2"),
    }


def written_with_state(folder, name, ctrl=0.4, step=1e-3):
    actuator, act = WITH_STATES[name]
    key = f'ctrl="{ctrl}" act="{act}"'
    plugin = PLUGIN if "plugin" in name else ""
    text = MODEL_WITH_STATES.format(plugin=plugin, actuator=actuator, key=key, step=step)
    (folder / "model.xml").write_text(text, encoding="utf-8")
    return folder / "model.xml", [float(each) for each in act.split()]


@pytest.mark.parametrize(("name", "signal"), once([*WITH_STATES], ["0.4", "0.4 * cos(3*t)"]))
def test_forces_with_states_are_mujocos(name, signal, tmp_path):
    """With a short step, by which MuJoCo's integrals and setpoints are ahead."""
    path, act = written_with_state(tmp_path, name, step=1e-12)
    options = ImportOptions("home", controls=signals_of({"u": signal}, "controls"))
    (row,) = [each for each in read_model(path, options).said if each.element == "actuator 'u'"]
    assert row.same.value == "yes"
    assert max(agreement(path, options=options, ctrl=[0.4], act=act)) < 1e-12
    assert max(agreement(path, options=options, ctrl=[0.4], act=[each + 0.1 for each in act])) > 1e-6


@pytest.mark.parametrize(
    "name", some(["integrated velocity", "plugin with limits", "muscle", *list(WITH_STATES)[15:]], 2)
)
def test_motions_are_mujocos(name, tmp_path):
    """Half a second, against MuJoCo's fourth-order method with two steps; its activations are of the first order."""
    ends = []
    for step in (2e-4, 1e-4):
        path, _ = written_with_state(tmp_path, name, step=step)
        model = mujoco.MjModel.from_xml_path(str(path))
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        while data.time < 0.5 - 0.5 * step:
            data.ctrl[:] = 0.4 * np.cos(3 * data.time)
            mujoco.mj_step(model, data)
        ends.append(np.array(data.qpos))
    found = mbproj.import_model(path, at="home", controls={"u": "0.4*cos(3*t)"})
    results = mbproj.run(found.scene, duration=0.5, tolerance=1e-9)
    end = [results.coordinate("turn.angle").value[-1] + 0.3, results.coordinate("slide.displacement").value[-1] - 0.2]
    np.testing.assert_allclose(end, 2 * ends[1] - ends[0], atol=1e-5)


SPRINGS = {
    "spring": 'stiffness="30" springlength="0.2"',
    "spring as it is drawn": 'stiffness="30"',
    "damper": 'damping="4"',
    "slack": 'stiffness="30" damping="4" springlength="0.1 0.4"',
}
if hasattr(mujoco.MjModel, "tendon_stiffnesspoly"):
    SPRINGS["powers"] = 'stiffness="30 5 2" damping="4 1 0.5" springlength="0.2"'
PATHS = {
    "fixed": '<joint joint="turn" coef="0.7"/><joint joint="slide" coef="-2"/>',
    "spatial": '<site site="post"/><site site="eye"/>',
}


@pytest.mark.parametrize("name", SPRINGS)
@pytest.mark.parametrize("path", PATHS)
def test_springs_and_dampers_of_tendons_are_mujocos(name, path, tmp_path):
    text = MODEL_WITH_STATES.format(plugin="", actuator="", key="", step=1e-3)
    own = f'<tendon><{path} name="own" {SPRINGS[name]}>{PATHS[path]}</{path}></tendon></mujoco>'
    (tmp_path / "model.xml").write_text(text.replace("</mujoco>", own), encoding="utf-8")
    mechanism = read_model(tmp_path / "model.xml", ImportOptions())
    assert mechanism.forces
    assert "tendon 'own'" not in {row.element for row in mechanism.said}
    assert max(agreement(tmp_path / "model.xml")) < 1e-12


def test_a_smoothed_muscle_is_linear_at_the_start_and_where_it_rests(tmp_path):
    """At an activation of 0 as of 0.2: the bounds of MuJoCo's are left out, which its state never passes."""
    path, _ = written_with_state(tmp_path, "muscle that is smoothed")
    text = path.read_text(encoding="utf-8")
    for act in ("0", "0.4"):
        path.write_text(text.replace('act="0.6"', f'act="{act}"'), encoding="utf-8")
        found = mbproj.import_model(path, at="home", controls={"u": "0.4"})
        linear = mbproj.linearize(found.scene, inputs=["slide.displacement"], outputs=["turn.angle"])
        assert np.isfinite(linear.A).all()
        assert linear.A.shape == (5, 5)
