"""An imported tree against MuJoCo: mass matrix, accelerations at random states; no loops, limits, dry friction."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.constraint_equations import jacobian
from mbproj.dynamics.equations.equations_of_motion import tangent_mass_matrix
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.formats import Wishes, read_model, scene_text
from mbproj.formats.mechanism import Connection, Mechanism
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.model import compile_system
from mbproj.model.euler_parameters import matrix_L
from mbproj.scene import read_scene_text
from mbproj.scene.fields.rotations import from_matrix, to_matrix


class Agreement(NamedTuple):
    """The largest differences over the states, relative to the largest number of each."""

    mass: float
    accelerations: float


def tree_of(mechanism: Mechanism) -> str:
    """The scene of the tree alone, without what MuJoCo counts among the constraints."""
    joints = {}
    for name, joint in mechanism.joints.items():
        if name not in mechanism.tree:
            continue
        keys = {key: value for key, value in joint.keys.items() if key != "limits"}
        joints[name] = Connection(
            name, joint.type, joint.bodies, joint.points, joint.axes, joint.turns, keys, joint.place
        )
    forces = {name: force for name, force in mechanism.forces.items() if force["type"] not in ("friction", "stop")}
    alone = Mechanism(mechanism.title, mechanism.kind, mechanism.file, mechanism.gravity)
    alone.parts, alone.joints, alone.forces, alone.tree = mechanism.parts, joints, forces, set(joints)
    return scene_text(alone, "test")


def agreement(path: Path, states: int = 10, seed: int = 0, model=None) -> Agreement:
    """Of the scene that is made of the file with MuJoCo's model of it, or with another one."""
    import mujoco

    from mbproj.formats.mjcf.compiled import compile_mjcf
    from mbproj.formats.mjcf.source import source_of
    from mbproj.formats.xml import parse

    if model is None:
        compiled = compile_mjcf(source_of(parse(path.read_bytes(), str(path)), path), Wishes())
        model = compiled.model
    mechanism = read_model(path, Wishes())
    scene = read_scene_text(tree_of(mechanism))
    system = compile_system(scene)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT) | int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    model.opt.density = model.opt.viscosity = 0.0
    for values in (model.tendon_stiffness, model.tendon_damping, model.tendon_armature):
        values[:] = 0.0
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    worst = Agreement(0.0, 0.0)
    for _ in range(states):
        data.qpos[:] = _random(model, rng)
        data.qvel[:] = rng.normal(size=model.nv)
        mujoco.mj_forward(model, data)
        found = _compared(model, data, mechanism, scene, system)
        worst = Agreement(max(worst.mass, found.mass), max(worst.accelerations, found.accelerations))
    return worst


def _random(model, rng):
    import mujoco

    qpos = np.array(model.qpos0)
    mujoco.mj_integratePos(model, qpos, rng.uniform(-1.0, 1.0, size=model.nv), 1.0)
    return qpos


def _compared(model, data, mechanism, scene, system) -> Agreement:
    import mujoco

    n = system.bodies
    numbers = _numbers(model, mechanism)
    q, v = np.zeros((n, 7)), np.zeros((n, 7))
    jacobian_6, dot_6 = np.zeros((n, 6, model.nv)), np.zeros((n, 6, model.nv))
    known = np.zeros(n, dtype=bool)
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
        twist = jacobian_6[carrier] @ data.qvel
        v[carrier] = [*twist[:3], *(0.5 * matrix_L(q[carrier, 3:]).T @ twist[3:])]
    if not known.all():
        _between(model, data, mechanism, scene, system, q, v, known)
    settings = scene.settings
    state = State.of(system, 0.0, positions=q.ravel(), velocities=v.ravel())
    form = FullFormulation.of(system, state, settings)
    ours = form.accelerations(0.0, _y(form, state)).acceleration.reshape(n, 7)
    L = matrix_L(q[:, 3:])
    ours_6 = np.concatenate([ours[:, :3], 2.0 * np.einsum("nij,nj->ni", L, ours[:, 3:])], axis=1)[known]
    terms = (jacobian_6 @ data.qacc)[known], (dot_6 @ data.qvel)[known]
    theirs = sum(terms)
    scale = max(*(np.abs(term).max() for term in terms), 1e-6)  # they cancel in a body that nothing accelerates
    mass = 0.0
    if known.all():
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        flat = jacobian_6.reshape(6 * n, model.nv)
        weighed = flat.T @ tangent_mass_matrix(system, pose_of(q.ravel())) @ flat
        mass = float(np.abs(weighed - M).max() / np.abs(M).max())
    return Agreement(mass, float(np.abs(ours_6 - theirs).max() / scale))


def _y(form, state):
    layout = form.layout
    parts = {"positions": state.q, "velocities": state.v}
    for name in ("states", "quadratures", "followed"):
        parts[name] = np.zeros(layout.size_of(name))
    if layout.size_of("followed"):
        from mbproj.dynamics.assembly.assemble import coordinate_values

        parts["followed"] = coordinate_values(form.system, pose_of(state.q))
    return layout.joined(parts)


def _numbers(model, mechanism):
    """MuJoCo's number of each body by the scene's name: that of the same name, or in the same order."""
    moving = [number for number in range(1, model.nbody) if model.body_weldid[number]]
    own = [name for name in mechanism.parts if name not in mechanism.between]
    assert len(moving) == len(own)
    named = {model.body(number).name: number for number in moving}
    return named if set(named) == set(own) else dict(zip(own, moving, strict=True))


def _between(model, data, mechanism, scene, system, q, v, known) -> None:
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
    rows = jacobian(system, pose_of(q.ravel())).reshape(system.constraints, system.bodies, 7)
    unknown = np.flatnonzero(~known)
    left = -np.einsum("mbk,bk->m", rows[:, known], v[known])
    columns = rows[:, unknown].reshape(system.constraints, -1)
    v[unknown] = np.linalg.lstsq(columns, left, rcond=None)[0].reshape(-1, 7)


def _own(name):
    from mbproj.formats.mechanism import Names

    return Names().own(name)


def _matrix(quaternion):
    return np.array(to_matrix(tuple(quaternion / np.linalg.norm(quaternion))))
