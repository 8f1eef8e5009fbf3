"""The loads of actuators along a motion, which is that of a run or measured."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array, cross
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import set_bias, set_velocity
from mbproj.equations.derivatives import MotionAtTime, rows_at, tangent_force
from mbproj.equations.forces import applied, given_components, law_state
from mbproj.equations.gaps import gaps
from mbproj.equations.kinematics import body_rates, pose_of
from mbproj.equations.tangent_space import TangentSpace, tangent_space, tangent_velocities
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.state_space import forces_known
from mbproj.linear.states import sampled_state
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.system import System
from mbproj.results.largest_loads import Cycle, Load, Recorded, loads
from mbproj.results.record import Results
from mbproj.scene.scene import Scene
from mbproj.studies.inverse.closed import follow
from mbproj.studies.inverse.given_motion import GivenMotion, smoothed

# --- Actuators, selected by name --------------------------------------------------------------------------------------
# Joint coordinates, motions, forces of the scene, components of forces on bodies.


@dataclass(frozen=True, eq=False)
class Actuators:
    """The k actuators of a system whose motions are removed. `entries` are the names of the forces or coordinates that
    they act on ("A.angle" for a motion of it). `units` are N or N m. `weights` (k,) multiply the squares of their
    forces."""

    system: System
    names: tuple[str, ...]
    entries: tuple[str, ...]
    units: tuple[str, ...]
    weights: Array

    def columns(self, motion: MotionAtTime) -> tuple[Array, Array]:
        """Return B (6n, k), the generalised force of a unit force of each actuator, and the force (k,) that the scene
        already applies through each."""
        known = forces_known(self.system, motion)
        B = np.stack([known[entry][1]() for entry in self.entries], axis=1)
        return B, self._own_forces(motion)

    def _own_forces(self, motion: MotionAtTime) -> Array:
        forces, instant = self.system.forces, motion.instant(self.system)
        on_bodies, by_name = forces.on_bodies, dict[str, float]()
        if forces.laws.size:
            by_name |= dict(zip(forces.law_owners, law_state(instant).force.tolist(), strict=False))
        if on_bodies.size:
            programs, values = on_bodies.program.ravel().tolist(), given_components(instant).ravel().tolist()
            names = [f"{forces.program_owners[p]}.{'xyz'[row % 3]}" for row, p in enumerate(programs)]
            by_name |= dict(zip(names, values, strict=True))
        return np.array([by_name.get(entry, 0.0) for entry in self.entries])


def actuators(
    system: System, free: System, motion: MotionAtTime, names: Sequence[str], weights: Mapping[str, float]
) -> Actuators:
    """The actuators with these names. `system` is that of the scene, `free` the same without motions. Raises InputError
    for an unknown name, for two actuators on one coordinate, and for a weight without an actuator."""
    known, driven = (
        forces_known(free, motion),
        dict(zip(system.names.motions, system.motions.joint_coordinate, strict=True)),
    )
    entries, problems = [], []
    for name in names:
        if name not in known and name not in driven:
            hint = choose_from(name, [*driven, *known])
            problems.append(Problem(f"there is no actuator '{name}'", Place("--actuator"), hint))
            continue
        entries.append(system.names.coordinates[driven[name]] if name in driven else name)
    twice = next((entry for entry in entries if entries.count(entry) > 1), None)
    if twice is not None:
        problems.append(Problem(f"two actuators act along '{twice}'", Place("--actuator"), "name one of them"))
    for name in weights:
        if name not in names:
            problems.append(Problem(f"'{name}' is no actuator here", Place("--weight"), choose_from(name, names)))
    if problems:
        raise InputError(problems)
    units = tuple(known[entry][0] for entry in entries)
    return Actuators(free, tuple(names), tuple(entries), units, np.array([weights.get(name, 1.0) for name in names]))


# --- Equations of motion for actuators --------------------------------------------------------------------------------
# The equations of motion M u' + Gᵀλ = f + B p on the tangent space, solved for the forces p of actuators.
# With a null space matrix N of G, NᵀB p = Nᵀ(M u' - f). The constraint forces drop out, and constraints may be
# redundant. Of all solutions p the one with the least Σ w p² is taken. Where the actuators are as many as the
# freedoms, there is only one.


#: Actuators move nothing along singular vectors of NᵀB with singular values below this part of its largest column.
DEAD = 1e-8
#: The part of the largest force up to which a missing force is round-off. A freedom with a larger one lacks an
#: actuator.
MISSING = 1e-7


@dataclass(frozen=True, eq=False)
class PowerBalance:
    """The forces (T, k) of actuators, and the rates (T, k) along which they act. `off` (T,) is the error of the power
    balance over the largest power in it. `dead` (T,) tells where the actuators cannot move the mechanism; forces are
    NaN there. `freedom` is the mechanism's number of freedoms, `rank` the number that the actuators reach."""

    force: Array
    rate: Array
    off: Array
    dead: Array
    freedom: int
    rank: int


