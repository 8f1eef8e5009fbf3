"""Compares an imported scene with MuJoCo's model of the same file: the start, and accelerations there.

The scene is compiled from its text, as a run does it, and MuJoCo's model is that of the file with all its flags. So an
option that the import drops, or a velocity that it takes wrongly, makes a difference."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import gamma, jacobian, set_jacobian, set_velocity, tangent_jacobian
from mbproj.equations.contacts import pressing
from mbproj.equations.forces import applied, generalised
from mbproj.equations.gaps import gaps
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.of_motion import generalised_force, mass_matrix, solve_bordered
from mbproj.equations.rank.row_space import independent
from mbproj.equations.tangent_space import tangent_velocities
from mbproj.equations.tangent_space import velocities as rates_of
from mbproj.formats.as_scene import ROUNDED, scene_text
from mbproj.formats.mechanism import Agreement, ImportedMechanism, ImportOptions, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf, warnings_as_notes
from mbproj.formats.mjcf.joints import Called
from mbproj.formats.mjcf.laws import inputs_of
from mbproj.model.compile.mechanism import Guess, initial_guess
from mbproj.model.system import System
from mbproj.scene.expressions.evaluate import Value, evaluate
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.fields.rotations import from_matrix, to_matrix
from mbproj.scene.records import Matrix
from mbproj.scene.scene import read_scene_text

#: The row of the table on accelerations.
ACCELERATIONS = "accelerations beside MuJoCo's"
#: States with random poses near the start and random velocities: these show springs at rest, dampers and dry friction.
#: The poses are so many rad or lengths of the mechanism away, which leaves ropes on the circles that they run around.
MOVING, NEARBY = 3, 1e-3


def compare(
    compiled: CompiledMjcf, called: Called, options: ImportOptions, mechanism: ImportedMechanism, version: str
) -> Agreement | None:
    """Add rows on how far the start and the accelerations of the scene are from MuJoCo's, and return the numbers; None
    where it is too large, has no start, or no accelerations of its own, which the row says."""
    if len(mechanism.parts) > THRESHOLDS.large:  # with dense matrices
        what = f"not compared: it has {len(mechanism.parts)} bodies, and {THRESHOLDS.large} are the most"
        mechanism.say(ACCELERATIONS, None, what, Same.YES)
        return None
    try:
        scene = _Moving.of(_bare(mechanism), _numbers(called), version)
        with warnings_as_notes(compiled.source), np.errstate(over="raise", invalid="raise"):
            model = RigidMujoco.of(compiled, options, scene.frames)
            open_by = model.open()
            agreement, unreached = _agreement(scene, model, mechanism, options)
    except (InputError, SimulationError) as error:
        what = f"not compared: {error.problems[0].message if isinstance(error, InputError) else error}"
        mechanism.say(ACCELERATIONS, None, what, Same.NO)
        return None
    except np.linalg.LinAlgError:
        mechanism.say(ACCELERATIONS, None, "not compared: those of the scene are not unique", Same.NO)
        return None
    except FloatingPointError:
        mechanism.say(ACCELERATIONS, None, "not compared: the numbers of the model are too large", Same.NO)
        return None
    _say_start(mechanism, agreement, open_by, unreached)
    alike = agreement.acceleration_relative <= THRESHOLDS.imported_alike
    by = _shown(agreement.acceleration, agreement.angular_acceleration, "s^2")
    what = f"{'agree to' if alike else 'differ by up to'} {by}, {agreement.acceleration_relative:.1g} of the largest,"
    what += (
        f" at the start and {MOVING} random states beside it; equalities rigid; without {', '.join(agreement.without)}"
    )
    mechanism.say(ACCELERATIONS, None, what, Same.YES if alike else Same.NO)
    return agreement


def _say_start(mechanism: ImportedMechanism, agreement: Agreement, open_by: float, unreached: float) -> None:
    """Add rows where the scene begins with other velocities than MuJoCo, or at another pose, although no equality is
    open there. Also where MuJoCo's joints cannot reach that pose."""
    away = max(agreement.position, agreement.angle) > ROUNDED and open_by <= THRESHOLDS.same_written
    if away or unreached > ROUNDED:
        what = f"bodies are up to {_shown(agreement.position, agreement.angle)} away from MuJoCo's"
        mechanism.say("pose of the start", None, what, Same.NO)
    if agreement.velocity_relative > ROUNDED:
        what = f"differ by up to {_shown(agreement.velocity, agreement.angular_velocity, 's')} from MuJoCo's"
        mechanism.say("velocities of the start", None, what, Same.NO)


def _shown(length: float, angle: float, per: str = "") -> str:
    unit = f"/{per}" if per else ""
    return f"{length:.2g} m{unit} and {angle:.2g} rad{unit}"


def _numbers(called: Called) -> dict[str, int]:
    """The number in MuJoCo of each body of the scene, by its name: the first, since others are fixed to that one."""
    numbers: dict[str, int] = {}
    for number, name in called.items():
        numbers.setdefault(name, number)
    return numbers


