"""Forces without a linear part: those that have no slope at the reference, or whose value or slope jumps there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import coordinate_values
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.derivatives.law_derivatives import law_slopes
from mbproj.dynamics.equations.forces import law_state
from mbproj.dynamics.equations.gaps import gaps
from mbproj.dynamics.equations.turning import turns_of
from mbproj.errors import InputError, Problem
from mbproj.functions.program import COORDINATE, RATE
from mbproj.functions.series import constant_series, run, slope
from mbproj.linear.held import refuse_loads
from mbproj.linear.reference import Reference
from mbproj.model.forces import Forces
from mbproj.thresholds import THRESHOLDS

HINT = "linearise beside the kink, or smooth the force"


def refuse_kinks(reference: Reference) -> None:
    """Raises InputError that names the forces which have no slope at the reference, or another one on either side. The
    first are those of two points that have met, or of the root of a square: a stop at its edge, dry friction at
    rest."""
    _refuse_touching(reference)
    refuse_loads(reference.system, "has no linear part here")
    problems = [
        Problem(f"force '{owner}' {why} at this pose: it has no linear part", hint=HINT)
        for owner, why in _kinks(reference, reference.system.forces)
    ]
    if problems:
        raise InputError(problems)


def _refuse_touching(reference: Reference) -> None:
    """Raises InputError that names the rigid stops which touch at the reference: they act on one side alone."""
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


def _kinks(reference: Reference, forces: Forces) -> Iterator[tuple[str, str]]:
    """Who has a kink, and what it is."""
    instant, laws = reference.motion.instant(reference.system), forces.laws
    state = law_state(instant)
    smooth = np.isfinite(np.sum(law_slopes(instant, state), axis=0))
    unit = np.where(laws.coordinates.is_length, reference.system.length, 1.0)
    for law, owner in enumerate(forces.law_owners):
        if not smooth[law]:
            yield owner, "has no slope"
        elif laws.program[law] >= 0:
            at = [float(each) for each in instant.values(state.value[law], state.rate[law])]
            jumps = (_jump(forces, int(laws.program[law]), at, which, float(unit[law])) for which in (COORDINATE, RATE))
            why = next((jump for jump in jumps if jump), "")
            if why:
                yield owner, why


def _jump(forces: Forces, program: int, at: list[float], variable: int, unit: float) -> str:
    """What is another one on either side of a variable's value; nothing where the function is smooth: what is smooth
    changes by less the nearer one looks."""
    aside = THRESHOLDS.beside_kink * max(abs(at[variable]), unit)
    far, near = (_sides(forces, program, at, variable, step) for step in (aside, 0.1 * aside))
    slopes, values = far.T
    jump = np.abs(near[1] - near[0]) > 0.5 * np.abs(far[1] - far[0])
    if jump[0] and abs(slopes[1] - slopes[0]) > THRESHOLDS.jumping_slope * np.abs(slopes).max():
        return f"has a kink, the slope {slopes[0]:.6g} before and {slopes[1]:.6g} after it,"
    if jump[1] and abs(values[1] - values[0]) > THRESHOLDS.beside_kink * np.abs(values).max():
        return f"jumps from {values[0]:.6g} to {values[1]:.6g}"
    return ""


def _sides(forces: Forces, program: int, at: list[float], variable: int, step: float) -> Array:
    """Slope and value before and after, (2, 2)."""
    found = np.zeros((2, 2))
    for side, sign in enumerate((-1.0, 1.0)):
        here = [np.asarray(x + sign * step * (index == variable)) for index, x in enumerate(at)]
        found[side, 0] = slope(forces.programs, program, here, variable)
        found[side, 1] = run(forces.programs, program, [constant_series(x) for x in here])[0]
    return found
