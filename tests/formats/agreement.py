"""An imported tree against MuJoCo: mass matrix, accelerations at random states; no loops, limits, dry friction."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from mbproj.equations.assembly.assemble import State, coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.derivatives import MotionAtTime, row_motion, tangent_force
from mbproj.equations.kinematics import pose_of
from mbproj.equations.of_motion import tangent_mass_matrix
from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import Connection, ImportedMechanism, ImportOptions
from mbproj.formats.read import read_model
from mbproj.model.euler_parameters import matrix_L
from mbproj.motion.formulations.full import FullFormulation
from mbproj.scene.fields.rotations import from_matrix, to_matrix
from mbproj.scene.scene import read_scene_text


class Agreement(NamedTuple):
    """The largest differences over the states, relative to the largest numbers: of the mass matrix, of the forces
    without accelerations of the coordinates, of the accelerations of all bodies."""

    mass: float
    bias: float
    accelerations: float


def tree_of(mechanism: ImportedMechanism) -> str:
    """The scene of the tree alone, without what MuJoCo counts among the constraints."""
    joints = {}
    followers = [name for pair in mechanism.followers.values() for name in pair]
    for name, joint in mechanism.joints.items():
        if name not in mechanism.tree or name in followers:
            continue
        dropped = {"limits", *(("slack", "length") if "slack" in joint.keys else ())}
        keys = {key: value for key, value in joint.keys.items() if key not in dropped}
        if joint.type == "rope" and "stiffness" not in keys:
            keys["free"] = True
        joints[name] = Connection(
            name, joint.type, joint.bodies, joint.points, joint.axes, joint.turns, keys, joint.place
        )
    forces = {name: force for name, force in mechanism.forces.items() if force["type"] not in ("friction", "stop")}
    alone = ImportedMechanism(mechanism.title, mechanism.kind, mechanism.file, mechanism.gravity)
    parts = {name: part for name, part in mechanism.parts.items() if name not in followers}
    alone.parts, alone.joints, alone.forces, alone.tree = parts, joints, forces, set(joints)
    alone.signals, alone.states = mechanism.signals, mechanism.states
    return scene_text(alone, "test")


def agreement(
    path: Path, states: int = 10, seed: int = 0, model=None, options=None, ctrl=(), act=(), spread=1.0
) -> Agreement:
    """Of the scene that is made of the file with MuJoCo's model of it, or with another one; with these control signals
    and activations where `options` let actuators act."""
    import mujoco

    if model is None:
        model = urdf_in_mujoco(path) if path.suffix == ".urdf" else mjcf_in_mujoco(path)
    mechanism = read_model(path, options)
    scene = read_scene_text(tree_of(mechanism))
    system = compile_system(scene)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    if not len(ctrl):
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    model.opt.density = model.opt.viscosity = 0.0
    model.tendon_armature[:] = 0.0
    left_out = {row.element for row in mechanism.said if row.what.startswith("left out")}
    for number in range(model.ntendon):
        if f"tendon '{model.tendon(number).name or f'tendon_{number}'}'" in left_out:
            model.tendon_stiffness[number] = model.tendon_damping[number] = 0.0
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    worst = Agreement(0.0, 0.0, 0.0)
    for _ in range(states):
        data.qpos[:] = _random(model, rng, spread)
        data.qvel[:] = rng.normal(size=model.nv)
        data.ctrl[: len(ctrl)] = ctrl
        data.act[: len(act)] = act
        mujoco.mj_forward(model, data)
        found = _compared(model, data, mechanism, scene, system)
        worst = Agreement(*map(max, worst, found))
    return worst


def mjcf_in_mujoco(path: Path):
    """MuJoCo's model of an MJCF file."""
    from mbproj.formats.mjcf.compiled import compile_mjcf
    from mbproj.formats.mjcf.source import source_of
    from mbproj.formats.xml import parse

    return compile_mjcf(source_of(parse(path.read_bytes(), str(path)), path), ImportOptions()).model


