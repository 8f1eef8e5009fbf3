"""Accelerations by MuJoCo of a model whose equalities are rigid: from MuJoCo's mass matrix, forces and Jacobians.

MuJoCo's equalities, limits, contacts and sticking friction are soft by their nature, so that rigid joints cannot agree
with its accelerations. Here M q'' + Jᵀλ = f and J q'' = -J' q' are solved with the rows J of its equalities; limits and
contacts are off."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.mjcf.drives import inputs_of
from mbproj.scene.expressions.evaluate import Value, evaluate
from mbproj.scene.expressions.syntax_tree import parse

#: The time step in s. MuJoCo's states that follow a signal are ahead by one step, which is round-off of so short a one.
SHORT_STEP = 1e-12
#: J is differenced over this time in s at a rate of 1/s. What moves more slowly than so many rad/s or m/s may stick.
APART = 1e-5
#: A part of J that is smaller than this, relative to the largest, has no multiplier of its own.
DEPENDENT = 1e-11
#: A row of J that is no longer than this is round-off: its equality holds two points of one body, or of the ground.
NO_ROW = 1e-12
#: The most passes of Newton's method in which MuJoCo's pose follows another one.
PASSES = 20


class CarriedFrame(NamedTuple):
    """A frame on the body `number` of the model: its axes are the body's after `turn` (3, 3) is taken off, and the
    body's centre of mass is at `offset` (3,) in it."""

    number: int
    offset: Array
    turn: Array


