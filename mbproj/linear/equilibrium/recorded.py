"""Writes an equilibrium as a results file of one sample."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.dynamics.observe.recorded import Block, Observer
from mbproj.dynamics.observe.samples import Sample, stack
from mbproj.dynamics.rank.uniqueness import unique_components
from mbproj.linear.equilibrium.find import Equilibrium
from mbproj.results import ResultsWriter
from mbproj.results.layout import COUNTERS
from mbproj.scene.records import Scene


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


def write_results(path: Path | str, scene: Scene, rest: Equilibrium, facts: Mapping[str, Any]) -> None:
    """Write the results file."""
    system = rest.whole
    constants = unique_components(system, rest.state)
    with ResultsWriter(path, scene, system.names.as_mapping(), constants) as writer:
        writer.write(observed(rest))
        writer.attributes({name: value for name, value in facts.items() if isinstance(value, (str, int, float, bool))})
