"""The accuracy of many settings against one reference, in parallel. Measurements that are stored are not taken
again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

from mbproj.dataclass import dataclass
from mbproj.scene.read import Scene
from mbproj.studies.measure.measurement import Measurement, measured
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import Reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import sample_times, solve
from mbproj.studies.measure.spans import stride_for
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.parallel.resumable import resumable
from mbproj.studies.store import ValueCache


@dataclass
class Yardstick:
    """A scene and the reference for the errors of all measurements. It can be sent to another process."""

    scene: Scene
    reference: Reference

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism, compiled and assembled once in each process."""
        return Mechanism.of(self.scene)

    def measure(self, setting: Setting) -> Measurement:
        """Measure one setting at the times of the reference, or at those of them that its fixed steps meet.

        With error control, its counters and seconds come from a second run without samples between the steps, as these
        cost evaluations."""
        times = self.reference.times
        stride = 1 if setting.step is None else stride_for(times, setting.step) or 1
        measurement = measured(solve(self.mechanism, setting, times[::stride]), self.reference.at_every(stride))
        if setting.tolerance is None or measurement.failure:
            return measurement
        report = solve(self.mechanism, setting, sample_times(float(times[-1]), 1)).report
        if report is None:
            return measurement
        return replace(measurement, counters=report.counters, seconds=report.integration_cpu_seconds)


def attempt(
    mechanism: Mechanism,
    settings: Sequence[Setting],
    reference: Reference,
    kept: ValueCache | None = None,
    processes: Where = None,
    tell: Tell = silent,
) -> list[Measurement]:
    """Measure each setting against the reference; return the measurements in the order of `settings`. Those in the
    store `kept` are not run again."""
    keys = [f"measurement {setting.command_line()}" for setting in settings]
    items, yardstick = dict(zip(keys, settings, strict=True)), Yardstick(mechanism.scene, reference)
    return [*resumable(Yardstick.measure, yardstick, items, kept or ValueCache(), processes, "runs", tell).values()]
