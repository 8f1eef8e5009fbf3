"""Velocities of a keyframe: each body begins with that of its centre of mass, which lies off its frame."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model

mujoco = pytest.importorskip("mujoco")

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
