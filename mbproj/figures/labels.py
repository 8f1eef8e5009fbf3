"""The labels of overlaid results: the settings in which they differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mbproj.results import Results
from mbproj.settings import SETTINGS, SettingEntry

#: Settings that follow from the method, or concern only the duration and the sampling.
MINOR = ("gains", "alpha", "duration", "output_step")


def derive_labels(results: Sequence[Results]) -> list[str]:
    """A different label for each result: the settings and parameters that differ, or the names of the files."""
    stems = [stem(result) for result in results]
    if len(results) == 1:
        return stems
    settings = [_flat(result) for result in results]
    keys = dict.fromkeys(key for values in settings for key in values)
    differing = [key for key in keys if len({values.get(key) for values in settings}) > 1]
    telling = [key for key in differing if getattr(key, "name", "") not in MINOR] or differing
    labels = [", ".join(_reads(key, s[key]) for key in telling if s.get(key) is not None) for s in settings]
    if len({result.title for result in results}) > 1 or len(set(labels)) < len(labels) or not all(labels):
        names = stems if len(set(stems)) == len(stems) else [str(result.path) for result in results]
        labels = [f"{name}: {label}" if label else name for name, label in zip(names, labels, strict=True)]
    return labels


def stem(result: Results) -> str:
    """The name of the results file without the endings .h5 and .part."""
    path = result.path.with_suffix("") if result.partial else result.path
    return path.stem


def _flat(result: Results) -> dict[SettingEntry | str, Any]:
    """The settings, those of the projection first, and the changed parameters by name."""
    flat: dict[SettingEntry | str, Any] = {}
    for entry in sorted(SETTINGS.values(), key=lambda entry: -len(entry.path)):
        flat[entry] = entry.of(result.settings)
    return flat | dict(result.overrides)


def _reads(key: SettingEntry | str, value: Any) -> str:
    if isinstance(key, str):
        return f"{key} = {value}"
    return (key.label or f"{key.name.replace('_', ' ')} {{}}").format(f"{value:g}" if key.kind == "float" else value)