@dataclass(frozen=True, eq=False)
class _Sample:
    force: Array
    rate: Array
    gained: Array
    left: float
    size: float
    rank: int
    space: TangentSpace
    reached: Array


def balance(actuators: Actuators, motions: Sequence[MotionAtTime]) -> PowerBalance:
    """Compute the forces along a motion. Raises InputError where a freedom needs a force and has no actuator."""
    rubbing = SlidingFrictions(actuators.system, motions)
    samples = [_at(replace(actuators, system=rubbing.at(motion)), motion) for motion in motions]
    rank, freedom = max(sample.rank for sample in samples), samples[0].space.freedom
    size = max(sample.size for sample in samples)
    dead = np.array([sample.rank < rank and sample.left > MISSING * sample.size for sample in samples])
    missing = [sample.left if not gone else 0.0 for sample, gone in zip(samples, dead, strict=True)]
    if max(missing) > MISSING * size:
        raise _without_actuator(actuators.system, samples[int(np.argmax(missing))], motions[-1], rank)
    force = np.array([sample.force for sample in samples])
    rate = np.array([sample.rate for sample in samples])
    force[dead] = np.nan
    gained = np.array([sample.gained for sample in samples])
    put_in = np.where(dead, gained.sum(axis=1), np.sum(force * rate, axis=1))
    largest = max(float(np.abs(gained).max(initial=0.0)), float(np.abs(force * rate)[~dead].max(initial=0.0)))
    off = np.abs(gained.sum(axis=1) - put_in) / (largest or 1.0)
    return PowerBalance(force, rate, off, dead, freedom, rank)


def _at(actuators: Actuators, motion: MotionAtTime) -> _Sample:
    system = actuators.system
    space = tangent_space(system, rows_at(system.rows, motion.pose).dense())
    B, own_forces = actuators.columns(motion)
    weights = np.sqrt(actuators.weights)
    A = (space.N.T @ B) / weights
    wanted = -(space.N.T @ (tangent_force(system, motion) - B @ own_forces))
    U, σ, V = np.linalg.svd(A, full_matrices=False)
    alone = np.linalg.norm(space.lengths[:, None] * B, axis=0) / weights
    rank = int(np.count_nonzero(σ > DEAD * alone.max(initial=0.0)))
    reached = U[:, :rank]
    force = V[:rank].T @ ((reached.T @ wanted) / σ[:rank]) / weights
    left = wanted - A @ (weights * force)
    size = _size(system, motion)
    gained = _power_terms(system, motion, own_forces, B)
    return _Sample(force, B.T @ motion.u, gained, float(np.linalg.norm(left)), size, rank, space, reached)


def _size(system: System, motion: MotionAtTime) -> float:
    """The largest inertial, gravitational or applied force on a body at a sample, N m; forces count at the mechanism's
    length."""
    loads, u_dot = applied(motion.instant(system)), motion.change.reshape(-1, 6)
    inertia = system.mass[:, None] * u_dot[:, :3], (system.inertia @ u_dot[:, 3:, None])[..., 0]
    weight = system.mass[:, None] * system.gravity
    lengths = [inertia[0], weight, loads.force[:-1]]
    turns = [inertia[1], loads.torque[:-1]]
    largest = [system.length * float(np.abs(part).max(initial=0.0)) for part in lengths]
    return max(*largest, *(float(np.abs(part).max(initial=0.0)) for part in turns), float(np.finfo(float).tiny))


