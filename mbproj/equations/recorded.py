"""Converts samples to the content of a results file: poses, velocities, reactions, violations, energies.

Each quantity is computed on first use, for all samples of a block at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property, partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias, final

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers, Numbers, contiguous, may_overflow
from mbproj.equations.assembly.assemble import State, coordinate_values, is_angle
from mbproj.equations.constraints import constraint, constraint_acceleration, constraint_velocity, set_velocity
from mbproj.equations.energy import EnergyAtStart, account, kinetic_energy, stored
from mbproj.equations.forces import LawState, law_state
from mbproj.equations.instant import Instant, of_signals
from mbproj.equations.kinematics import (
    Pose,
    Twist,
    attached,
    attached_bias,
    attached_velocity,
    body_rates,
    pose_of,
    twist_of,
)
from mbproj.equations.motions import Drive
from mbproj.equations.reactions import applied_seen, reactions_with_teeth
from mbproj.equations.samples import Samples, join, keep_freed_memory
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System

if TYPE_CHECKING:
    from mbproj.equations.friction import ContactsSeen

#: Values of T samples by the path of their dataset; the first axis is time.
Block: TypeAlias = Mapping[str, npt.NDArray[Any]]


@final
class Observer:
    """The part that all blocks of a run share: energy balance and teeth of gears count from its `start`."""

    def __init__(self, system: System, start: State) -> None:
        keep_freed_memory()
        self.system, self.start = system, EnergyAtStart(system, start)

    def at(self, samples: Samples) -> Observation:
        """Return all recorded quantities at some samples."""
        return Observation(self, samples)


def _coordinates(system: System, pose: Pose, samples: Samples) -> Numbers:
    """Return the joints' coordinates with turns, (T, nc)."""
    return coordinate_values(system, pose) + 2.0 * np.pi * samples.turns * is_angle(system)


