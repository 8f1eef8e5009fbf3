"""What dry frictions do from a state on: which stick, which slide and where to; with the stops that touch there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Free, Freedom
from mbproj.dynamics.contact.impact import Rubbing
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.gaps import counted_values
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.dynamics.friction.balance import Balanced, FrictionBalance, NoFrictionBalance, balanced
from mbproj.dynamics.friction.changing import frictions_at, sliding_forces
from mbproj.dynamics.friction.loads import grows_bounded
from mbproj.dynamics.friction.shares import held_by
from mbproj.dynamics.observe.bearings import Supports, load, supports
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.stops.failures import finds_no_balance
from mbproj.model.contacts import Contacts
from mbproj.model.frictions import Frictions
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Rubbed:
    """How hard the stops that touch push, (S,), and which of them are `held`; the frictions as `Contacts` has them; and
    the `force` of each along its coordinate with the largest, `most`, that it can have at rest, (K,), in N or N m."""

    push: Array
    held: Contacts
    force: Array
    most: Array
    sliding: Mapping[int, float]
    stuck: Mapping[int, float]
    bearing: Mapping[int, float]
    straight: frozenset[int] = frozenset()
    starting: frozenset[int] = frozenset()


def friction_sizes(system: System) -> Array:
    """What the coordinates of frictions are measured against, (K,): the mechanism's length in m, and 1 rad."""
    assert system.frictions is not None
    return np.where(system.frictions.coordinates.is_length, system.length, 1.0)


def friction_rates(system: System, state: State) -> Array:
    """s' of the frictions, (K,)."""
    assert system.frictions is not None
    pose = pose_of(state.q)
    return np.asarray(set_velocity(system.frictions.coordinates, pose, twist_of(pose, state.v)))


def at_rest(system: System, state: State, contacts: Contacts, met: int | None, fastest: float) -> Flags:
    """Which frictions do not slide, (K,): one that is `met` at rest, and what is no faster than that or than round-off
    beside the `fastest` motion of the run, 1/s. What sticks does."""
    frictions = system.frictions
    assert frictions is not None
    rate, size = _with_partner(frictions, friction_rates(system, state)), friction_sizes(system)
    slow = THRESHOLDS.stop_rests * fastest
    if met is not None:
        found = float(rate[met] / size[met])
        if frictions.partner[met] < 0 or found < THRESHOLDS.turned_speed * fastest:
            slow = max(slow, 8.0 * found)
    rests = rate <= slow * size
    rests[[*contacts.stuck, *contacts.bearing]] = True
    return np.asarray(rests)


def at_exact_rest(freedom: Freedom, state: State, touches: Integers, rests: Flags, fastest: float) -> State:
    """The state in which what rests does not move at all: methods that do not project leave more than round-off."""
    system, frictions, stops = freedom.system, freedom.system.frictions, freedom.system.stops
    assert frictions is not None
    still = rests & ((frictions.stop < 0) | np.isin(frictions.stop, touches))
    rate, slow = friction_rates(system, state)[still], THRESHOLDS.stop_rests * fastest * friction_sizes(system)[still]
    if (np.abs(rate) <= slow).all():
        return state
    rows = freedom.rows_of(frictions.coordinates)[still]
    if stops is not None:
        rows = np.vstack([rows, freedom.rows(stops)[touches]])
    wanted = np.append(-rate, np.zeros(len(rows) - len(rate)))
    x: Array = np.array(np.linalg.lstsq(rows, wanted, rcond=THRESHOLDS.no_push)[0], dtype=float)
    return state.changed(velocities=state.v + freedom.changed(x))


def _with_partner(frictions: Frictions, rate: Array) -> Array:
    """The speed along each, of those in a plane of both together, (K,)."""
    across = np.where(frictions.partner >= 0, rate[frictions.partner], 0.0)
    return np.hypot(rate, across)


