"""The system: everything about a mechanism that does not change while it moves, as arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers, numbers
from mbproj.base.cases import cases_in
from mbproj.base.dataclass import brief, dataclass
from mbproj.base.errors import Place
from mbproj.base.thresholds import THRESHOLDS, Thresholds
from mbproj.functions.program_set import ProgramSet, joined
from mbproj.model.channels import (
    NO_ACTIONS,
    NO_CHANNELS,
    NO_ENERGIES,
    NO_MOTIONS,
    NO_SIGNALS,
    NO_STATES,
    Actions,
    Channels,
    ElementStates,
    Energies,
    Motions,
)
from mbproj.model.couplings import NO_FOLLOWERS, Couplings, FollowedCurve, Followers, Touching, compile_couplings
from mbproj.model.forces import NO_FORCES, NO_REFLECTED, Forces, ReflectedInertias
from mbproj.model.layout import Block, Layout, uncontrolled
from mbproj.model.primitive_set import PrimitiveSet, bind, bindings

if TYPE_CHECKING:
    from mbproj.model.contacts import Bearings, Frictions, Stops

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Names:
    """Names in the order of the arrays, and units of some. `carriers` are the moving bodies: a group that fixed joints
    have merged has the name of its first body. `coordinates` are "joint.coordinate". `force_units`, `motion_units`,
    `stop_units` and `friction_units`, m or rad, belong to the coordinates along which forces act, motions drive, stops
    limit and dry frictions resist. `forces` end with reflected inertias, "joint.coordinate.inertia". `stops` are
    "joint.coordinate.low" and "...high", or the name of a force. `frictions` are the name of a force, or
    "force.coordinate". `applied` are forces (unit m) and torques (unit rad) with given components on bodies. `states`
    and `signals` have any unit. `tensions` are those of ropes, "rope.tension_1"; `touching` are joints on curves."""

    bodies: tuple[str, ...]
    carriers: tuple[str, ...]
    joints: tuple[str, ...]
    markers: tuple[str, ...]
    coordinates: tuple[str, ...]
    coordinate_units: tuple[str, ...]
    forces: tuple[str, ...] = ()
    force_units: tuple[str, ...] = ()
    motions: tuple[str, ...] = ()
    motion_units: tuple[str, ...] = ()
    stops: tuple[str, ...] = ()
    stop_units: tuple[str, ...] = ()
    frictions: tuple[str, ...] = ()
    friction_units: tuple[str, ...] = ()
    applied: tuple[str, ...] = ()
    applied_units: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    state_units: tuple[str, ...] = ()
    signals: tuple[str, ...] = ()
    signal_units: tuple[str, ...] = ()
    tensions: tuple[str, ...] = ()
    touching: tuple[str, ...] = ()

    def as_mapping(self) -> dict[str, tuple[str, ...]]:
        """Return the names by kind, as a results file stores them."""
        return {kind: getattr(self, kind) for kind in self.__dataclass_fields__ if kind != "carriers"}


@dataclass(frozen=True, eq=False)
class Conditions:
    """Hard conditions at the start: the values (c,) of the system's coordinates with the numbers `index` (c,)."""

    index: Integers
    value: Array


@dataclass(frozen=True)
class Adjustment:
    """The displacement of a joint's own frame by which loops of rounded numbers close: `shift` in m, `tilt` in rad."""

    joint: str
    shift: float
    tilt: float

    def size(self, length: float) -> float:
        """Return the larger of the shift and of the tilt times this length, in m."""
        return max(self.shift, self.tilt * length)