@final
class Observation(Mapping[str, npt.NDArray[Any]]):
    """All recorded quantities at T samples, by the path of the dataset. Overflow at the end of a diverged run is
    recorded as it is.

    Internally, time is the innermost axis in memory. Then NumPy sums over other axes in the same order for blocks of
    any length, and quickly. An axis of length 1 has no such order, so a single sample is computed as two equal ones."""

    def __init__(self, observer: Observer, samples: Samples) -> None:
        self.observer, self.system, self.samples = observer, observer.system, samples
        self._seen = samples if len(samples.t) > 1 else join([samples, samples])
        self._datasets: dict[str, npt.NDArray[Any]] = {}

    def __getitem__(self, path: str) -> npt.NDArray[Any]:
        if path not in self._datasets:
            with may_overflow():
                self._datasets[path] = contiguous(self._computed(path)[: len(self.samples.t)])
        return self._datasets[path]

    def __iter__(self) -> Iterator[str]:
        yield from QUANTITIES
        yield from (*self.contact_paths, *self.given_datasets, *self.system.layout.recorded)
        yield from (COUNTERS + name for name in self._seen.counters)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _computed(self, path: str) -> npt.NDArray[Any]:
        if path in QUANTITIES:
            return QUANTITIES[path](self)
        if path in self.contact_paths:
            return self.contacts[path]
        if path in self.given_datasets:
            return self.given_datasets[path]
        block, seen = self.system.layout.recorded.get(path), self._seen
        return seen.counters[path.removeprefix(COUNTERS)] if block is None else seen.y[:, self.system.layout[block]]

    @cached_property
    def pose(self) -> Pose:
        return pose_of(self._seen.motion.q)

    @cached_property
    def twist(self) -> Twist:
        return twist_of(self.pose, self._seen.motion.v)

    @cached_property
    def change(self) -> Twist:
        """The accelerations, as a `Twist` that holds q'' in place of q'."""
        return twist_of(self.pose, self._seen.motion.acceleration)

    @cached_property
    def contacts(self) -> ContactsSeen:
        """The quantities of stops and dry frictions."""
        from mbproj.equations.friction import ContactsSeen

        return ContactsSeen(self.system, self._seen, self.pose, self.twist)

    @cached_property
    def contact_paths(self) -> tuple[str, ...]:
        """The paths of the datasets of stops and dry frictions; empty without any."""
        if not self.system.has_contacts:
            return ()
        from mbproj.equations.friction import contact_paths

        return contact_paths(self.system)

    @property
    def coordinate(self) -> Numbers:
        """The joints' coordinates with turns, (T, nc)."""
        return self.instant.expected

    @cached_property
    def drive(self) -> Drive:
        return self.observer.start.drive(self._seen.t, self.coordinate)

    @cached_property
    def C(self) -> Numbers:
        """The violations of all rows, (T, m)."""
        return constraint(self.system, self.pose, self.drive)

    @cached_property
    def carried(self) -> Numbers | None:
        """The loads of bearings, (T, B), where a law of the scene depends on them; else None."""
        bearings, forces = self.system.bearings, self.system.forces
        if bearings is None or not (forces.laws.bearing >= 0).any():
            return None
        from mbproj.equations.bearings import load, supports

        return load(bearings, supports(self.system, bearings, self.pose, self._seen.multipliers))

    @cached_property
    def instant(self) -> Instant:
        # `partial`, not a method of this object: a circle of references would keep all arrays of a block for long.
        counted = partial(_coordinates, self.system, self.pose, self._seen)
        return Instant(self.system, self.pose, self.twist, self._seen.t, counted, self._seen.x)

    @cached_property
    def laws(self) -> LawState:
        return law_state(self.instant, carried=self.carried)

    @cached_property
    def law_values(self) -> tuple[Numbers, ...]:
        """Coordinate, rate and force of the laws, and then of the reflected inertias."""
        laws = self.laws
        if not self.system.reflected.size:
            return laws.value, laws.rate, laws.force
        from mbproj.equations.of_motion import inertial_reaction

        turned = inertial_reaction(self.system.reflected, self.pose, self.twist, self.change)
        value = self.coordinate[:, self.system.reflected.joint_coordinate]
        pairs = (laws.value, value), (laws.rate, turned.rate), (laws.force, turned.force)
        return tuple(np.concatenate(pair, axis=-1) for pair in pairs)

    @cached_property
    def given_datasets(self) -> Mapping[str, Numbers]:
        """Given forces and torques, signals, and tensions, by dataset, where there are some."""
        blocks = {**applied_seen(self.instant)} if self.system.forces.on_bodies.size else {}
        blocks |= {"signals/value": of_signals(self.instant)} if self.system.signals.size else {}
        if not self.system.names.tensions and self.system.touching is None:
            return blocks
        from mbproj.equations.tensions import on_paths

        return blocks | on_paths(self.system, self.pose, self._seen, lambda: self.contacts["stops/force"])

    @cached_property
    def reactions(self) -> tuple[Numbers, Numbers]:
        return reactions_with_teeth(self.system, self.pose, self._seen.multipliers)

    def open_by(self, *, length: bool) -> Numbers:
        """Return the largest violation of each joint's rows of lengths, or of angles, (T, nj)."""
        joints = self.system.joints
        rows = np.abs(self.C[:, self.system.bodies :][:, : joints.size])
        return _largest_by_joint(self.system, np.where(joints.is_length == length, rows, 0.0))

    def points(self, kind: str) -> tuple[Integers, Array]:
        """Return the carriers of markers or bodies, and their places on these."""
        system = self.system
        if kind == "markers":
            return system.marker_body, system.marker_local
        return system.body_carrier, system.body_offset

    def position(self, kind: str) -> Numbers:
        """Return the positions of markers or bodies, (T, k, 3)."""
        body, local = self.points(kind)
        return attached(self.pose, body, local, np.ones(len(body)))

    def velocity(self, kind: str) -> Numbers:
        """Return the velocities of markers or bodies, (T, k, 3)."""
        body, local = self.points(kind)
        return attached_velocity(self.twist, body, local, np.ones(len(body)))

    def acceleration(self, kind: str) -> Numbers:
        """Return the accelerations of markers or bodies, (T, k, 3)."""
        body, local = self.points(kind)
        return attached_velocity(self.change, body, local, np.ones(len(body))) + attached_bias(self.twist, body, local)

    def turning(self, change: Twist) -> Numbers:
        """Return ω of each body in its own axes, (T, N, 3); or ω' = 2 L Λ'' (because L' Λ' = 0) for accelerations."""
        to_body = np.swapaxes(rotation_matrix(self.system.body_turn), -1, -2)
        rates: Numbers = body_rates(self.pose, change)[:, self.system.body_carrier, :, None]
        return (to_body @ rates)[..., 0]

    def orientation(self) -> Numbers:
        """Return the Euler parameters of each body, (T, N, 4)."""
        return product(self.pose.orientation[:, self.system.body_carrier], self.system.body_turn)

    def motion_force(self) -> Numbers:
        """Return the force of each motion along its coordinate, -λ (Eq. 10); the motions' rows are the last."""
        return -self._seen.multipliers[:, self._seen.multipliers.shape[1] - self.system.driven :]

    def driven(self, name: str) -> Numbers:
        """Return the value or rate of each motion, (T, k)."""
        return np.asarray(getattr(self.drive, name))

    def stored(self) -> Numbers:
        """Return V of gravity, springs and compliant stops, (T,)."""
        return stored(self.instant, self.laws, lambda: self._seen.turns)

    @cached_property
    def work(self) -> tuple[Numbers, Numbers]:
        """W and D, (T,): the work done on the mechanism and the energy dissipated since the start."""
        return account(self.instant, self.observer.start.of_elements, self._seen.work)

    def balance(self) -> Numbers:
        """Return E(t) - E(0) - W + D, (T,)."""
        return self["diagnostics/total_energy"] - self.observer.start.energy - self.work[0] + self.work[1]