def urdf_in_mujoco(path: Path):
    """MuJoCo's model of a URDF's tree, without its shapes, with bodies that are fixed, and with our gravity."""
    from xml.etree import ElementTree

    import mujoco

    root = ElementTree.parse(path).getroot()
    for link in root.iter("link"):
        for shape in [each for each in link if each.tag in ("visual", "collision")]:
            link.remove(shape)
    for unknown in [each for each in root if each.tag not in ("link", "joint")]:
        root.remove(unknown)
    compiler = ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler")
    compiler.attrib |= {"fusestatic": "false", "balanceinertia": "false"}
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
    model.opt.gravity[:] = [0.0, 0.0, -9.81]
    return model


def _random(model, rng, spread):
    import mujoco

    qpos = np.array(model.qpos0)
    mujoco.mj_integratePos(model, qpos, rng.uniform(-spread, spread, size=model.nv), 1.0)
    return qpos


def _compared(model, data, mechanism, scene, system) -> Agreement:
    import mujoco

    n = system.bodies
    numbers = _numbers(model, mechanism)
    q, known = np.zeros((n, 7)), np.zeros(n, dtype=bool)
    jacobian_6, dot_6 = np.zeros((n, 6, model.nv)), np.zeros((n, 6, model.nv))
    for at, body in enumerate(scene.bodies):
        carrier = int(system.body_carrier[at])
        if body.name not in numbers or carrier == n or known[carrier]:
            continue
        known[carrier] = True
        number = numbers[body.name]
        turn = np.array(to_matrix(tuple(system.body_turn[at])))
        rotation = data.xmat[number].reshape(3, 3) @ turn.T
        centre = data.xipos[number] - rotation @ system.body_offset[at]
        both = np.zeros((2, 3, model.nv))
        mujoco.mj_jac(model, data, both[0], both[1], centre, number)
        jacobian_6[carrier] = np.concatenate([both[0], rotation.T @ both[1]])
        mujoco.mj_jacDot(model, data, both[0], both[1], centre, number)
        dot_6[carrier] = np.concatenate([both[0], rotation.T @ both[1]])
        q[carrier] = [*centre, *from_matrix(tuple(map(tuple, rotation.tolist())))]
    change = dot_6 @ data.qvel
    if not known.all():
        _between(model, data, scene, system, q, known)
        _carried(system, q, jacobian_6, change, data.qvel, known)
    u, moved = jacobian_6 @ data.qvel, jacobian_6 @ data.qacc
    L = matrix_L(q[:, 3:])
    rates = 0.5 * np.einsum("nij,ni->nj", L, u[:, 3:])
    state = State.of(system, 0.0, positions=q.ravel(), velocities=np.concatenate([u[:, :3], rates], axis=1).ravel())
    form = FullFormulation.of(system, state, scene.settings)
    ours = form.accelerations(0.0, _y(form, state)).acceleration.reshape(n, 7)
    ours_6 = np.concatenate([ours[:, :3], 2.0 * np.einsum("nij,nj->ni", L, ours[:, 3:])], axis=1)
    M = np.zeros((model.nv, model.nv))
    for column, one in zip(M, np.eye(len(M)), strict=True):  # which mj_fullM gives by arguments that change
        mujoco.mj_mulM(model, data, column, one)
    flat = jacobian_6.reshape(6 * n, model.nv)
    weighed = flat.T @ tangent_mass_matrix(system, pose_of(q.ravel())) @ flat
    expected = coordinate_values(system, pose_of(state.q))
    left = -flat.T @ tangent_force(system, MotionAtTime(0.0, q.ravel(), u.ravel(), change.ravel(), expected, state.x))
    forces = data.qfrc_bias, -data.qfrc_passive, -data.qfrc_actuator
    # In a body that nothing accelerates large terms cancel, ω × v among them.
    turning = np.abs(u[:, 3:]).max() * np.abs(u).max()
    bias_scale = max(*(np.abs(force).max() for force in forces), np.abs(M).max() * turning, 1e-6)
    scale = max(np.abs(moved).max(), np.abs(change).max(), turning, 1e-6)
    return Agreement(
        float(np.abs(weighed - M).max() / np.abs(M).max()),
        float(np.abs(left - sum(forces)).max() / bias_scale),
        float(np.abs(ours_6 - moved - change)[known].max() / scale),
    )


