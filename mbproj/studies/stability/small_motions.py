"""Whether small motions about the equilibrium die away: by the modes, or from one round of instants to the next."""

from __future__ import annotations

import numpy as np

from mbproj.errors import InputError, MbprojError, Problem
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space.instants import round_of
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.stability.subject import FAILS, HOLDS, Point, Subject, cause_of
from mbproj.thresholds import THRESHOLDS

#: What the track is called, and its limits are known to this part of themselves: each point is cheap.
NAME, PRECISION = "small motions", 1e-8
#: Motions that grow by less in a round are neutral: a double eigenvalue 1 is split by √ε.
GROWS = 2e-8


def small_motions(subject: Subject, value: float) -> Point:
    """Holds where none grows. What goes wrong is part of the answer."""
    try:
        fault = _fault(Mechanism.of(subject.scene))
    except MbprojError as error:
        fault = cause_of(error)
    return Point(value, FAILS if fault else HOLDS, np.nan, np.nan, None, None, fault, ended=False)


def _fault(mechanism: Mechanism) -> str:
    """How fast the fastest one grows; "" where none does."""
    system = mechanism.system
    rest = equilibrium(system, mechanism.state)
    if rest.reference.held:
        raise InputError(Problem(f"dry friction holds it: {', '.join(rest.reference.held)}"))
    if system.actions.size:
        found = round_of(reference_at(system, rest.state, "equilibrium"))
        times = float(np.abs(found.multipliers).max(initial=0.0))
        return (
            f"a small motion grows by {times - 1.0:.3g} of itself in {found.time:.6g} s" if times > 1.0 + GROWS else ""
        )
    values = modes(rest.reference).eigenvalues
    fastest = float(values.real.max(initial=0.0))
    grows = fastest > THRESHOLDS.no_mode * float(np.abs(values).max(initial=0.0))
    return f"a small motion grows with {fastest:.6g} 1/s" if grows else ""