def _agreement(
    ours: _Moving, theirs: RigidMujoco, mechanism: ImportedMechanism, options: ImportOptions
) -> tuple[Agreement, float]:
    """The numbers, and how far from the scene's pose MuJoCo's joints stay, in m or rad."""
    qvel, (places, turns) = theirs.data.qvel.copy(), ours.poses()
    moved = theirs.away(places, turns)
    unreached = theirs.follow(places, turns)
    theirs.move(qvel)
    begins, start, qpos = theirs.velocities(), ours.velocities(ours.start), theirs.data.qpos.copy()
    off, size, speed = np.zeros(2), np.array([float(np.linalg.norm(mechanism.gravity)), 0.0]), np.zeros(2)
    random, units, state, dry = np.random.default_rng(0), theirs.scales(ours.system.length), ours.start, False
    for at in range(1 + MOVING):
        if at:
            theirs.at(qpos, np.zeros(len(qvel)))
            theirs.shift(NEARBY * theirs.allowed(units * random.normal(size=len(qvel))))
            near = ours.near(*theirs.poses())
            unreached = max(unreached, theirs.follow(*near.poses()))
            theirs.move(theirs.allowed(units * random.normal(size=len(qvel))))
            state, dry = near.moving(theirs.velocities()), theirs.slides()
        expected = theirs.accelerations(dry=dry)
        off = np.maximum(off, _largest(ours.accelerations(state, dry=dry) - expected))
        size, speed = np.maximum(size, _largest(expected)), np.maximum(speed, _largest(theirs.velocities()))
    # In a motion that nothing accelerates large terms cancel, and one that is locked has none.
    size = np.maximum(size, np.maximum(speed * speed[1], [ours.system.length, 1.0]))
    without = ("limits", "contacts", "sticking friction", *(() if options.controls is not None else ("actuators",)))
    apart = _largest(start - begins)
    length = ours.system.length
    (position, angle), (velocity, turning), (shifted, turned) = (
        each.tolist() for each in (_largest(moved), apart, off)
    )
    agreement = Agreement(
        position=position,
        angle=angle,
        velocity=velocity,
        angular_velocity=turning,
        velocity_relative=_part(apart, np.maximum(_largest(begins), _largest(start)), length),
        acceleration=shifted,
        angular_acceleration=turned,
        acceleration_relative=_part(off, size, length),
        states=1 + MOVING,
        without=without,
    )
    return agreement, unreached


def _part(off: Array, size: Array, length: float) -> float:
    """The largest part that differences (2,) of vectors and of turns are of their sizes; 0 where all vanish. Turns are
    at least as large as vectors over the mechanism's length, and the other way round: one kind alone may vanish."""
    least = np.maximum(size, [size[1] * length, size[0] / length])
    return float((off / np.where(least > 0.0, least, 1.0)).max())


def _largest(rows: Array) -> Array:
    """The largest length of the first and of the last three columns, (2,)."""
    return np.array([np.linalg.norm(rows[:, part], axis=1).max(initial=0.0) for part in (slice(3), slice(3, 6))])


def _bare(mechanism: ImportedMechanism) -> ImportedMechanism:
    """The mechanism without limits, stops and motions."""
    joints = {name: replace(joint, keys=_unlimited(joint.type, joint.keys)) for name, joint in mechanism.joints.items()}
    forces = {name: force for name, force in mechanism.forces.items() if force["type"] != "stop"}
    return replace(mechanism, joints=joints, forces=forces, motions={}, said=[])