#: The prefix of counters, and the other quantities by dataset.
COUNTERS = "diagnostics/"
QUANTITIES: Mapping[str, Callable[[Observation], npt.NDArray[Any]]] = MappingProxyType(
    {
        "time": lambda seen: seen.samples.t,
        "bodies/position": lambda seen: seen.position("bodies"),
        "bodies/velocity": lambda seen: seen.velocity("bodies"),
        "bodies/acceleration": lambda seen: seen.acceleration("bodies"),
        "bodies/orientation": Observation.orientation,
        "bodies/angular_velocity": lambda seen: seen.turning(seen.twist),
        "bodies/angular_acceleration": lambda seen: seen.turning(seen.change),
        "markers/position": lambda seen: seen.position("markers"),
        "markers/velocity": lambda seen: seen.velocity("markers"),
        "markers/acceleration": lambda seen: seen.acceleration("markers"),
        "joints/violation": lambda seen: np.maximum(seen["joints/violation_length"], seen["joints/violation_angle"]),
        "joints/violation_length": lambda seen: seen.open_by(length=True),
        "joints/violation_angle": lambda seen: seen.open_by(length=False),
        "joints/reaction_force": lambda seen: seen.reactions[0],
        "joints/reaction_torque": lambda seen: seen.reactions[1],
        "joints/coordinate": lambda seen: seen.coordinate,
        "joints/speed": lambda seen: set_velocity(seen.system.coordinates, seen.pose, seen.twist),
        "forces/coordinate": lambda seen: seen.law_values[0],
        "forces/rate": lambda seen: seen.law_values[1],
        "forces/force": lambda seen: seen.law_values[2],
        "motions/value": lambda seen: seen.driven("value"),
        "motions/rate": lambda seen: seen.driven("rate"),
        "motions/force": Observation.motion_force,
        "diagnostics/kinetic_energy": lambda seen: kinetic_energy(seen.system, seen.pose, seen.twist),
        "diagnostics/potential_energy": Observation.stored,
        "diagnostics/total_energy": lambda seen: (
            seen["diagnostics/kinetic_energy"] + seen["diagnostics/potential_energy"]
        ),
        "diagnostics/work": lambda seen: seen.work[0],
        "diagnostics/dissipation": lambda seen: seen.work[1],
        "diagnostics/energy_balance": Observation.balance,
        "diagnostics/position_violation": lambda seen: np.abs(seen.C).max(axis=-1),
        "diagnostics/velocity_violation": lambda seen: np.abs(
            constraint_velocity(seen.system, seen.pose, seen.twist, seen.drive)
        ).max(axis=-1),
        "diagnostics/acceleration_violation": lambda seen: np.abs(
            constraint_acceleration(seen.system, seen.pose, seen.twist, seen.change, seen.drive)
        ).max(axis=-1),
        "diagnostics/step_size": lambda seen: seen.samples.step_size,
    }
)


def _largest_by_joint(system: System, rows: Numbers) -> Numbers:
    """Return the largest of each joint's consecutive rows, (..., m) to (..., nj); 0 for a joint without rows."""
    largest = np.zeros((*rows.shape[:-1], len(system.names.joints)), like=rows)
    owner, first = np.unique(system.joints.owner, return_index=True)
    largest[..., owner] = np.maximum.reduceat(rows, first, axis=-1)
    return largest
