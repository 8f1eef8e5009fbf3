"""What a run comes to and what it costs, and the least time for an error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import SimulationError
from mbproj.base.settings import Settings
from mbproj.equations.recorded import Block, Observation
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import Scene
from mbproj.studies.measure.solve import Mechanism

SAMPLES = 10
#: From coarse to fine, among which the cheapest run for an error is.
TOLERANCES = tuple(10.0 ** (-power / 3.0) for power in range(6, 28))
#: So many of them that suffice are tried.
FINER = 4


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


def cheapest(
    scene: Scene, until: float, integrator: str, reference: Outcome, error: float
) -> tuple[float, Outcome] | None:
    """The tolerance and the run of the fewest evaluations whose error is below `error`: a coarser tolerance may take
    more steps, where it is near the speed of a vibration. None if there is none."""
    found: list[tuple[float, Outcome]] = []
    for tolerance in TOLERANCES:
        try:
            one = run(scene, until, integrator, tolerance)
        except SimulationError:
            continue
        if one.off(reference) <= error:
            found.append((tolerance, one))
        if len(found) == FINER:
            break
    return min(found, key=lambda each: each[1].evaluations) if found else None


def fastest(scene: Scene, until: float, how: list[tuple[str, float]], repeat: int = 5) -> list[float]:
    """The least seconds of each integrator at its tolerance, of so many runs in turn."""
    seconds = [[run(scene, until, *each).seconds for each in how] for _ in range(repeat)]
    return [min(column) for column in zip(*seconds, strict=True)]
