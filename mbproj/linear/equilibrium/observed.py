"""An equilibrium as the one sample of a results file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.dynamics.observe.recorded import Block, Observer
from mbproj.dynamics.observe.samples import Sample, stack
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.results.layout import COUNTERS


def observed(rest: Equilibrium) -> Block:
    """Return the content of a results file with this one sample."""
    system, state, reference = rest.whole, rest.state, rest.reference
    none = {path.removeprefix("diagnostics/"): 0 for path in COUNTERS}
    rows, frictions = reference.system.joints.size, len(system.names.frictions)
    multipliers = np.delete(reference.multipliers, np.arange(rows - len(reference.held), rows))
    work = np.zeros(2 + frictions)
    sample = Sample(state, rest.acceleration, multipliers, 0.0, work, none)
    force = rest.friction_force[None]
    samples = replace(stack([sample]), rub=(lambda: (force, np.zeros_like(force))) if frictions else None)
    return Observer(system, state).at(samples)