@dataclass(frozen=True, eq=False)
class System:
    """A mechanism of n rigid carriers, most of which are one body of the scene each; index n is the ground.

    `mass` (n,) in kg, `inertia` (n, 3, 3) in kg m² about the centre of mass in body axes, `gravity` (3,) in m/s².
    `joints`: the constraint rows of all joints; `coordinates`: their free coordinates; `couplings`: rows that couple
    these; `alignment`: scalar products of vectors, positive in a right pose; assembly must not change their signs.
    `body_carrier` (N,), `body_offset` (N, 3), `body_turn` (N, 4): the seats of the scene's N bodies on their carriers.
    `marker_body` (k,), `marker_local` (k, 3). `reaction_body` (nj,), `reaction_local` (nj, 3): body 2 of each joint and
    its point there. `length`: the size of the mechanism in m, to which absolute tolerances are relative. `drawn` (7n,):
    q as the scene draws it. `body_places`, `joint_places`: places in the scene file. `stops`, `frictions` (dry ones
    that can stick) and `bearings` are None without any. `actions`: those of controllers. `channels`: scalars that
    functions name. `signals`: named functions of time and channels. `adjustments`: how far joints were moved."""

    names: Names
    mass: Array
    inertia: Array
    gravity: Array
    joints: PrimitiveSet
    coordinates: PrimitiveSet
    couplings: Couplings
    alignment: PrimitiveSet
    body_carrier: Integers
    body_offset: Array
    body_turn: Array
    marker_body: Integers
    marker_local: Array
    reaction_body: Integers
    reaction_local: Array
    length: float
    drawn: Array
    body_places: tuple[Place | None, ...]
    joint_places: tuple[Place | None, ...]
    forces: Forces = NO_FORCES
    motions: Motions = NO_MOTIONS
    reflected: ReflectedInertias = NO_REFLECTED
    stops: Stops | None = None
    frictions: Frictions | None = None
    bearings: Bearings | None = None
    states: ElementStates = NO_STATES
    energies: Energies = NO_ENERGIES
    actions: Actions = NO_ACTIONS
    channels: Channels = NO_CHANNELS
    signals: ProgramSet = NO_SIGNALS
    adjustments: tuple[Adjustment, ...] = ()
    touching: Touching | None = None
    thresholds: Thresholds = THRESHOLDS

    __repr__ = brief

    def cached(self, what: str, inputs: Sequence[Any], of: Callable[[], Result]) -> Result:
        """Return of(), and keep it under the name `what` until other `inputs` are asked for: studies run one mechanism
        many times from one state. Arrays in `inputs` are compared by their bytes. Without `inputs` the result is a
        constant of the structure. A system does not change, so that nothing invalidates it."""
        if cases_in(inputs) is not None:
            return of()
        key = [each.tobytes() if isinstance(each, np.ndarray) else each for each in inputs]
        last = self._cache.get(what)
        if last is None or last[0] != key:
            self._cache[what] = last = (key, of())
        result: Result = last[1]
        return result

    @cached_property
    def _cache(self) -> dict[str, tuple[list[Any], Any]]:
        return {}

    def __getstate__(self) -> dict[str, Any]:
        """Another process gets a copy without what is kept, because the kernel's objects belong to one process."""
        return {name: value for name, value in self.__dict__.items() if name != "_cache"}

    @cached_property
    def layout(self) -> Layout:
        """The layout of a state."""
        return state_layout(self)

    @cached_property
    def integrated(self) -> Layout:
        """The layout of the vector that a run integrates."""
        return integrated_layout(self)

    @cached_property
    def programs(self) -> ProgramSet:
        """The functions of forces, the rates of states, and the functions of couplings, followers and motions."""
        owners = (self.forces, self.states, self.couplings, self.followers, self.motions)
        return joined([each.programs for each in owners if each is not None])

    @property
    def first_rate(self) -> int:
        """The number in `programs` of the rate of the first state of elements."""
        return self.forces.programs.size

    @property
    def first_coupled(self) -> int:
        """The number in `programs` of the first function of couplings."""
        return self.first_rate + self.states.size

    @cached_property
    def curved(self) -> dict[int, tuple[int, int]]:
        """The row of the joints and the coordinate of each function of couplings, by its number in `programs`."""
        return dict(enumerate(self.couplings.curved, self.first_coupled))

    @cached_property
    def followers(self) -> Followers:
        """The distances from curves among rows, laws and stops."""
        stops = None if self.stops is None else self.stops.coordinates
        sets = (self.joints, self.forces.laws.coordinates, stops, self.coordinates)
        if not any(group.primitive.follows for bound in sets if bound is not None for group in bound.groups):
            return NO_FOLLOWERS
        from mbproj.model.followed import compile_followers

        return compile_followers(*sets)

    @cached_property
    def following(self) -> dict[int, FollowedCurve]:
        """The place of each distance from a curve, by the number of its program in `programs`."""
        return dict(enumerate(self.followers.of, self.first_coupled + self.couplings.programs.size))

    @property
    def forces_name_channels(self) -> bool:
        """Whether a force depends on channels other than the time and its own coordinate."""
        return any(self.programs.names_channels(index) for index in range(self.first_rate))

    @property
    def bodies(self) -> int:
        """n, the number of bodies that move: carriers, without the ground."""
        return len(self.mass)

    @cached_property
    def rows(self) -> PrimitiveSet:
        """The rows of C after the norm rows: the joints', then the motions', each with an owner of its own."""
        if not self.driven:
            return self.joints
        coordinates, first = bindings(self.coordinates), len(self.names.joints)
        driven = enumerate(self.motions.joint_coordinate.tolist(), first)
        return bind([*bindings(self.joints), *(replace(coordinates[at], owner=owner) for owner, at in driven)])

    @cached_property
    def is_velocity(self) -> Flags:
        """Whether each row of C is at velocity level, (m,); the value of such a row is 0."""
        return np.pad(self.joints.is_velocity, (self.bodies, self.driven))

    @property
    def rolls(self) -> bool:
        """Whether the joints have rows at velocity level."""
        return bool(self.joints.is_velocity.any())

    @cached_property
    def at_positions(self) -> System:
        """The system with its rows at position level alone, which determine the admissible poses."""
        if not self.rolls:
            return self
        joints = [each for each in bindings(self.joints) if each.primitive.integrable]
        return replace(self, joints=bind(joints), couplings=compile_couplings(joints, bindings(self.coordinates)))

    @property
    def constraints(self) -> int:
        """The number of rows of C: one norm row a body, then the joints' rows (Eq. 3), then one a motion."""
        return self.bodies + self.joints.size + self.driven

    @property
    def has_contacts(self) -> bool:
        """Whether there are stops or dry frictions, which change the equations during a run."""
        return self.stops is not None or self.frictions is not None

    @property
    def driven(self) -> int:
        """The number of motions, whose rows are the last of C."""
        return self.motions.size

    @cached_property
    def row_scale(self) -> Array:
        """The scale of each row of C, (m,): `length` for rows in metres, 1 for the others."""
        return np.concatenate([np.ones(self.bodies), np.where(self.rows.is_length, self.length, 1.0)])

    def row_owner(self, row: int) -> str:
        """Return the owner of a row of C, for messages: "joint 'A'", "motion 'm'", or "Euler parameters of 'rod'". Rows
        of stops and frictions in contact follow the last row: "stop 'A.angle.low'"."""
        if row >= self.constraints:
            stop, friction = row - self.constraints, row - self.constraints - len(self.names.stops)
            return (
                f"friction '{self.names.frictions[friction]}'" if friction >= 0 else f"stop '{self.names.stops[stop]}'"
            )
        if row >= self.bodies + self.joints.size:
            return f"motion '{self.names.motions[row - self.bodies - self.joints.size]}'"
        if row < self.bodies:
            return f"Euler parameters of '{self.names.carriers[row]}'"
        return f"joint '{self.names.joints[self.joints.owner[row - self.bodies]]}'"


