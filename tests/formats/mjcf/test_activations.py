"""Actuators with states: forces and motions as MuJoCo's own, of servos, filters, PID controllers and muscles."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.formats.signals import signals_of
from tests.crossed import once, some
from tests.formats.agreement import agreement

mujoco = pytest.importorskip("mujoco")

MODEL = """<mujoco><compiler angle="radian"/><option timestep="{step}" integrator="RK4"/>{plugin}
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
ACTING = {
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
    ACTING |= {
        "pid": ('<pid name="u" joint="turn" kp="30" ki="8" kv="3" input="pos"/>', "0.2"),
        "pid with limits": ('<pid name="u" joint="slide" kp="30" ki="8" imax="0.25" input="pos" gear="-2"/>', "0.2"),
        "pid of two joints": ('<pid name="u" tendon="both" kp="30" ki="8" kv="3" input="pos"/>', "0.2"),
        "pid that is slow": ('<pid name="u" joint="turn" kp="30" kv="3" slewmax="0.3" input="pos"/>', "0.2"),
    }


def written(folder, name, ctrl=0.4, step=1e-3):
    actuator, act = ACTING[name]
    key = f'ctrl="{ctrl}" act="{act}"'
    plugin = PLUGIN if "plugin" in name else ""
    text = MODEL.format(plugin=plugin, actuator=actuator, key=key, step=step)
    (folder / "model.xml").write_text(text, encoding="utf-8")
    return folder / "model.xml", [float(each) for each in act.split()]


@pytest.mark.parametrize(("name", "signal"), once([*ACTING], ["0.4", "0.4 * cos(3*t)"]))
def test_forces_are_mujocos(name, signal, tmp_path):
    """With a short step, by which MuJoCo's integrals and setpoints are ahead."""
    path, act = written(tmp_path, name, step=1e-12)
    options = ImportOptions("home", controls=signals_of({"u": signal}, "controls"))
    (row,) = [each for each in read_model(path, options).said if each.element == "actuator 'u'"]
    assert row.same.value == "yes"
    assert max(agreement(path, options=options, ctrl=[0.4], act=act)) < 1e-12
    assert max(agreement(path, options=options, ctrl=[0.4], act=[each + 0.1 for each in act])) > 1e-6


@pytest.mark.parametrize("name", some(["integrated velocity", "plugin with limits", "muscle", *list(ACTING)[15:]], 2))
def test_motions_are_mujocos(name, tmp_path):
    """Half a second, against MuJoCo's fourth-order method with two steps; its activations are of the first order."""
    ends = []
    for step in (2e-4, 1e-4):
        path, _ = written(tmp_path, name, step=step)
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
    text = MODEL.format(plugin="", actuator="", key="", step=1e-3)
    own = f'<tendon><{path} name="own" {SPRINGS[name]}>{PATHS[path]}</{path}></tendon></mujoco>'
    (tmp_path / "model.xml").write_text(text.replace("</mujoco>", own), encoding="utf-8")
    mechanism = read_model(tmp_path / "model.xml", ImportOptions())
    assert mechanism.forces
    assert "tendon 'own'" not in {row.element for row in mechanism.said}
    assert max(agreement(tmp_path / "model.xml")) < 1e-12


def test_a_smoothed_muscle_is_linear_at_the_start_and_where_it_rests(tmp_path):
    """At an activation of 0 as of 0.2: the bounds of MuJoCo's are left out, which its state never passes."""
    path, _ = written(tmp_path, "muscle that is smoothed")
    text = path.read_text(encoding="utf-8")
    for act in ("0", "0.4"):
        path.write_text(text.replace('act="0.6"', f'act="{act}"'), encoding="utf-8")
        found = mbproj.import_model(path, at="home", controls={"u": "0.4"})
        linear = mbproj.linearize(found.scene, inputs=["slide.displacement"], outputs=["turn.angle"])
        assert np.isfinite(linear.A).all()
        assert linear.A.shape == (5, 5)
