"""What a run comes to and what it costs, and the least time for an error."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.observe.recorded import Block, Observation
from mbproj.errors import SimulationError
from mbproj.integrate import simulate
from mbproj.scene.records import Scene, Settings
from mbproj.studies.measure.mechanism import Mechanism

SAMPLES = 10
#: From coarse to fine, among which the cheapest run for an error is.
TOLERANCES = tuple(10.0 ** (-0.5 * power) for power in range(4, 18))


@dataclass(frozen=True, eq=False)
class Outcome:
    """Coordinates at the samples, (T, 7n), and what they cost; `closure`: the largest of |C| and |C'|; `seconds` of the
    processor went into the steps."""

    q: Array
    steps: int
    rejected: int
    evaluations: int
    factorisations: int
    closure: float
    seconds: float

    def off(self, other: Outcome) -> float:
        """The largest difference of a coordinate."""
        return float(np.abs(self.q - other.q).max())


class _Coordinates:
    """A recorder of q."""

    def __init__(self) -> None:
        self.blocks: list[Array] = []

    def write(self, block: Block) -> None:
        """Takes T samples."""
        assert isinstance(block, Observation)
        self.blocks.append(block.samples.q)


def run(scene: Scene, until: float, integrator: str, tolerance: float) -> Outcome:
    """A run with error control. Raises SimulationError where it stops."""
    mechanism, recorder = Mechanism.of(scene), _Coordinates()
    settings = Settings(duration=until, output_step=until / SAMPLES, integrator=integrator, tolerance=tolerance)
    report = simulate(mechanism.system, mechanism.state, settings, recorder)
    counts = report.counters
    return Outcome(
        q=np.concatenate(recorder.blocks),
        steps=counts["steps"],
        rejected=counts["rejected_steps"],
        evaluations=counts["evaluations"],
        factorisations=counts["factorisations"],
        closure=max(report.position_violation.value, report.velocity_violation.value),
        seconds=report.integration_cpu_seconds,
    )


def cheapest(scene: Scene, until: float, integrator: str, reference: Outcome, error: float) -> Outcome | None:
    """The run of the coarsest tolerance whose error is below `error`, its fastest of three; None if there is none."""
    for tolerance in TOLERANCES:
        try:
            found = run(scene, until, integrator, tolerance)
        except SimulationError:
            continue
        if found.off(reference) <= error:
            seconds = [found.seconds, *(run(scene, until, integrator, tolerance).seconds for _ in range(2))]
            return replace(found, seconds=min(seconds))
    return None