@dataclass(frozen=True, eq=False)
class RigidMujoco:
    """A copy of MuJoCo's model as its file gives it, with all that its flags say, and its data; and frames on its
    bodies whose motion is asked for."""

    model: Any
    data: Any
    frames: Sequence[CarriedFrame]

    @classmethod
    def of(cls, compiled: CompiledMjcf, options: ImportOptions, frames: Sequence[CarriedFrame]) -> RigidMujoco:
        """The model at the pose of the start, with the control signals of the options at t = 0; without these no
        actuator acts."""
        import mujoco

        model, data = copy.copy(compiled.given), copy.copy(compiled.data)
        off = mujoco.mjtDisableBit
        model.opt.timestep, model.opt.enableflags = SHORT_STEP, 0
        model.opt.integrator, model.opt.jacobian = int(mujoco.mjtIntegrator.mjINT_EULER), 0
        model.opt.disableflags |= int(off.mjDSBL_CONTACT) | int(off.mjDSBL_LIMIT)
        if options.controls is None:  # by groups, since the flag turns compensation of gravity by actuators off, too
            model.actuator_group[:] = 0
            model.opt.disableactuator = 1
        else:
            _control(compiled, data, options)
        theirs = cls(model, data, frames)
        theirs.at(data.qpos.copy(), data.qvel.copy())
        return theirs

    def at(self, qpos: Array, qvel: Array) -> None:
        """Move to a state."""
        import mujoco

        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        mujoco.mj_forward(self.model, self.data)

    def move(self, qvel: Array) -> None:
        """Move with other velocities, at the present pose."""
        self.at(self.data.qpos.copy(), qvel)

    def shift(self, step: Array) -> None:
        """Move to a pose nearby: `step` (nv,) is a velocity times a time, in rad, and in m over the unit 1 m."""
        import mujoco

        qpos = self.data.qpos.copy()
        mujoco.mj_integratePos(self.model, qpos, step, 1.0)
        self.at(qpos, np.zeros(self.model.nv))

    def scales(self, length: float) -> Array:
        """The unit of each coordinate's rate, (nv,): 1 for turns, and a length for slides and shifts."""
        import mujoco

        units, of = np.ones(self.model.nv), mujoco.mjtJoint
        for kind, first in zip(self.model.jnt_type, self.model.jnt_dofadr, strict=True):
            if int(kind) in (int(of.mjJNT_SLIDE), int(of.mjJNT_FREE)):
                units[first : first + (1 if int(kind) == int(of.mjJNT_SLIDE) else 3)] = length
        return units

    def poses(self) -> tuple[Array, Array]:
        """The points (n, 3) and axes (n, 3, 3) of the frames."""
        places, axes = zip(*(self._pose(frame) for frame in self.frames), strict=True)
        return np.array(places), np.array(axes)

    def away(self, places: Array, turns: Array) -> Array:
        """The shifts and rotation vectors (n, 6), both global, from the poses of the frames to these points (n, 3) and
        axes (n, 3, 3)."""
        before, axes = self.poses()
        turned = [_rotation(new @ old.T) for old, new in zip(axes, turns, strict=True)]
        return np.concatenate([places - before, turned], axis=1)

    def follow(self, places: Array, turns: Array) -> float:
        """Move the joints so that the frames have these poses, as near as can be. Return what is left, in m or rad."""
        import mujoco

        qpos, nearest, left = self.data.qpos.copy(), self.data.qpos.copy(), np.inf
        for _ in range(PASSES):
            self.at(qpos, np.zeros(self.model.nv))
            away = self.away(places, turns)
            if (now := float(np.abs(away).max())) >= left:
                break
            nearest, left = qpos.copy(), now
            rows = np.concatenate([self._jacobian(frame, np.eye(3)) for frame in self.frames])
            step = np.linalg.lstsq(rows, away.ravel(), rcond=None)[0]
            mujoco.mj_integratePos(self.model, qpos, step, 1.0)
        self.at(nearest, np.zeros(self.model.nv))
        return left

    def velocities(self) -> Array:
        """The velocities of the frames: that of the point, global, and ω in the axes of the frame, (n, 6)."""
        return np.array([self._jacobian(frame) @ self.data.qvel for frame in self.frames])

    def accelerations(self, *, dry: bool) -> Array:
        """The accelerations of the frames, (n, 6), at the present state. With `dry`, all that has dry friction slides;
        else it has none."""
        import mujoco

        qpos, qvel = self.data.qpos.copy(), self.data.qvel.copy()
        M = np.zeros((self.model.nv, self.model.nv))
        for column, one in zip(M, np.eye(len(M)), strict=True):  # mj_fullM differs between versions
            mujoco.mj_mulM(self.model, self.data, column, one)
        force = self.data.qfrc_smooth.copy()
        if dry:
            rows, losses = self._rows(1, 2), self.data.efc_frictionloss[: self.data.nefc]
            force -= rows.T @ (losses[np.isin(self._types, (1, 2))] * np.sign(rows @ qvel))
        J, J_dot = self._changing(qpos, qvel)
        solved = np.linalg.solve(M, np.column_stack([J.T, force]))
        X, free = solved[:, :-1], solved[:, -1]
        if len(J):
            free = free - X @ np.linalg.lstsq(J @ X, J @ free + J_dot @ qvel, rcond=DEPENDENT)[0]
        self.data.qacc[:] = free
        mujoco.mj_rnePostConstraint(self.model, self.data)
        return np.array([self._acceleration(frame) for frame in self.frames])

    def allowed(self, qvel: Array) -> Array:
        """The part of velocities (nv,) that the equalities allow at the present pose."""
        J = self._rows(0)
        return np.asarray(qvel - np.linalg.pinv(J, rcond=DEPENDENT) @ (J @ qvel)) if len(J) else qvel

    def open(self) -> float:
        """By how much the equalities are open at the present pose, in m or rad."""
        return float(np.abs(self.data.efc_pos[: self.data.nefc][self._types == 0]).max(initial=0.0))

    def slides(self) -> bool:
        """Whether all that has dry friction moves, so that its force is known."""
        return bool((np.abs(self._rows(1, 2) @ self.data.qvel) > APART).all())

    def _pose(self, frame: CarriedFrame) -> tuple[Array, Array]:
        axes = np.asarray(self.data.xmat[frame.number].reshape(3, 3) @ frame.turn.T)
        return np.asarray(self.data.xipos[frame.number] - axes @ frame.offset), axes

    def _jacobian(self, frame: CarriedFrame, axes: Array | None = None) -> Array:
        """The Jacobian (6, nv) of a frame's velocity; ω is in its own axes, or in others."""
        import mujoco

        (place, own), J = self._pose(frame), np.zeros((2, 3, self.model.nv))
        mujoco.mj_jac(self.model, self.data, J[0], J[1], place, frame.number)
        return np.concatenate([J[0], (own if axes is None else axes).T @ J[1]])

    def _acceleration(self, frame: CarriedFrame) -> Array:
        """The acceleration of a frame, (6,), from MuJoCo's q''. (mj_jacDot is wrong of a slide that a ball turns.)"""
        import mujoco

        (place, axes), both = self._pose(frame), np.zeros(6)
        mujoco.mj_objectAcceleration(self.model, self.data, mujoco.mjtObj.mjOBJ_BODY, frame.number, both, 0)
        turning, moving = both[:3], both[3:] + self.gravity  # of which MuJoCo takes off the acceleration of gravity
        arm, omega = place - self.data.xipos[frame.number], axes @ (self._jacobian(frame) @ self.data.qvel)[3:]
        moving += np.cross(turning, arm) + np.cross(omega, np.cross(omega, arm))
        return np.concatenate([moving, axes.T @ turning])

    @property
    def gravity(self) -> Array:
        """The acceleration of gravity (3,), 0 where a flag turns it off."""
        import mujoco

        off = self.model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
        return np.zeros(3) if off else np.array(self.model.opt.gravity)

    def _changing(self, qpos: Array, qvel: Array) -> tuple[Array, Array]:
        """J of the equalities and J' along the motion, by central differences, (m, nv) each."""
        import mujoco

        h, here, sides = APART / max(1.0, float(np.abs(qvel).max())), self._equalities(), list[dict[int, Array]]()
        for sign in (1.0, -1.0):
            self.data.qpos[:] = qpos
            mujoco.mj_integratePos(self.model, self.data.qpos, qvel, sign * h)
            mujoco.mj_fwdPosition(self.model, self.data)
            sides.append(self._equalities())
        self.at(qpos, qvel)
        kept = [number for number in here if all(number in side for side in sides)]
        none = np.zeros((0, self.model.nv))
        J, ahead, behind = (np.concatenate([none, *(side[at] for at in kept)]) for side in (here, *sides))
        return J, (ahead - behind) / (2.0 * h)

    def _equalities(self) -> dict[int, Array]:
        """The rows of each equality by its number. MuJoCo leaves out one whose rows are 0."""
        numbers, rows = np.asarray(self.data.efc_id[: self.data.nefc])[self._types == 0], self._rows(0)
        return {int(number): rows[numbers == number] for number in np.unique(numbers)}

    @property
    def _types(self) -> Array:
        """The type of each row of constraints: 0 for an equality, 1 and 2 for dry friction of a joint and a tendon."""
        return np.asarray(self.data.efc_type[: self.data.nefc])

    def _rows(self, *types: int) -> Array:
        """The rows of the constraints' Jacobian with these types, (m, nv)."""
        size = self.data.nefc * self.model.nv
        rows = np.array(self.data.efc_J).ravel()[:size].reshape(-1, self.model.nv)
        rows[np.linalg.norm(rows, axis=1) <= NO_ROW] = 0.0
        return np.asarray(rows[np.isin(self._types, types)])


def _control(compiled: CompiledMjcf, data: Any, options: ImportOptions) -> None:
    """Set the control signals that the options give to their values at t = 0."""
    model, signals = compiled.given, options.controls or {}
    for number in range(len(model.actuator_trntype)):
        name = compiled.name("actuator", number) or f"actuator_{number}"
        first = int(getattr(model, "actuator_ctrladr", np.arange(model.nu))[number])
        for at, own in enumerate(inputs_of(compiled, number, name)):
            if own in signals:
                data.ctrl[first + at] = evaluate(parse(signals[own].text), {"t": Value(0.0, None)}).number


def _rotation(turn: Array) -> Array:
    """The rotation vector (3,) of a rotation matrix."""
    skew = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine, cosine = float(np.linalg.norm(skew)), 0.5 * (float(np.trace(turn)) - 1.0)
    return skew * (np.arctan2(sine, cosine) / sine) if sine > APART**2 else skew