def _power_terms(system: System, motion: MotionAtTime, own_forces: Array, B: Array) -> Array:
    """The terms of the power that the actuators supply, W: the changes of kinetic energy by translation, rotation and
    reflected inertias, and the negative powers of gravity and of the scene's other forces. It does not use the tangent
    space."""
    pose = motion.pose
    twist, change = motion.twist(pose), motion.change_of(pose)
    velocity, ω = twist.velocity[:-1], body_rates(pose, twist)[:-1]
    u_dot, loads = motion.change.reshape(-1, 6), applied(motion.instant(system))
    turning = (system.inertia @ u_dot[:, 3:, None])[..., 0]
    rows = system.reflected.rows
    rate = set_velocity(rows, pose, twist)
    faster = set_velocity(rows, pose, change) + set_bias(rows, pose, twist)
    others = np.sum(loads.force * twist.velocity) + np.sum(loads.torque[:-1] * ω)
    return np.array(
        [
            np.sum(system.mass[:, None] * velocity * u_dot[:, :3]),
            np.sum(ω * turning),
            np.sum(system.reflected.inertia * rate * faster),
            -np.sum(system.mass[:, None] * velocity * system.gravity),
            -(others - own_forces @ (B.T @ motion.u)),
        ]
    )


def _without_actuator(system: System, sample: _Sample, motion: MotionAtTime, rank: int) -> InputError:
    """The error for a freedom without an actuator. It names the joint coordinates that move most along such
    freedoms."""
    space = sample.space
    beyond = np.eye(space.freedom) - sample.reached @ sample.reached.T
    G = rows_at(system.coordinates, motion.pose).dense() @ space.N @ beyond
    lengths = np.array([unit == "m" for unit in system.names.coordinate_units], dtype=bool)
    moved = np.linalg.norm(G / np.where(lengths, system.length, 1.0)[:, None], axis=1)
    most = np.argsort(-moved, kind="stable")[: max(1, space.freedom - rank)]
    names = [f"'{system.names.coordinates[k]}'" for k in most if moved[k] > 0.0]
    message = (
        f"the actuators reach {rank} of {space.freedom} degrees of freedom, and the motion needs forces along the "
        f"{'other' if space.freedom - rank == 1 else 'others'}"
    )
    hint = f"add an actuator, along {' and '.join(names)} say" if names else "add an actuator"
    return InputError(Problem(message, Place("--actuator"), hint))


class SlidingFrictions:
    """A system whose dry frictions act as sliding laws, cached by their directions of sliding."""

    def __init__(self, system: System, motions: Iterable[MotionAtTime]) -> None:
        self._system, self._by_directions = system, dict[tuple[float, ...], System]()
        self._fastest = 0.0 if system.frictions is None else max(_speed(system, each) for each in motions)

    def at(self, motion: MotionAtTime) -> System:
        """The system at a sample of the motion, with each friction sliding in its direction there."""
        frictions = self._system.frictions
        if frictions is None:
            return self._system
        rate = set_velocity(frictions.coordinates, motion.pose, motion.twist(motion.pose))
        size = np.where(frictions.coordinates.is_length, self._system.length, 1.0)
        moves = np.abs(rate) > THRESHOLDS.stop_rests * self._fastest * size
        directions = tuple(np.where(moves, np.sign(rate), 0.0).tolist())
        if directions not in self._by_directions:
            sliding = {k: direction for k, direction in enumerate(directions) if direction}
            self._by_directions[directions] = in_contact(self._system, Contacts(sliding=sliding))
        return self._by_directions[directions]


def _speed(system: System, motion: MotionAtTime) -> float:
    """The speed of the fastest part of the mechanism, in its lengths and rad per s."""
    twist = motion.twist(motion.pose)
    return float(np.abs(twist.velocity).max() / system.length + np.abs(body_rates(motion.pose, twist)).max())


# --- The loads of actuators along a motion, which is that of a run or measured ----------------------------------------


_NOTHING: Mapping[str, float] = {}


class Smoothing(NamedTuple):
    """The smoothing of a given column. `noise` is the root mean square change allowed to the spline. `largest` is the
    largest deviation of the closed mechanism from a sample, at the time `time` (s); `rms` is its root mean square. All
    are in `unit`."""

    name: str
    unit: str
    noise: float
    largest: float
    time: float
    rms: float