def state_layout(system: System) -> Layout:
    """Return the layout of a state of a system, from which a run can begin."""
    return Layout((*_motion(system), uncontrolled("turns", system.coordinates.size), _states(system)))


def integrated_layout(system: System) -> Layout:
    """Return the layout of the vector that a run integrates: blocks whose errors are controlled come first.

    The quadratures are the work of forces and motions, the energy that dampers lose, and separate losses of laws. All
    joint coordinates are integrated where forces, functions or couplings use angles, so that each stage knows the
    turns."""
    laws = system.forces.laws
    quadratures = 0 if system.forces.is_empty and not system.driven else 2 + int(laws.apart.sum())
    of_angles = ~system.coordinates.is_length[system.channels.index[~system.channels.is_state]]
    asked = system.couplings.size or of_angles.any() or bool(laws.is_angle.any())
    followed = system.coordinates.size if asked else 0
    beside = (uncontrolled("quadratures", quadratures), uncontrolled("followed", followed))
    return Layout((*_motion(system), _states(system), *beside))


def _motion(system: System) -> tuple[Block, Block]:
    """Return the blocks of q and of q'."""
    scale = numbers(([system.length] * 3 + [1.0] * 4) * system.bodies)
    units = (("m",) * 3 + ("1",) * 4) * system.bodies
    return (
        Block("positions", scale, projected=True, units=units),
        Block("velocities", scale, projected=True, units=tuple(f"{unit}/s" for unit in units)),
    )


def _states(system: System) -> Block:
    """Return the block of the states of elements."""
    x, names = system.states, system.names
    return Block("states", x.scale, x.start, dataset="states/value", names=names.states, units=names.state_units)