def rubbed(
    freedom: Freedom,
    free: Free,
    state: State,
    contacts: Contacts,
    touches: Integers,
    rests: Flags,
    fastest: float = 0.0,
) -> Rubbed:
    """At a state at which the stops of these numbers touch, and these frictions are at rest, (K,). Raises
    SimulationError where neither sliding nor sticking is possible."""
    system, frictions = freedom.system, freedom.system.frictions
    assert frictions is not None
    rubs = np.flatnonzero((frictions.stop < 0) | np.isin(frictions.stop, touches))
    rate = np.where(rests, 0.0, friction_rates(system, state))
    speed = _with_partner(frictions, rate)
    problem = _problem(freedom, free, state, touches, rubs, rate, speed, fastest)
    found = _balance(problem, state.t, system, rubs)
    push = np.zeros(len(system.names.stops))
    push[touches] = found.y[: len(touches)]
    force, most = np.zeros(frictions.size), np.zeros(frictions.size)
    force[rubs], most[rubs] = found.y[len(touches) :], problem.static * problem.loads(found.y)
    kept = {k for k in rubs.tolist() if frictions.stop[k] < 0 or push[frictions.stop[k]] > 0.0}  # no push, no friction
    parts = _as_contacts(frictions, state, contacts, found, rubs)
    sliding, stuck, bearing = ({k: x for k, x in part.items() if k in kept} for part in parts)
    slow = THRESHOLDS.straight_speed * fastest * friction_sizes(system)
    slowly = {k for k in sliding if int(frictions.partner[k]) in sliding and speed[k] <= 2.0 * slow[k]}
    stops_soon = _stops_soon(frictions, rate, problem.accelerations(found.y)[len(touches) :], rubs)
    straight = frozenset(k for k in slowly if stops_soon[k])
    return Rubbed(
        push,
        held_by(push, touches, found.shares),
        force,
        most,
        sliding,
        stuck,
        bearing,
        straight,
        frozenset(slowly - straight),
    )


def _problem(
    freedom: Freedom,
    free: Free,
    state: State,
    touches: Integers,
    rubs: Integers,
    rate: Array,
    speed: Array,
    fastest: float,
) -> FrictionBalance:
    """What stops that touch and frictions that count have to fulfil, where these slide with a rate, (K,), and the
    `fastest` motion so far was that, 1/s."""
    stops, frictions = freedom.system.stops, frictions_at(freedom.system, state)
    along = frictions.coordinates
    A, gradients = freedom.rows_of(along)[rubs], freedom.gradients_of(along)[rubs]
    b = freedom.accelerations_of(along, free)[rubs]
    if stops is not None and len(touches):
        A = np.vstack([freedom.rows(stops)[touches], A])
        gradients = np.vstack([freedom.gap_gradients(stops)[touches], gradients])
        b = np.concatenate([freedom.gap_accelerations(stops, free)[touches], b])
    return FrictionBalance(
        A=A,
        b=b,
        static=frictions.static[rubs],
        sliding=sliding_forces(frictions, speed)[rubs],
        direction=(rate / np.where(speed > 0.0, speed, 1.0))[rubs],
        partner=_among(frictions.partner, rubs),
        stop=_among_touching(frictions.stop[rubs], touches),
        loads=_Loads(freedom, free, gradients, touches, rubs),
        still=(THRESHOLDS.rest_acceleration * fastest**2 * friction_sizes(freedom.system))[rubs],
    )


def _balance(problem: FrictionBalance, t: float, system: System, rubs: Integers) -> Balanced:
    """Its solution. Raises SimulationError that names the frictions where there is none, or not one alone."""
    if (names := _jams(problem)) is not None:
        raise finds_no_balance(t, system, rubs[names])
    try:
        return balanced(problem)
    except NoFrictionBalance as error:
        raise finds_no_balance(t, system, rubs[error.frictions] if len(error.frictions) else rubs) from error


def _stops_soon(frictions: Frictions, rate: Array, acceleration: Array, rubs: Integers) -> Flags:
    """Which frictions slide in a plane and become slower, (K,)."""
    change = np.zeros(frictions.size)
    change[rubs] = rate[rubs] * acceleration
    change += np.where(frictions.partner >= 0, change[frictions.partner], 0.0)
    return np.asarray(change < 0.0)


def _jams(problem: FrictionBalance) -> Integers | None:
    """The frictions whose sliding has no unique solution, where all slide and no stop touches; None where it has."""
    loads = problem.loads
    if problem.stops or problem.rests.any() or not isinstance(loads, _Loads):
        return None
    growth = loads.growth(np.abs(problem.direction) * problem.sliding)
    if growth is None or grows_bounded(growth):
        return None
    return np.flatnonzero(loads.goes_by(int(np.argmax(np.diagonal(growth)))))


def rubbing_of(freedom: Freedom, state: State, touches: Integers) -> Rubbing:
    """The friction at stops of these numbers that touch."""
    frictions = freedom.system.frictions
    rubs = np.zeros(0, dtype=np.intp) if frictions is None else np.flatnonzero(np.isin(frictions.stop, touches))
    if frictions is None or not len(rubs):
        return Rubbing.none(freedom.basis.shape[1])
    return Rubbing(
        T=freedom.rows_of(frictions.coordinates)[rubs],
        rate=friction_rates(freedom.system, state)[rubs],
        coefficient=frictions.sliding[rubs],
        partner=_among(frictions.partner, rubs),
        by=np.searchsorted(touches, frictions.stop[rubs]),
        numbers=rubs,
    )


