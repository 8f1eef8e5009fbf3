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
from mbproj.studies.trial import Trial, trial
from mbproj.studies.workers import in_parallel


@dataclass
class _Shared:
    """What every worker has: the scene, and what its runs are held against."""

    scene: Scene
    reference: Reference

    @cached_property
    def mechanism(self) -> Mechanism:
        """Compiled and assembled once in each process."""
        return Mechanism.of(self.scene)


def _attempt(shared: _Shared, setting: Setting) -> Trial:
    times = shared.reference.times
    found = trial(solve(shared.mechanism, setting, times), shared.reference)
    if setting.tolerance is None:
        return found
    # Samples between the steps cost evaluations that are not the setting's own: what it costs, a run without them says.
    report = solve(shared.mechanism, setting, sample_times(float(times[-1]), 1)).report
    return found if report is None else replace(
        found, counters=report.counters, seconds=report.integration_cpu_seconds
    )


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
    shared = _Shared(mechanism.scene, reference)
    for number, found in in_parallel(_attempt, shared, [settings[number] for number in missing], processes):
        kept.add(keys[missing[number]], found.as_json())
        through += 1
        done(through)
    return [Trial.from_json(kept[key]) for key in keys]