@dataclass(frozen=True, eq=False)
class ActuatorLoads:
    """The forces of k actuators along a motion. `time` (T,) is in s. `force` and `rate` (T, k) are along the coordinate
    of each, in `units` "N m" or "N", and per s. A force is positive where it increases its coordinate.

    `coordinate` (T, nc) are the joint coordinates of the motion. `freedom` is the mechanism's number of freedoms,
    `rank` the number that the actuators reach. With more actuators than `rank`, Σ w p² is least with the `weights`
    (k,). `balance` is the largest error of the power balance over the largest power in it. `dead` (D,) are times in s
    at which the actuators cannot move the mechanism; their forces are NaN there. `smoothing` describes the given
    columns.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    time: Array
    force: Array
    rate: Array
    coordinates: tuple[str, ...]
    coordinate_units: tuple[str, ...]
    coordinate: Array
    freedom: int
    rank: int
    weights: Array
    balance: float
    dead: Array
    smoothing: tuple[Smoothing, ...] = ()

    @cached_property
    def power(self) -> Array:
        """The power that each actuator supplies, (T, k), in W."""
        return self.force * self.rate

    @property
    def is_shared(self) -> bool:
        """Whether the actuators are more than the freedoms that they reach, so that they share the forces."""
        return len(self.names) > self.rank

    def __getitem__(self, name: str) -> Array:
        """The force of the actuator `name`, (T,). Raises KeyError with the most similar name."""
        if name not in self.names:
            raise KeyError(f"there is no actuator '{name}'; {choose_from(name, self.names)}")
        return self.force[:, self.names.index(name)]

    def cycle(self, over: str) -> Cycle:
        """The joint coordinate `over` of the motion. Raises InputError with the most similar name where there is
        none."""
        if over not in self.coordinates:
            hint = choose_from(over, self.coordinates)
            raise InputError(Problem(f"there is no joint coordinate '{over}'", Place("--over"), hint))
        column = self.coordinates.index(over)
        return Cycle(over, self.coordinate_units[column], self.coordinate[:, column])

    def largest(self, over: str | None = None) -> list[Load]:
        """The largest force and power of each actuator, as `mbproj info --loads` lists them. `over` names the
        coordinate that tells where they occur."""
        alive = ~np.isnan(self.force).any(axis=1)
        cycle = None if over is None else self.cycle(over)
        datasets = {"forces/force": self.force, "forces/rate": self.rate}
        recorded = Recorded(
            {"forces": self.names, "force_units": ["rad" if unit == "N m" else "m" for unit in self.units]},
            lambda path, columns: datasets[path][alive][:, columns],
            self.time[alive],
            self.dead,
            lambda path: None,
        )
        of_alive = None if cycle is None else cycle._replace(values=cycle.values[alive])
        return [load._replace(kind="actuator") for load in loads(recorded, of_alive)]


def loads_of_results(
    scene: Scene, results: Results, names: Sequence[str] = (), weights: Mapping[str, float] = _NOTHING
) -> ActuatorLoads:
    """The loads along the motion that a run of the scene recorded. By default the actuators are the scene's motions."""
    system = compile_system(scene)
    chosen = tuple(names) or system.names.motions
    if not chosen:
        raise _unnamed(system)
    free = replace(system, motions=NO_MOTIONS)
    motions = list(motions_of(free, results))
    if not motions:
        raise InputError(Problem(f"'{results.path}' holds no samples", hint=f"its status: {results.status}"))
    return _loads(system, motions, chosen, weights, states_known=True)


def loads_of_given(
    scene: Scene,
    motion: GivenMotion,
    names: Sequence[str] = (),
    weights: Mapping[str, float] = _NOTHING,
    noise: Mapping[str, float] = _NOTHING,
) -> ActuatorLoads:
    """The loads along a given motion, at its times. `noise` by unit ("rad", "m") is the root mean square change that
    smoothing may make. Where a unit has none, it is estimated.

    By default the actuators are the motions of the scene, or the given joint coordinates where these are as many as the
    degrees of freedom.
    """
    system = compile_system(scene)
    free = replace(system, motions=NO_MOTIONS)
    splines = [
        smoothed(motion.time, values, noise.get(unit))
        for values, unit in zip(motion.values.T, motion.units, strict=True)
    ]
    followed = follow(free, assembled_start(scene, system), motion.names, splines, motion.time)
    chosen = tuple(names) or system.names.motions
    if not chosen:
        if not set(motion.names) <= set(system.names.coordinates):
            raise _unnamed(system)
        chosen = motion.names
    shared = _loads(system, followed.motions, chosen, weights, states_known=False)
    if not names and not system.driven and len(chosen) > shared.freedom:
        raise _unnamed(system)
    changes = [
        Smoothing(
            name,
            unit,
            spline.noise,
            float(np.abs(off).max()),
            float(motion.time[np.argmax(np.abs(off))]),
            float(np.sqrt(np.mean(off**2))),
        )
        for name, unit, spline, off in zip(
            motion.names, motion.units, splines, followed.off.T + [each.change for each in splines], strict=True
        )
    ]
    return replace(shared, smoothing=tuple(changes))


