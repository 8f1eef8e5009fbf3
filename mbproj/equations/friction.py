"""Dry friction at a state: loads that are not unique, forces that are functions, the loads of bearings that rub, and
the recorded quantities of stops and frictions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from types import MappingProxyType

import numpy as np

from mbproj.base.arrays import Array, Flags, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.bearings import Supports, load, slopes, supports
from mbproj.equations.constraints import set_velocity
from mbproj.equations.contacts import pressing
from mbproj.equations.gaps import gap_rates, gaps
from mbproj.equations.kinematics import Pose, Twist, pose_of
from mbproj.equations.rank.nearby import nearby
from mbproj.equations.rank.row_space import self_stresses
from mbproj.equations.reactions import reactions
from mbproj.equations.samples import Samples
from mbproj.functions.series import run
from mbproj.model.contacts import Bearings, Frictions, Stops
from mbproj.model.system import System

# --- Friction that depends on a reaction which is not unique: redundant rows can share the load in any proportion -----


def refuse_shared_loads(system: System, state: State) -> None:
    """Raises InputError that names each friction whose bearing shares its load with others, and with which."""
    if system.bearings is not None:
        problems = _problems_nearby(system, system.bearings, state.q.tobytes())
        if problems:
            raise InputError(list(problems))


@lru_cache(maxsize=64)
def _problems_nearby(system: System, bearings: Bearings, q: bytes) -> tuple[Problem, ...]:
    """The problems at a pose q and at poses nearby. The result is cached: studies run a mechanism many times from one
    start."""
    start = np.frombuffer(q)
    near = nearby(system, start).poses if system.bodies <= THRESHOLDS.few_bodies else ()
    sharing = np.zeros((bearings.size, len(system.names.joints)), dtype=bool)
    for pose in (pose_of(start), *near):
        sharing |= _sharing(system, bearings, pose)
    return tuple(_described(system, bearings, sharing))


def _sharing(system: System, bearings: Bearings, pose: Pose) -> Flags:
    """Which joints each bearing shares its load with, (B, nj)."""
    stresses = self_stresses(system, pose)
    force, torque = reactions(system, pose, stresses)
    size: Array = np.linalg.norm(force, axis=-1) * system.length + np.linalg.norm(torque, axis=-1)
    size = size / np.maximum(size.max(axis=-1, keepdims=True, initial=0.0), np.finfo(float).tiny)
    arbitrary = load(bearings, supports(system, bearings, pose, stresses)) - bearings.preload
    arms = np.maximum(bearings.radial, bearings.axial)
    shared = arbitrary * system.length > THRESHOLDS.no_part * arms
    return np.array(
        [(size[shared[:, b]] > THRESHOLDS.no_part).any(axis=0) for b in range(bearings.size)], dtype=bool
    ).reshape(bearings.size, -1)


def _described(system: System, bearings: Bearings, sharing: Flags) -> Iterator[Problem]:
    """A problem for each bearing that shares its load."""
    frictions, forces = system.frictions, system.forces
    for b in np.flatnonzero(sharing.any(axis=1)):
        place = None
        if frictions is not None and b in frictions.bearing:
            k = int(np.flatnonzero(frictions.bearing == b)[0])
            owner, place = frictions.owners[k], frictions.places[k]
        else:
            owner = f"force '{forces.law_owners[int(np.flatnonzero(forces.laws.bearing == b)[0])]}'"
        joint = int(bearings.joint[b])
        others = ", ".join(f"'{name}'" for j, name in enumerate(system.names.joints) if sharing[b, j] and j != joint)
        message = (
            f"{owner} depends on the load of joint '{system.names.joints[joint]}', which is not unique: "
            f"redundant constraints can share it in any proportion with {others}"
        )
        hint = "free a direction in one of these joints that the others hold, as a spherical or cylindrical joint does"
        yield Problem(message, place, hint)


# --- The static and sliding forces of dry frictions at a state, where they are functions ------------------------------


def frictions_at(system: System, state: State) -> Frictions:
    """The frictions of a system that has some, with their sliding and static forces at a state as numbers."""
    frictions = system.frictions
    assert frictions is not None
    if not frictions.varies:
        return frictions
    sliding, static = frictions.sliding.copy(), frictions.static.copy()
    forces, which = _forces(system, frictions, state), list(frictions.varies)
    sliding[which], static[which] = forces[:, 0], forces[:, 1]
    return replace(frictions, sliding=sliding, static=static)


def _forces(system: System, frictions: Frictions, state: State) -> Array:
    """The sliding and static forces of the k frictions that change, (k, 2)."""
    programs, variables = frictions.programs, state.instant(system).variables()
    return np.array([float(run(programs, at, variables)[0]) for at in range(programs.size)]).reshape(-1, 2)


# --- The loads of bearings, where friction is proportional to the load and is part of the load ------------------------
# The multipliers are linear in the forces. f₀ are the supports without friction, f the response to the friction of
# each bearing. Newton's method solves L = load(f₀ + Σ L f) for the loads L. Where friction is so strong that a load
# may grow by more than itself, there is no solution, or there are two (Painlevé 1895).


class Jammed(Exception):
    """The loads are not unique. `bearing`: the number of the bearing whose friction is strongest."""

    def __init__(self, bearing: int) -> None:
        super().__init__(f"bearing {bearing} jams")
        self.bearing = bearing


def settled_loads(bearings: Bearings, base: Supports, responses: Supports) -> Array:
    """The loads L (B,) of the bearings. Raises Jammed.

    `base` (B, 3) are the supports without friction. `responses` (B, B, 3) are those to the friction of one bearing
    under a load of 1; the first axis counts the bearing with this friction."""
    _refuse_jammed(bearings, base, responses)
    L = np.zeros(bearings.size)
    for _ in range(THRESHOLDS.most_passes):
        loaded = base.plus(responses, L)
        jacobian = np.eye(bearings.size) - slopes(bearings, loaded, responses)
        change = np.linalg.solve(jacobian, L - load(bearings, loaded))
        L = L - change
        if np.abs(change).max() <= THRESHOLDS.no_digits * np.abs(L).max():
            break
    return L


def _refuse_jammed(bearings: Bearings, base: Supports, responses: Supports) -> None:
    """Raises Jammed unless the loads have a unique solution. The load of a one-sided bearing may shrink by any amount:
    only its growth counts."""
    largest = (load(bearings, responses) - bearings.preload).T
    pushing = np.maximum(slopes(bearings, base, responses), 0.0)
    growth = np.where(bearings.is_push[:, None], pushing, largest)
    if not grows_bounded(growth):
        raise Jammed(int(np.argmax(np.diagonal(growth))))


def grows_bounded(growth: Array) -> bool:
    """Whether no loads grow by more than themselves. `growth` (B, B) is the most by which each load grows with each
    other one. The answer is yes where (I - growth) x = 1 has a positive solution, and only there."""
    try:
        x = np.linalg.solve(np.eye(len(growth)) - growth, np.ones(len(growth)))
    except np.linalg.LinAlgError:
        return False
    return bool((x > 0.0).all())


# --- Recorded quantities of stops and of dry frictions ----------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ContactsSeen:
    """The quantities of stops and frictions at T samples, by the paths of their datasets."""

    system: System
    samples: Samples
    pose: Pose
    twist: Twist

    def __getitem__(self, path: str) -> Numbers:
        """Return the values (T, S) of stops or (T, K) of frictions. Raises KeyError for a path that is not in
        `contact_paths`."""
        stops, frictions = self.system.stops, self.system.frictions
        if stops is not None and path in OF_STOPS:
            return OF_STOPS[path](self, stops)
        if frictions is not None and path in OF_FRICTIONS:
            return OF_FRICTIONS[path](self, frictions)
        raise KeyError(path)

    def pushes(self, stops: Stops) -> Numbers:
        """Return the push of each stop, (T, S), from the run. For a state at rest it follows from the gaps of compliant
        stops."""
        if self.samples.press is not None:
            return self.samples.press()
        gap = self["stops/gap"]
        return pressing(stops, np.zeros(stops.size), gap, np.zeros_like(gap))

    @cached_property
    def rubs(self) -> tuple[Array, Array]:
        """The force and the state of each dry friction, (T, K), from the run; 0 for a state at rest."""
        if self.samples.rub is not None:
            return self.samples.rub()
        none = np.zeros((len(self.samples.t), len(self.system.names.frictions)))
        return none, none


def contact_paths(system: System) -> tuple[str, ...]:
    """Return the paths of the datasets of stops and frictions that a mechanism has."""
    stops = OF_STOPS if system.stops is not None else ()
    return (*stops, *(OF_FRICTIONS if system.frictions is not None else ()))


#: The datasets of stops.
OF_STOPS: Mapping[str, Callable[[ContactsSeen, Stops], Numbers]] = MappingProxyType(
    {
        "stops/gap": lambda seen, stops: gaps(stops, seen.pose, seen.samples.turns),
        "stops/rate": lambda seen, stops: gap_rates(stops, seen.pose, seen.twist),
        "stops/force": lambda seen, stops: seen.pushes(stops),
    }
)

#: The datasets of dry frictions that can stick.
OF_FRICTIONS: Mapping[str, Callable[[ContactsSeen, Frictions], Numbers]] = MappingProxyType(
    {
        "friction/rate": lambda seen, frictions: set_velocity(frictions.coordinates, seen.pose, seen.twist),
        "friction/force": lambda seen, _: seen.rubs[0],
        "friction/state": lambda seen, _: seen.rubs[1],
        "friction/dissipation": lambda seen, _: seen.samples.work[:, 2:],
    }
)
