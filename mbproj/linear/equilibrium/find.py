"""The equilibrium that a mechanism reaches from its start, its stability, and further equilibria."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field, replace

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, SimulationError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinate_values
from mbproj.equations.bearings import load, supports
from mbproj.equations.derivatives import MotionAtTime
from mbproj.equations.friction import frictions_at
from mbproj.equations.gaps import gaps, stop_sizes
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import Drive, drive_at
from mbproj.equations.rank.mobility import mobility
from mbproj.equations.rank.row_space import NO_CONDITIONS
from mbproj.equations.tangent_space import accelerations, velocities
from mbproj.equations.turning import near, turns_of
from mbproj.functions.program import CHANNELS, Op, apply, variable
from mbproj.functions.program_set import flatten
from mbproj.linear.equilibrium.balance import REST, EquilibriumProblem, SteadyTurn
from mbproj.linear.equilibrium.solve import NoEquilibrium, Solved, direction_words, solve
from mbproj.linear.modes import modes, states_in
from mbproj.linear.reduction import refuse_large_rolling
from mbproj.linear.reference import (
    Imbalance,
    LinearReference,
    RestingContacts,
    held_at,
    imbalance,
    refuse_loads,
    refuse_rolling,
)
from mbproj.model.channels import ChannelKind, Channels
from mbproj.model.system import Conditions, System
from mbproj.motion.contacts import RubsAtStart, resting, rubs_of
from mbproj.results.views import Table, Tabled

#: The seed of the random directions in which other starts are sought.
SEED = 22


@dataclass(frozen=True, eq=False)
class Equilibrium(Tabled):
    """A pose at which forces balance. `stable` is None where modes do not decide. `unstable`: the motion along which it
    falls, or why that is not known. `neutral`: directions without stiffness. `drive` (h,): the torques that hold
    steadily turning coordinates, N m. `steps`: the number of Newton steps. `whole`: the mechanism without the rows of
    sticking dry `frictions`, by name. `friction_force` (K,): the force of each friction. `family`: with rolling, the
    number of freedoms that poses have beyond velocities."""

    reference: LinearReference
    acceleration: Array
    stable: bool | None
    unstable: str
    neutral: tuple[str, ...]
    drive: Array
    steps: int
    whole: System
    frictions: Mapping[str, RubsAtStart] = field(default_factory=dict)
    friction_force: Array = field(default_factory=lambda: np.zeros(0))
    family: int = 0

    @property
    def state(self) -> State:
        """The state of a run that starts at the equilibrium."""
        motion, system = self.reference.motion, self.reference.system
        pose = motion.pose
        turns = turns_of(system, motion.expected, coordinate_values(system, pose))
        v = velocities(pose, motion.u)
        return State.of(system, motion.t, positions=motion.q, velocities=v, turns=turns, states=motion.x)

    @property
    def coordinates(self) -> dict[str, float]:
        """The joint coordinates, in rad or m, by name."""
        names = self.reference.system.names.coordinates
        return dict(zip(names, self.reference.motion.expected.tolist(), strict=True))

    @property
    def states(self) -> dict[str, float]:
        """The states of elements, by name."""
        return dict(zip(self.reference.system.names.states, self.reference.motion.x.tolist(), strict=True))

    @property
    def table(self) -> Table:
        """A table with a row for each joint coordinate, then for each state of an element."""
        names, values = self.reference.system.names, {**self.coordinates, **self.states}
        units = (*names.coordinate_units, *names.state_units)
        rows = ((name, value, unit) for (name, value), unit in zip(values.items(), units, strict=True))
        return Table(("coordinate", "value", "unit"), tuple(rows))

    @property
    def line(self) -> str:
        """The stability and the accuracy of the balance, in words."""
        kind = {True: "stable", False: "unstable", None: "not known whether stable"}[self.stable]
        neutral = f", neutral along {', '.join(self.neutral)}" if self.neutral else ""
        return f"{kind}{neutral}; forces balance to {self.reference.imbalance.relative:.1g} of the largest"

    __repr__ = Tabled.__repr__


def equilibrium(
    system: System, start: State, t: float = 0.0, turning: SteadyTurn | None = None, held: Conditions = NO_CONDITIONS
) -> Equilibrium:
    """Return the equilibrium from an assembled start, with motions held at time t, or a steady turn. Dry friction holds
    its coordinates at their initial values. Raises NoEquilibrium where nothing balances the forces. Raises InputError
    where a motion is not constant then, or dry friction would have to bear more than it can. Raises it also where a
    large mechanism that turns or has states has too many degrees of freedom."""
    refuse_large_rolling(system)
    if turning is not None:
        refuse_rolling(system, "a steady turn does not know")
    _refuse(system, t, steadily=turning is not None)
    here = held_at(settled(system), start, resting=True)
    q, expected = _moved_to_motions(here.system, start, t)
    problem = EquilibriumProblem.of(here.system, t, q, drive_at(system, t), held, start.x, turning or REST)
    return _possible(system, _with_masses(system, problem, _solved(problem, q, expected), here))


def _with_masses(system: System, problem: EquilibriumProblem, solved: Solved, here: RestingContacts) -> Equilibrium:
    """Return the description, with the masses that compliant stops meet at the equilibrium, not at the start."""
    described_pose = described(problem, solved, here)
    if system.stops is None or not system.stops.resistance.any():
        return described_pose
    here = held_at(settled(system), described_pose.state, resting=True)
    return described(replace(problem, system=here.system), solved, here)


def _possible(system: System, rest: Equilibrium) -> Equilibrium:
    """Return the equilibrium with its friction forces. Raises InputError where a stop or a friction does not hold."""
    rest = _inside_stops(rest)
    frictions, force = holding(system, rest.reference, rest.state)
    return replace(rest, frictions=frictions, friction_force=force)


def _inside_stops(rest: Equilibrium) -> Equilibrium:
    """Return the equilibrium. Raises InputError where it lies beyond a rigid stop."""
    system, state = rest.reference.system, rest.state
    if system.stops is None:
        return rest
    gap = gaps(system.stops, pose_of(state.q), state.turns)
    beyond = np.flatnonzero(system.stops.is_rigid & (gap < -THRESHOLDS.touching * stop_sizes(system)))
    if not len(beyond):
        return rest
    k = int(beyond[np.argmin(gap[beyond])])
    said = f"forces balance {-gap[k]:.6g} {system.names.stop_units[k]} beyond the rigid stop '{system.names.stops[k]}'"
    hint = "run it with dampers until it rests on the stop, or make the stop compliant with 'stiffness'"
    raise InputError(Problem(said, system.stops.places[k], hint))


def is_large(system: System) -> bool:
    """Return whether the mechanism is so large that only its slowest modes are computed."""
    return system.bodies > THRESHOLDS.large


def _solved(problem: EquilibriumProblem, q: Array, expected: Array, *, dense: bool = False) -> Solved:
    if problem.system.states.size:
        from mbproj.linear.equilibrium.states import solve_with_states

        return solve_with_states(problem, q, expected)
    turns = bool(problem.held.index.size or np.any(problem.turning.rate))
    if dense or turns or problem.system.rolls or problem.system.bodies <= THRESHOLDS.few_bodies:
        return solve(problem, q, expected)
    from mbproj.linear.equilibrium.large import solve_large

    return solve_large(problem, q, expected)


def other_equilibria(
    system: System, rest: Equilibrium, count: int, turning: SteadyTurn | None = None, held: Conditions = NO_CONDITIONS
) -> Iterator[Equilibrium]:
    """Yield other equilibria, found from `count` other poses that the joints reach; each is yielded once."""
    if not count:
        return
    motion, here = rest.reference.motion, RestingContacts(rest.reference.system, rest.whole, rest.reference.held)
    drive = drive_at(system, motion.t)
    problem = EquilibriumProblem.of(here.system, motion.t, motion.q, drive, held, motion.x, turning or REST)
    seen, rng = [motion.q], np.random.default_rng(SEED)
    for _ in range(count):
        there = _elsewhere(problem, motion, rng)
        try:
            apart = _solved(problem, there.q, there.expected, dense=not is_large(system))
            other = _possible(system, _with_masses(system, problem, apart, here))
        except (NoEquilibrium, InputError):
            continue
        if all(_are_different(system, pose, other.reference.motion.q) for pose in seen):
            seen.append(other.reference.motion.q)
            yield other


def _elsewhere(problem: EquilibriumProblem, motion: MotionAtTime, rng: np.random.Generator) -> MotionAtTime:
    """Return a pose that the joints reach in a random direction."""
    far = rng.uniform(-np.pi, np.pi)
    if is_large(problem.system):
        from mbproj.linear.equilibrium.large import LargeBalance

        at = LargeBalance.at(problem, motion.q, motion.expected)
        way = at.metric.solve(far * rng.normal(size=len(at.lengths)) / at.lengths)[0]
        for _ in range(10):
            at = at.after(0.1 * way) or at
        return at.motion
    here = problem.at(motion.q, motion.expected)
    along = far * rng.normal(size=here.space.freedom)
    for _ in range(10):
        here = here.after(0.1 * along[: here.space.freedom]) or here
    return here.motion


def _are_different(system: System, first: Array, second: Array) -> bool:
    """Return whether two poses differ. Turns by 360 degrees and neutral motions count only if bodies differ."""
    one, two = first.reshape(-1, 7), second.reshape(-1, 7)
    shift = np.abs(one[:, :3] - two[:, :3]).max() / system.length
    turn = 1.0 - np.abs(np.sum(one[:, 3:] * two[:, 3:], axis=1)).min()
    return bool(max(shift, np.sqrt(max(turn, 0.0))) > THRESHOLDS.same_pose)


def _refuse(system: System, t: float, *, steadily: bool) -> None:
    if steadily:
        refuse_loads(system, "is not known in a steady turn")
    if steadily and system.frictions is not None:
        names = ", ".join(f"'{name}'" for name in system.names.frictions)
        said = f"a steady turn has no model of the dry friction of {names}"
        raise InputError(Problem(said, system.frictions.places[0], "let it come to turn steadily in a run"))
    if steadily:
        return
    problems = [
        Problem(
            f"motion '{name}' is not constant at t = {t:.6g} s: its rate is {rate:.6g} per s",
            place,
            "let it stand still then, as a smooth_step does; or mbproj equilibrium takes another time with --at",
        )
        for name, place, rate in zip(system.names.motions, system.motions.places, drive_at(system, t).rate, strict=True)
        if abs(rate) > THRESHOLDS.same_written
    ]
    if problems:
        raise InputError(problems)


def _moved_to_motions(system: System, start: State, t: float) -> tuple[Array, Array]:
    """Return the start's pose, led in small steps to the motions' values at time t, and its coordinates with turns."""
    q = start.q
    expected = coordinate_values(system, pose_of(q)) + 2.0 * np.pi * start.turns
    first, last = drive_at(system, start.t), drive_at(system, t)
    far = np.abs(last.value - first.value) / system.row_scale[system.bodies + system.joints.size :]
    count = int(np.ceil(far.max(initial=0.0) / THRESHOLDS.long_way))
    for step in range(1, count + 1):
        value = first.value + (last.value - first.value) * step / count
        drive = Drive(value, np.zeros_like(value), np.zeros_like(value))
        closed = EquilibriumProblem.of(system, t, q, drive, NO_CONDITIONS, start.x).closed_pose(q)
        if closed is None:
            said = f"the mechanism cannot reach where its motions are at t = {t:.6g} s"
            raise InputError(Problem(said, hint="give an earlier time with --at"))
        q = closed
        expected = np.asarray(near(system, coordinate_values(system, pose_of(q)), expected), dtype=float)
    return q, expected


def described(problem: EquilibriumProblem, solved: Solved, here: RestingContacts) -> Equilibrium:
    """Return an equilibrium with its description, without the forces of frictions."""
    balance, system = solved.balance, problem.system
    rows, motion = system.constraints - system.bodies, balance.motion
    left: Imbalance = imbalance(system, balance.unbalanced / balance.lengths**2, balance.largest)
    where = "steady" if np.any(problem.turning.rate) else "equilibrium"
    reference = LinearReference(system, motion, balance.multipliers[:rows], left, where, problem.turning.rate, here.by)
    stable, unstable, neutral = _stability(reference)
    if stable and is_large(system) and not solved.is_lowest:
        stable, unstable = False, "of a mode that is faster than its slowest"
    return Equilibrium(
        reference,
        accelerations(motion.pose, motion.u, motion.change),
        stable,
        unstable,
        neutral,
        -balance.multipliers[rows:],
        solved.steps,
        here.whole,
        family=mobility(system, motion.pose).rolling if system.rolls else 0,
    )


def _stability(reference: LinearReference) -> tuple[bool | None, str, tuple[str, ...]]:
    """Return whether no mode grows, the motion along which one does, and the neutral directions."""
    try:
        modal = modes(reference)
    except InputError as error:
        return None, str(error).splitlines()[0].removeprefix("error: "), ()
    rotation = reference.motion.pose.rotation[:-1]
    in_body = modal.shapes.copy()
    in_body[..., 3:] = np.einsum("bji,kbj->kbi", rotation, modal.shapes[..., 3:])
    words = [
        f"of {states_in(modal, mode)}"
        if modal.is_of_states(mode)
        else direction_words(reference.system, reference.motion, shape.real.ravel())
        for mode, shape in enumerate(in_body)
    ]
    growth = modal.eigenvalues.real
    fastest = float(np.abs(modal.eigenvalues).max(initial=0.0))
    grows = growth > THRESHOLDS.no_motion * fastest
    worst = int(np.argmax(growth)) if grows.any() else -1
    neutral = tuple(word for word, value in zip(words, modal.eigenvalues, strict=True) if value == 0.0)
    return not grows.any(), words[worst] if worst >= 0 else "", neutral


# --- Dry friction in an equilibrium -----------------------------------------------------------------------------------
# Its forces, and a check that they are within their bounds.


HINT = "simulate until it rests, or begin nearer to where it does"


def holding(system: System, reference: LinearReference, state: State) -> tuple[dict[str, RubsAtStart], Array]:
    """Return the dry frictions of a mechanism by name, at an equilibrium in which they hold, and the force of each,
    (K,). Raises InputError with those that do not hold."""
    if system.frictions is None:
        return {}, np.zeros(0)
    try:
        rests = resting(system, state)
    except SimulationError as error:
        raise InputError(Problem(f"this equilibrium cannot begin a run: {error.cause}", hint=error.hint)) from error
    frictions = rubs_of(system, state, rests)
    slipping = [_slips(system, reference, state, name) for name, entry in frictions.items() if entry["direction"]]
    problems = [problem for problem in slipping if problem is not None]
    if problems:
        raise InputError(problems)
    return frictions, rests.force


def _slips(system: System, reference: LinearReference, state: State, name: str) -> Problem | None:
    """Return the problem of a friction that does not hold, with the force it would need; None where the excess is
    round-off."""
    frictions, names = system.frictions, system.names.frictions
    said = f"dry friction '{name}' does not hold where the other forces balance"
    if frictions is None or name not in names:  # a friction at a stop
        return Problem(said, hint=HINT)
    k, unit = names.index(name), system.names.friction_units[names.index(name)]
    if name in reference.held:
        first = reference.system.joints.size - len(reference.held)
        needed = abs(float(reference.multipliers[first + reference.held.index(name)]))
        most = float(frictions_at(system, state).static[k])
        if system.bearings is not None and frictions.bearing[k] >= 0:
            at = supports(reference.system, system.bearings, reference.motion.pose, reference.multipliers)
            most *= float(np.asarray(load(system.bearings, at))[frictions.bearing[k]])
        if needed <= most + THRESHOLDS.dependent * float(np.abs(reference.multipliers).max()):
            return None
        said += f": {needed:.6g} {'N m' if unit == 'rad' else 'N'} are needed, and it bears {most:.6g} at most"
    return Problem(said, frictions.places[k], HINT)


def settled(system: System) -> System:
    """Return the system in which a held state x follows x' = (value set by its controller) - x. At rest both are
    equal."""
    actions, states, channels = system.actions, system.states, system.channels
    if not actions.size:
        return system
    known = zip(channels.kind.tolist(), channels.index.tolist(), strict=True)
    known_channels = {(ChannelKind(kind), index): at for at, (kind, index) in enumerate(known)}
    rates = [states.programs.program(k) for k in range(states.size)]
    for entry, state in enumerate(actions.state.tolist()):
        x = variable(CHANNELS + known_channels.setdefault((ChannelKind.STATE, state), len(known_channels)))
        to = actions.programs.program(entry)
        rates[state] = replace(to, code=apply(Op.SUBTRACT, to.code, x))
    return replace(system, channels=Channels.of(list(known_channels)), states=replace(states, programs=flatten(rates)))
