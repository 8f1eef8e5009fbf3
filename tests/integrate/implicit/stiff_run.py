"""What a run of a stiff mechanism comes to and what it costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.settings import Settings
from mbproj.equations.recorded import Block, Observation
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import Scene
from mbproj.studies.measure.solve import Mechanism

SAMPLES = 10


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