def _unnamed(system: System) -> InputError:
    hint = f"name them: --actuator NAME; {choose_from('', system.names.coordinates, 'joint coordinates are')}"
    return InputError(Problem("it is not said which actuators move the mechanism", Place("--actuator"), hint))


def _loads(
    system: System,
    motions: Sequence[MotionAtTime],
    names: Sequence[str],
    weights: Mapping[str, float],
    *,
    states_known: bool,
) -> ActuatorLoads:
    free = replace(system, motions=NO_MOTIONS)
    for motion in motions:
        refuse_unknown_forces(free, motion, states_known=states_known)
    driving = actuators(system, free, motions[0], names, weights)
    balanced = balance(driving, motions)
    time = np.array([motion.t for motion in motions])
    return ActuatorLoads(
        driving.names,
        driving.units,
        time,
        balanced.force,
        balanced.rate,
        system.names.coordinates,
        system.names.coordinate_units,
        np.array([motion.expected for motion in motions]).reshape(len(motions), -1),
        balanced.freedom,
        balanced.rank,
        driving.weights,
        float(balanced.off.max()),
        time[balanced.dead],
    )


_MOTION = tuple(
    f"bodies/{name}"
    for name in ("position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration")
)


def motions_of(system: System, results: Results) -> Iterator[MotionAtTime]:
    """Yield the motion at each sample. Raises InputError where the results are of other bodies."""
    if tuple(results.names("bodies")) != system.names.bodies:
        said = f"'{results.path}' has other bodies than the scene"
        raise InputError(Problem(said, hint="give results of this scene, or the scene of these results"))
    paths = ("time", *_MOTION, "joints/coordinate", *system.layout.recorded)
    block = {path: results[path] for path in paths}
    for sample in range(len(results.time)):
        state = sampled_state(system, block, sample)
        pose = pose_of(state.q)
        u = tangent_velocities(pose, state.v)
        expected = coordinate_values(system, pose) + 2.0 * np.pi * state.turns
        change = _change(
            system, block["bodies/acceleration"][sample], block["bodies/angular_acceleration"][sample], u, state.q
        )
        yield MotionAtTime(state.t, state.q, u, change, expected, state.x)


def _change(system: System, acceleration: Array, angular: Array, u: Array, q: Array) -> Array:
    """The accelerations u' (6n,) of the carriers, each from the first body fixed to it."""
    first = np.array([np.flatnonzero(system.body_carrier == carrier)[0] for carrier in range(system.bodies)])
    turn, offset = rotation_matrix(system.body_turn[first]), system.body_offset[first]
    ω, ω_dot = u.reshape(-1, 6)[:, 3:], (turn @ angular[first][..., None])[..., 0]
    swung = cross(ω_dot, offset) + cross(ω, cross(ω, offset))
    r_ddot = acceleration[first] - (pose_of(q).rotation[:-1] @ swung[..., None])[..., 0]
    return np.concatenate([r_ddot, ω_dot], axis=1).ravel()


def refuse_unknown_forces(system: System, motion: MotionAtTime, *, states_known: bool) -> None:
    """Raises InputError where forces act that the motion does not determine. These are friction by the load of a
    bearing or at a stop, a stop in contact, and element states that are not given."""
    frictions = system.frictions
    loaded = [] if frictions is None else np.flatnonzero((frictions.bearing >= 0) | (frictions.stop >= 0)).tolist()
    if loaded or (system.forces.laws.bearing >= 0).any():
        name = system.names.frictions[loaded[0]] if loaded else "a bearing's friction"
        message = f"dry friction '{name}' depends on the reactions of joints, which the actuators change"
        raise _refused(message, "drive the scene by motions: mbproj run SCENE, then mbproj info RESULTS --loads")
    if system.states.size and not states_known:
        message = f"state '{system.names.states[0]}' of an element does not follow from a motion"
        raise _refused(message, "run the scene with motions, and give its results")
    if system.stops is not None:
        turns = np.round((motion.expected - coordinate_values(system, motion.pose)) / (2.0 * np.pi)).astype(np.intp)
        gap = gaps(system.stops, motion.pose, turns)
        if gap.min(initial=1.0) <= 0.0:
            touched = system.names.stops[int(np.argmin(gap))]
            message = f"stop '{touched}' is touched at t = {motion.t:.6g} s, and its force is not known"
            raise _refused(message, "give a motion that stays off the stops")


def _refused(message: str, hint: str) -> InputError:
    return InputError(Problem(message, Place("loads"), hint))
