"""Errors of runs that end at a stop or a dry friction, each with the time, the owner, and a remedy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Integers
from mbproj.errors import SimulationError
from mbproj.integrate.reporting.failures import no_unique_sliding
from mbproj.model.system import System
from mbproj.registry import IMPACT_LAWS


def stop_names(system: System, which: Sequence[int] | Integers) -> str:
    """Return the names of stops: "stop 'A'", "stops 'A', 'B'"."""
    names = ", ".join(f"'{system.names.stops[int(k)]}'" for k in which)
    return f"stop{'s' * (len(which) > 1)} {names}"


def undecided(
    t: float, system: System, why: str, which: Sequence[int], energy: float, laws: Sequence[int]
) -> SimulationError:
    """Return the error of contacts that the kernel could not decide, for the cause `why`. `which`: their numbers.
    `energy`: that in J which an impact would create. `laws`: the numbers of the impact laws that would create none."""
    if why == "driven into":
        return driven_into(t, system, which)
    if why == "creates energy":
        assert system.stops is not None
        return creates_energy(t, system, which, energy, system.stops.impact_law, [IMPACT_LAWS[k] for k in laws])
    if why == "no balance":
        return finds_no_balance(t, system, np.array(which))
    if why == "never ends":
        return never_ends(t, system, which)
    if why == "pushes":
        return pushes_along(t, system, which)
    cause = "a contact meets a motion without inertia: no force or impulse is finite there"
    return SimulationError(t, cause, hint="give its bodies mass and inertia")


def driven_into(t: float, system: System, which: Sequence[int] | Integers) -> SimulationError:
    """Return the error of rigid stops whose gaps no motion that the joints allow can open."""
    cause = "a rigid stop is driven into: no motion that the joints allow can turn back there"
    hint = "end the motion before the stop, drive with a force, or make the stop compliant with 'stiffness'"
    return SimulationError(t, cause, where=stop_names(system, which), hint=hint)


def creates_energy(
    t: float, system: System, which: Sequence[int] | Integers, energy: float, law: str, helps: Sequence[str]
) -> SimulationError:
    """Return the error of an impact law that would create energy in J, by unequal restitutions or by friction. `helps`:
    the laws that would create none."""
    assert system.stops is not None
    unequal = len({float(system.stops.restitution[int(k)]) for k in which}) > 1
    where = "unequal restitutions meet" if unequal else "friction turns an impact round"
    cause = f"the impact would create {energy:.4g} J: {law.capitalize()}'s law does not hold where {where}"
    hint = "give them the same 'restitution'" if unequal else "use a smaller 'restitution' or 'friction' there"
    if helps:
        hint = f"use 'impact_law: {helps[0]}' in 'simulation', or {hint}"
    return SimulationError(t, cause, where=stop_names(system, which), hint=hint)


def finds_no_balance(t: float, system: System, frictions: Integers) -> SimulationError:
    """Return the error of dry frictions that can neither stick nor slide, or can slide in two ways."""
    names, owners = ", ".join(f"'{system.names.frictions[int(k)]}'" for k in frictions), system.frictions
    joints: list[int] = (
        [] if owners is None or system.bearings is None else system.bearings.joint[owners.bearing[frictions]].tolist()
    )
    of = ", ".join(dict.fromkeys(f"'{system.names.joints[int(joint)]}'" for joint in joints))
    return no_unique_sliding(t, f"friction {names} of joint {of}" if of else f"friction {names}")


def never_ends(t: float, system: System, which: Sequence[int]) -> SimulationError:
    """Return the error of contacts that close and open again and again at one time. `which`: their numbers, stops
    first, then frictions."""
    stops = len(system.names.stops)
    own = [stop_names(system, [k]) if k < stops else f"friction '{system.names.frictions[k - stops]}'" for k in which]
    cause = "it is met and released again and again at one time"
    hint = "make it compliant with 'stiffness', or use a smaller step or tolerance"
    return SimulationError(t, cause, where=", ".join(own) or None, hint=hint)


def pushes_along(t: float, system: System, which: Sequence[int]) -> SimulationError:
    """Return the error of a dry friction that would create energy. `which`: its number among frictions."""
    cause = "dry friction pushes along the motion, so it creates energy: the run is wrong from about here on"
    hint = "use a smaller step or tolerance; where the friction is a formula, keep it positive"
    return SimulationError(t, cause, where=f"friction '{system.names.frictions[which[0]]}'", hint=hint)
