"""An equilibrium as a results file of one sample."""

from __future__ import annotations

from collections.abc import Mapping
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


def observed(found: Equilibrium) -> Block:
    """All that a results file holds of one sample."""
    system, state = found.reference.system, found.state
    none = {path.removeprefix("diagnostics/"): 0 for path in COUNTERS}
    sample = Sample(
        state.t, state.q, state.v, found.acceleration, found.reference.multipliers, state.turns, 0.0, np.zeros(2), none
    )
    return Observer(system, state).at(stack([sample]))


def write_results(path: Path | str, scene: Scene, found: Equilibrium, facts: Mapping[str, Any]) -> None:
    """Writes the results file."""
    system = found.reference.system
    constants = unique_components(system, found.state)
    with ResultsWriter(path, scene, system.names.as_mapping(), constants) as writer:
        writer.write(observed(found))
        writer.attributes({name: value for name, value in facts.items() if isinstance(value, (str, int, float, bool))})