def _y(form, state):
    layout = form.layout
    parts = {"positions": state.q, "velocities": state.v}
    parts["states"] = state.x
    for name in ("quadratures", "followed"):
        parts[name] = np.zeros(layout.size_of(name))
    if layout.size_of("followed"):
        parts["followed"] = coordinate_values(form.system, pose_of(state.q))
    return layout.vector_of(parts)


def _numbers(model, mechanism):
    """MuJoCo's number of each body by the scene's name: that of the same name, or in the same order."""
    moving = [n for n in range(1, model.nbody) if model.body_weldid[n] and (model.body_jntnum[n] or model.body_mass[n])]
    own = [name for name in mechanism.parts if name not in mechanism.between]
    assert len(moving) == len(own)
    named = {model.body(number).name: number for number in moving}
    return named if set(named) == set(own) else dict(zip(own, moving, strict=True))


def _between(model, data, scene, system, q, known) -> None:
    """Poses of the massless bodies between: each joint's frame turned and shifted as its coordinate says."""
    for at, body in enumerate(scene.bodies):
        carrier = int(system.body_carrier[at])
        if known[carrier]:
            continue
        chain = next(joint for joint in scene.joints if joint.bodies[1] == body.name)
        number = next(j for j in range(model.njnt) if _own(model.jnt(j).name) == chain.name)
        child = int(model.jnt_bodyid[number])
        rotation = data.xmat[int(model.body_parentid[child])].reshape(3, 3) @ _matrix(model.body_quat[child])
        place = (
            data.xpos[int(model.body_parentid[child])]
            + data.xmat[int(model.body_parentid[child])].reshape(3, 3) @ model.body_pos[child]
        )
        for joint in range(int(model.body_jntadr[child]), number + 1):
            s = data.qpos[model.jnt_qposadr[joint]] - model.qpos0[model.jnt_qposadr[joint]]
            axis = rotation @ model.jnt_axis[joint]
            if model.jnt_type[joint] == 2:
                place = place + s * axis
            else:
                anchor = place + rotation @ model.jnt_pos[joint]
                half = _matrix(np.array([np.cos(s / 2), *(np.sin(s / 2) * axis)]))
                rotation, place = half @ rotation, anchor - half @ rotation @ model.jnt_pos[joint]
        centre = place + rotation @ model.jnt_pos[number]
        q[carrier] = [*centre, *from_matrix(tuple(map(tuple, rotation.tolist())))]


def _carried(system, q, jacobian_6, change, rates, known) -> None:
    """How massless bodies between move, from the rows of their joints: G u = 0 and G u' = -G' u."""
    columns = np.repeat(known, 6)
    G = row_motion(system.rows, _motion(q, np.zeros_like(change), change).carried()).G.matrix()
    own, others = G[:, ~columns], G[:, columns]
    left = others @ jacobian_6[known].reshape(-1, len(rates))
    jacobian_6[~known] = -np.linalg.lstsq(own, left, rcond=None)[0].reshape(-1, 6, len(rates))
    u = jacobian_6 @ rates
    G_dot = row_motion(system.rows, _motion(q, u, change).carried()).G_dot.matrix()
    left = others @ change[known].ravel() + G_dot @ u.ravel()
    change[~known] = -np.linalg.lstsq(own, left, rcond=None)[0].reshape(-1, 6)


def _motion(q, u, change):
    return MotionAtTime(0.0, q.ravel(), u.ravel(), change.ravel(), np.zeros(0))


def _own(name):
    from mbproj.formats.mechanism import ImportedNames

    return ImportedNames().unused(name)


def _matrix(quaternion):
    return np.array(to_matrix(tuple(quaternion / np.linalg.norm(quaternion))))
