"""The loads of actuators along a motion, which is that of a run or measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, cross
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.dynamics.assembly.assemble import coordinate_values
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime
from mbproj.dynamics.derivatives.tangent import tangent_velocities
from mbproj.dynamics.equations.gaps import gaps
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.linear.equilibrium.started import assembled_start
from mbproj.linear.states import sampled_state
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.system import System
from mbproj.results import Results
from mbproj.results.loads.largest import Cycle, Load, Recorded, loads
from mbproj.scene.read import Scene
from mbproj.studies.inverse.actuators import actuators
from mbproj.studies.inverse.balance import balance
from mbproj.studies.inverse.closed import follow
from mbproj.studies.inverse.given_motion import GivenMotion
from mbproj.studies.inverse.spline import smoothed

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
    given: GivenMotion,
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
        smoothed(given.time, values, noise.get(unit)) for values, unit in zip(given.values.T, given.units, strict=True)
    ]
    followed = follow(free, assembled_start(scene, system), given.names, splines, given.time)
    chosen = tuple(names) or system.names.motions
    if not chosen:
        if not set(given.names) <= set(system.names.coordinates):
            raise _unnamed(system)
        chosen = given.names
    shared = _loads(system, followed.motions, chosen, weights, states_known=False)
    if not names and not system.driven and len(chosen) > shared.freedom:
        raise _unnamed(system)
    changes = [
        Smoothing(
            name,
            unit,
            spline.noise,
            float(np.abs(off).max()),
            float(given.time[np.argmax(np.abs(off))]),
            float(np.sqrt(np.mean(off**2))),
        )
        for name, unit, spline, off in zip(
            given.names, given.units, splines, followed.off.T + [each.change for each in splines], strict=True
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
    own = actuators(system, free, motions[0], names, weights)
    balanced = balance(own, motions)
    time = np.array([motion.t for motion in motions])
    return ActuatorLoads(
        own.names,
        own.units,
        time,
        balanced.force,
        balanced.rate,
        system.names.coordinates,
        system.names.coordinate_units,
        np.array([motion.expected for motion in motions]).reshape(len(motions), -1),
        balanced.freedom,
        balanced.rank,
        own.weights,
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
