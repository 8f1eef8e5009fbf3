"""Forces without a linear part: those without a slope at the reference, or whose value or slope jumps there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.derivatives import law_slopes
from mbproj.equations.forces import law_state
from mbproj.equations.gaps import gaps, stop_sizes
from mbproj.equations.turning import turns_of
from mbproj.functions.program import CHANNELS, COORDINATE, RATE
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import constant_series, run, slope
from mbproj.linear.reference import LinearReference, refuse_loads
from mbproj.model.forces import Forces

HINT = "linearise beside the kink, or smooth the force"


def refuse_kinks(reference: LinearReference) -> None:
    """Raise InputError that names the forces and states without a slope at the reference, or with different slopes on
    either side.

    Examples are points that coincide, the root of a square, a stop at its edge, or dry friction at rest. It is also
    raised where controllers act."""
    if reference.system.actions.size:
        what = f"{reference.system.actions.names[0]} acts at instants: between them it holds its values"
        raise InputError(Problem(what, hint="a continuous model has no such thing; write the law as 'states' for it"))
    refuse_bends(reference)


def refuse_bends(reference: LinearReference) -> None:
    """Raise InputError as `refuse_kinks` does, also for functions that controllers evaluate at instants, but not for
    their instants."""
    _refuse_touching(reference)
    refuse_loads(reference.system, "has no linear part here")
    problems = [
        Problem(f"{owner} {why} at this pose: it has no linear part", hint=HINT)
        for owner, why in (*_kinks(reference, reference.system.forces), *_of_channels(reference))
    ]
    if problems:
        raise InputError(problems)


def _refuse_touching(reference: LinearReference) -> None:
    """Raise InputError that names the rigid stops which touch at the reference: they act on one side only."""
    system, motion = reference.system, reference.motion
    if system.stops is None:
        return
    turns = turns_of(system, motion.expected, coordinate_values(system, motion.pose))
    near = gaps(system.stops, motion.pose, turns) <= THRESHOLDS.touching * stop_sizes(system)
    problems = [
        Problem(f"the rigid stop '{system.names.stops[k]}' touches at this pose: it has no linear part", hint=HINT)
        for k in np.flatnonzero(system.stops.is_rigid & near)
    ]
    if problems:
        raise InputError(problems)


def _kinks(reference: LinearReference, forces: Forces) -> Iterator[tuple[str, str]]:
    """The owners of functions with a kink along their own coordinate, and a description of the kink."""
    instant, laws = reference.motion.instant(reference.system), forces.laws
    state = law_state(instant)
    smooth = np.isfinite(np.sum(law_slopes(instant, state), axis=0))
    unit = np.where(laws.coordinates.is_length, reference.system.length, 1.0)
    for law, owner in enumerate(forces.law_owners):
        if not smooth[law]:
            yield f"force '{owner}'", "has no slope"
        elif laws.program[law] >= 0:
            at = [float(each) for each in instant.values(state.value[law], state.rate[law])]
            programs, size = forces.programs, float(unit[law])
            jumps = (_jump(programs, int(laws.program[law]), at, which, size) for which in (COORDINATE, RATE))
            why = next((jump for jump in jumps if jump), "")
            if why:
                yield f"force '{owner}'", why


def _of_channels(reference: LinearReference) -> Iterator[tuple[str, str]]:
    """The owners of functions with a kink along a channel, and a description of the kink."""
    system = reference.system
    if not system.channels.size:
        return
    instant, laws = reference.motion.instant(system), system.forces.laws
    seen, names = law_state(instant), system.names
    places = {int(k): (seen.value[law], seen.rate[law]) for law, k in enumerate(laws.program) if k >= 0}
    every = [(system.forces.programs, k, f"force '{owner}'") for k, owner in enumerate(system.forces.program_owners)]
    every += [(system.states.programs, k, f"state '{name}'") for k, name in enumerate(names.states)]
    set_to = system.actions.state.tolist()
    every += [(system.actions.programs, k, f"what sets '{names.states[state]}'") for k, state in enumerate(set_to)]
    for programs, k, owner in every:
        of_law = places.get(k, (0.0, 0.0)) if programs is system.forces.programs else (0.0, 0.0)
        at = [float(each) for each in instant.values(*of_law)]
        jumps = (_jump(programs, k, at, which, 1.0) for which in range(CHANNELS, len(at)))
        why = next((jump for jump in jumps if jump), "") if programs.names_channels(k) else ""
        if why:
            yield owner, why


def _jump(programs: ProgramSet, program: int, at: list[float], variable: int, unit: float) -> str:
    """Return the description of a function's jump or kink at a variable's value; "" where it is smooth. A smooth
    function changes less over a shorter step."""
    aside = THRESHOLDS.half_digits * max(abs(at[variable]), unit)
    far, near = (_sides(programs, program, at, variable, step) for step in (aside, 0.1 * aside))
    slopes, values = far.T
    jump = np.abs(near[1] - near[0]) > 0.5 * np.abs(far[1] - far[0])
    if jump[0] and abs(slopes[1] - slopes[0]) > THRESHOLDS.rounded * np.abs(slopes).max():
        return f"has a kink, the slope {slopes[0]:.6g} before and {slopes[1]:.6g} after it,"
    if jump[1] and abs(values[1] - values[0]) > THRESHOLDS.half_digits * np.abs(values).max():
        return f"jumps from {values[0]:.6g} to {values[1]:.6g}"
    return ""


def _sides(programs: ProgramSet, program: int, at: list[float], variable: int, step: float) -> Array:
    """Return slope and value before and after, (2, 2)."""
    slopes = np.zeros((2, 2))
    for side, sign in enumerate((-1.0, 1.0)):
        here = [np.asarray(x + sign * step * (index == variable)) for index, x in enumerate(at)]
        slopes[side, 0] = slope(programs, program, here, variable)
        slopes[side, 1] = run(programs, program, [constant_series(x) for x in here])[0]
    return slopes
