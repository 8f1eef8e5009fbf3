"""The forces of dry friction in an equilibrium, and a check that they are within their bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.friction.changing import frictions_at
from mbproj.dynamics.observe.bearings import load, supports
from mbproj.errors import InputError, Problem, SimulationError
from mbproj.functions.program import CHANNELS, Op, apply, variable
from mbproj.functions.program_set import flatten
from mbproj.integrate.stops.resting import RubsAtStart, resting, rubs_of
from mbproj.linear.reference import LinearReference
from mbproj.model.channels import ChannelKind, Channels
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

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
        own = variable(CHANNELS + known_channels.setdefault((ChannelKind.STATE, state), len(known_channels)))
        to = actions.programs.program(entry)
        rates[state] = replace(to, code=apply(Op.SUBTRACT, to.code, own))
    return replace(system, channels=Channels.of(list(known_channels)), states=replace(states, programs=flatten(rates)))