def _among_touching(stop: Integers, touches: Integers) -> Integers:
    """The place of each stop among those that touch, -1 for none."""
    return np.where(stop >= 0, np.searchsorted(touches, stop), -1)


def _among(numbers: Integers, chosen: Integers) -> Integers:
    """The places among some that are chosen of the numbers that these have, -1 for none."""
    place = np.full(len(numbers) + 1, -1, dtype=np.intp)
    place[chosen] = np.arange(len(chosen))
    return place[numbers[chosen]]


def happened(t: float, system: System, before: Contacts, after: Contacts) -> tuple[Event, ...]:
    """What is recorded of frictions that begin to stick or to slide; of those at stops while these touch."""
    frictions, events = system.frictions, []
    for k, owner in enumerate(() if frictions is None else frictions.owners):
        assert frictions is not None
        stop, was, now = int(frictions.stop[k]), before.sliding.get(k, 0.0), after.sliding.get(k, 0.0)
        if not frictions.first(k) or (stop >= 0 and not (stop in before.touching and stop in after.touching)):
            continue
        name = system.names.frictions[k] if stop < 0 else owner.split("'")[1]
        if (k in before.sliding) != (k in after.sliding):
            events.append(Event(t, f"friction '{name}'", "slip" if k in after.sliding else "stick", round(now)))
        elif was * now < 0.0 and stop < 0:
            events.append(Event(t, f"friction '{name}'", "turn", round(now)))
    return tuple(events)


class _Loads:
    """What frictions are multiplied by, from the forces y along all rows, (K,)."""

    def __init__(self, freedom: Freedom, free: Free, gradients: Array, touches: Integers, rubs: Integers) -> None:
        system = freedom.system
        assert system.frictions is not None
        self._of = system.frictions.bearing[rubs]
        stops = system.frictions.stop[rubs]
        self._pushed = np.flatnonzero(stops >= 0)
        self._by = np.searchsorted(touches, stops[self._pushed])
        self._bearings, self._base, self._responses = system.bearings, None, None
        if system.bearings is not None and (self._of >= 0).any():
            self._base = supports(system, system.bearings, freedom.pose, free.multipliers)
            self._responses = supports(system, system.bearings, freedom.pose, freedom.multipliers_of(gradients))

    _base: Supports | None
    _responses: Supports | None

    def growth(self, forces: Array) -> Array | None:
        """How much each load grows with each other one where frictions go by them with these parts, (B, B)."""
        if self._bearings is None or self._responses is None:
            return None
        each = (load(self._bearings, self._responses) - self._bearings.preload) * forces[:, None]
        found = np.zeros((self._bearings.size, self._bearings.size))
        for k in np.flatnonzero(self._of >= 0):
            found[:, self._of[k]] += each[k]
        return found

    def goes_by(self, bearing: int) -> Flags:
        """Which frictions go by a bearing."""
        return np.asarray(self._of == bearing)

    def __call__(self, y: Array) -> Array:
        found = np.ones(len(self._of))
        if self._bearings is not None and self._base is not None and self._responses is not None:
            loads = load(self._bearings, self._base.plus(self._responses, y))
            found = np.where(self._of >= 0, loads[self._of], 1.0)
        found[self._pushed] = y[self._by]
        return found


def _as_contacts(
    frictions: Frictions, state: State, contacts: Contacts, found: Balanced, rubs: Integers
) -> tuple[dict[int, float], dict[int, float], dict[int, float]]:
    """What slides and where to, what is stuck and where, and what bears a part of its force."""
    value = counted_values(frictions.coordinates, frictions.joint_coordinate, pose_of(state.q), state.turns)
    partner = _among(frictions.partner, rubs)
    slides = (found.direction != 0.0) | ((partner >= 0) & (found.direction[partner] != 0.0))
    sliding = {int(rubs[k]): float(found.direction[k]) for k in np.flatnonzero(slides)}
    stuck = {int(k): contacts.stuck.get(int(k), float(value[k])) for k in rubs[found.stuck]}
    bearing = {int(rubs[k]): float(found.part[k]) for k in np.flatnonzero(found.part)}
    return sliding, stuck, bearing