def _unlimited(kind: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a joint without those that limit it; a rope that may be slack is free."""
    left = {"limits", "slack", "length"} if "slack" in keys else {"limits"}
    unlimited = {key: value for key, value in keys.items() if key not in left}
    return unlimited | {"free": True} if kind == "rope" and "length" not in unlimited else unlimited


@dataclass(frozen=True, eq=False)
class _Moving:
    """A scene's system with its assembled start. For each of its bodies that MuJoCo has, too: `carriers` is the number
    of the body in the system that carries it, the last one for the ground. `frames` has this carrier's frame on
    MuJoCo's body."""

    system: System
    guess: Guess
    start: State
    carriers: Integers
    frames: list[CarriedFrame]

    @classmethod
    def of(cls, mechanism: ImportedMechanism, numbers: Mapping[str, int], version: str) -> _Moving:
        """The system of the mechanism's scene; `numbers` are those of MuJoCo's bodies by name."""
        scene = read_scene_text(scene_text(mechanism, version), mechanism.file)
        system = compile_system(scene)
        carriers, frames = list[int](), list[CarriedFrame]()
        for at, body in enumerate(scene.bodies):
            carrier = int(system.body_carrier[at])
            if body.name in numbers:
                turn = np.array(to_matrix(tuple(system.body_turn[at])))
                carriers.append(carrier)
                frames.append(CarriedFrame(numbers[body.name], system.body_offset[at], turn))
        guess = initial_guess(scene, system)
        return cls(system, guess, assemble(system, guess), np.array(carriers, dtype=np.intp), frames)

    def near(self, places: Array, axes: Array) -> _Moving:
        """The scene with its start at the closed pose nearest to these points (n, 3) and axes (n, 3, 3) of the frames.
        Raises InputError where there is none."""
        q = _with_ground(self.start.q.reshape(-1, 7))
        turned = [from_matrix(cast("Matrix", each.tolist())) for each in axes]
        q[self.carriers] = np.concatenate([places, turned], axis=1)
        return replace(self, start=assemble(self.system, replace(self.guess, q=q[:-1].ravel())))

    def poses(self) -> tuple[Array, Array]:
        """The positions (n, 3) and axes (n, 3, 3) of the frames at the start."""
        pose = pose_of(self.start.q)
        return pose.position[self.carriers], pose.rotation[self.carriers]

    def velocities(self, state: State) -> Array:
        """(r', ω) of the frames, (n, 6)."""
        u = tangent_velocities(pose_of(state.q), state.v).reshape(-1, 6)
        return np.asarray(_with_ground(u)[self.carriers])

    def moving(self, velocities: Array) -> State:
        """The state of the start with these velocities of the frames. Bodies without mass follow by their joints."""
        pose, whole = pose_of(self.start.q), np.zeros((self.system.bodies + 1, 6))
        whole[self.carriers] = velocities
        u, others = whole[:-1], ~np.isin(np.arange(self.system.bodies), self.carriers)
        if others.any():
            G = tangent_jacobian(self.system.rows, pose)[:, :-1, :6]
            left = np.einsum("mbi,bi->m", G, u)
            G_others = G[:, others].reshape(len(G), -1)
            u[others] = -np.linalg.lstsq(G_others, left, rcond=None)[0].reshape(-1, 6)
        return self.start.changed(velocities=rates_of(pose, u.ravel()))

    def accelerations(self, state: State, *, dry: bool) -> Array:
        """(r'', ω') of the frames, (n, 6), by Eq. 14 with the independent rows; with `dry`, all that has dry friction
        slides, else it has none."""
        system, pose = self.system, pose_of(state.q)
        twist, loads = twist_of(pose, state.v), applied(state.instant(system))
        rows = np.flatnonzero(independent(system, pose))
        force = generalised_force(system, pose, twist) + generalised(pose, loads.force, loads.torque)
        if system.stops is not None:  # those of elastic ropes, which only pull
            gap, along = gaps(system.stops, pose, state.turns), system.stops.coordinates
            push = pressing(system.stops, np.zeros_like(gap), gap, np.zeros_like(gap))
            force += set_jacobian(along, pose).T @ (system.stops.side * push)
        if dry and system.frictions is not None:
            along, sliding = system.frictions.coordinates, system.frictions.sliding
            force -= set_jacobian(along, pose).T @ (sliding * np.sign(set_velocity(along, pose, twist)))
        right = gamma(system, pose, twist, drive_at(system, 0.0))
        change, _ = solve_bordered(mass_matrix(system, pose), jacobian(system, pose)[rows], force, right[rows])
        by_body = change.reshape(-1, 7)
        turning = 2.0 * np.einsum("nij,nj->ni", pose.L[:-1], by_body[:, 3:])
        return _with_ground(np.concatenate([by_body[:, :3], turning], axis=1))[self.carriers]


def _with_ground(rows: Array) -> Array:
    """The rows of all bodies (n, k), and zeros for the ground, which carries bodies that loops weld to it."""
    return np.concatenate([rows, np.zeros((1, rows.shape[1]))])


# --- Accelerations by MuJoCo of a model whose equalities are rigid ----------------------------------------------------
# From MuJoCo's mass matrix, forces and Jacobians. MuJoCo's equalities, limits, contacts and sticking friction are
# soft by their nature, so that rigid joints cannot agree with its accelerations. Here M q'' + Jᵀλ = f and J q'' = -J'
# q' are solved with the rows J of its equalities; limits and contacts are off.


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

        model, data = copy.copy(compiled.whole), copy.copy(compiled.data)
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

        (place, rotation), J = self._pose(frame), np.zeros((2, 3, self.model.nv))
        mujoco.mj_jac(self.model, self.data, J[0], J[1], place, frame.number)
        return np.concatenate([J[0], (rotation if axes is None else axes).T @ J[1]])

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
        shared = [number for number in here if all(number in side for side in sides)]
        none = np.zeros((0, self.model.nv))
        J, ahead, behind = (np.concatenate([none, *(side[at] for at in shared)]) for side in (here, *sides))
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
    model, signals = compiled.whole, options.controls or {}
    for number in range(len(model.actuator_trntype)):
        name = compiled.name("actuator", number) or f"actuator_{number}"
        first = int(getattr(model, "actuator_ctrladr", np.arange(model.nu))[number])
        for at, input_name in enumerate(inputs_of(compiled, number, name)):
            if input_name in signals:
                data.ctrl[first + at] = evaluate(parse(signals[input_name].text), {"t": Value(0.0, None)}).number


def _rotation(turn: Array) -> Array:
    """The rotation vector (3,) of a rotation matrix."""
    skew = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine, cosine = float(np.linalg.norm(skew)), 0.5 * (float(np.trace(turn)) - 1.0)
    return skew * (np.arctan2(sine, cosine) / sine) if sine > APART**2 else skew
