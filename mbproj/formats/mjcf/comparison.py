"""Compares an imported scene with MuJoCo's model of the same file: the start, and accelerations there.

The scene is compiled from its text, as a run does it, and MuJoCo's model is that of the file with all its flags. So an
option that the import drops, or a velocity that it takes wrongly, makes a difference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics import (
    State,
    applied,
    assemble,
    drive_at,
    gamma,
    generalised,
    generalised_force,
    jacobian,
    mass_matrix,
    pose_of,
    set_jacobian,
    set_velocity,
    tangent_jacobian,
    tangent_velocities,
    twist_of,
)
from mbproj.dynamics.derivatives.tangent import velocities as rates_of
from mbproj.dynamics.equations.equations_of_motion import solve_bordered
from mbproj.dynamics.equations.gaps import gaps, pressing
from mbproj.dynamics.rank.row_space import independent
from mbproj.errors import InputError, SimulationError
from mbproj.formats.as_scene import scene_text
from mbproj.formats.couplers import ROUNDED
from mbproj.formats.mechanism import Agreement, ImportedMechanism, ImportOptions, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf, warnings_as_notes
from mbproj.formats.mjcf.parts import Called
from mbproj.formats.mjcf.rigid import CarriedFrame, RigidMujoco
from mbproj.model import System, compile_system, initial_guess
from mbproj.model.compile.guess import Guess
from mbproj.scene import from_matrix, read_scene_text, to_matrix
from mbproj.thresholds import THRESHOLDS

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
        with warnings_as_notes():
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
    kept = {key: value for key, value in keys.items() if key not in left}
    return kept | {"free": True} if kind == "rope" and "length" not in kept else kept


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
        turned = [from_matrix(tuple(map(tuple, each.tolist()))) for each in axes]
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
            own = G[:, others].reshape(len(G), -1)
            u[others] = -np.linalg.lstsq(own, left, rcond=None)[0].reshape(-1, 6)
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
