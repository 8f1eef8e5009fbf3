"""The stability of small motions about the equilibrium: from the modes, or from one round of a sampled controller's
instants to the next."""

from __future__ import annotations

import numpy as np

from mbproj.errors import InputError, MbprojError, Problem
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space.instants import round_of
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.stability.subject import FAILS, HOLDS, StabilityPoint, Subject, cause_of
from mbproj.thresholds import THRESHOLDS

#: The name of the track, and the relative precision of its limits: each point costs little.
NAME, PRECISION = "small motions", 1e-8
#: Motions that grow by a smaller part in a round count as neutral: rounding splits a double eigenvalue 1 by √ε.
GROWS = 2e-8


def small_motions(subject: Subject, value: float) -> StabilityPoint:
    """Test that no small motion grows. An error becomes the cause of a failed point."""
    try:
        fault = _fault(Mechanism.of(subject.scene))
    except MbprojError as error:
        fault = cause_of(error)
    return StabilityPoint(value, FAILS if fault else HOLDS, np.nan, np.nan, None, None, fault, ended=False)


def _fault(mechanism: Mechanism) -> str:
    """A sentence on the fastest growing small motion; "" where none grows."""
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
