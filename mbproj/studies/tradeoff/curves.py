"""The families of a trade-off's settings: each family is a line of its diagrams."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.measure.setting import Setting
from mbproj.studies.tradeoff.grid import schedule_label


def kind(setting: Setting) -> str:
    """The integrator of a setting and how its step is chosen: fixed steps or a tolerance."""
    return f"{setting.integrator}, {'fixed steps' if setting.tolerance is None else 'tolerance'}"


def by_integrator(trials: Sequence[Measurement]) -> dict[str, list[int]]:
    """Indices of the trials that have the projection and schedule of the first trial, by integrator and kind of
    step."""
    plain = schedule_label(trials[0].setting)
    return _grouped(trials, lambda setting: kind(setting) if schedule_label(setting) == plain else None)


def studied(trials: Sequence[Measurement], front: Sequence[int]) -> str:
    """The integrator and kind of step with most settings on the front, among those that were tried with several
    projections."""
    tried = {
        name: len({schedule_label(trials[index].setting) for index in indices})
        for name, indices in _grouped(trials, kind).items()
    }
    wins = {name: sum(kind(trials[index].setting) == name for index in front) for name in tried}
    return max(tried, key=lambda name: (tried[name] > 1, wins[name]))


def by_projection(trials: Sequence[Measurement], name: str) -> dict[str, list[int]]:
    """Indices of the trials of one integrator and kind of step, by projection and schedule."""
    return _grouped(trials, lambda setting: schedule_label(setting) if kind(setting) == name else None)


def _grouped(trials: Sequence[Measurement], key: Callable[[Setting], str | None]) -> dict[str, list[int]]:
    """Indices of the trials, grouped by `key` of their settings; trials whose key is None are left out."""
    groups: dict[str, list[int]] = {}
    for index, trial in enumerate(trials):
        name = key(trial.setting)
        if name is not None:
            groups.setdefault(name, []).append(index)
    return groups
