"""Many settings against one reference, in parallel; what was done is kept in a journal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from mbproj.scene.records import Scene
from mbproj.studies.journal import Journal
from mbproj.studies.mechanism import Mechanism
from mbproj.studies.reference import Reference
from mbproj.studies.setting import Setting
from mbproj.studies.solve import sample_times, solve
from mbproj.studies.spans import stride_for
from mbproj.studies.trial import Trial, trial
from mbproj.studies.workers import in_parallel


@dataclass
class Yardstick:
    """What a trial needs: a scene and the reference that its runs are held against. It can be sent to a process."""

    scene: Scene
    reference: Reference

    @cached_property
    def mechanism(self) -> Mechanism:
        """Compiled and assembled once in each process."""
        return Mechanism.of(self.scene)

    def trial(self, setting: Setting) -> Trial:
        """The trial of one setting over the times of the reference, or those of them that its steps meet. Its counters
        and seconds are those of a run without samples between the steps, which cost evaluations of their own."""
        times = self.reference.times
        stride = 1 if setting.step is None else stride_for(times, setting.step) or 1
        found = trial(solve(self.mechanism, setting, times[::stride]), self.reference.at_every(stride))
        if setting.tolerance is None or found.failure:
            return found
        report = solve(self.mechanism, setting, sample_times(float(times[-1]), 1)).report
        if report is None:
            return found
        return replace(found, counters=report.counters, seconds=report.integration_cpu_seconds)


def _trial(yardstick: Yardstick, setting: Setting) -> Trial:
    return yardstick.trial(setting)


def attempt(
    mechanism: Mechanism,
    settings: Sequence[Setting],
    reference: Reference,
    journal: Journal | None = None,
    processes: int | None = None,
    done: Callable[[int], None] = lambda count: None,
) -> list[Trial]:
    """A trial of each setting over the times of the reference, in their order. `done` is called with the number of
    settings that are through; those in the journal are not run again."""
    kept = journal or Journal(None, {})
    keys = [f"trial {setting.command_line()}" for setting in settings]
    missing = [number for number, key in enumerate(keys) if key not in kept]
    through = len(settings) - len(missing)
    done(through)
    yardstick = Yardstick(mechanism.scene, reference)
    for number, found in in_parallel(_trial, yardstick, [settings[number] for number in missing], processes):
        kept.add(keys[missing[number]], found.as_json())
        through += 1
        done(through)
    return [Trial.from_json(kept[key]) for key in keys]
