"""The labels of overlaid results: the settings in which they differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from mbproj.results import Results

#: The text of a setting in a legend; others read "name = value".
READS: Mapping[str, str] = {
    "projection.method": "{}",
    "integrator": "{}",
    "formulation": "{}",
    "acceleration": "{}",
    "step": "h = {:g} s",
    "tolerance": "tolerance {:g}",
    "projection.tolerance": "projection tolerance {:g}",
    "projection.every": "every {} steps",
    "projection.threshold": "threshold {:g}",
    "projection.test": "test {}",
    "projection.energy": "energy row {}",
    "projection.momentum": "momentum rows {}",
    "projection.alpha": "α = {:g}",
    "projection.max_iterations": "at most {} iterations",
}
#: Settings that follow from the method, or concern only the duration and the sampling.
MINOR = ("projection.gains", "projection.alpha", "duration", "output_step")


def derive_labels(results: Sequence[Results]) -> list[str]:
    """A different label for each result: the settings and parameters that differ, or the names of the files."""
    stems = [stem(result) for result in results]
    if len(results) == 1:
        return stems
    settings = [_flat(result) for result in results]
    keys = dict.fromkeys(key for values in settings for key in values)
    differing = [key for key in keys if len({values.get(key) for values in settings}) > 1]
    telling = [key for key in differing if key not in MINOR] or differing
    labels = [", ".join(_reads(key, s[key]) for key in telling if s.get(key) is not None) for s in settings]
    if len({result.title for result in results}) > 1 or len(set(labels)) < len(labels) or not all(labels):
        names = stems if len(set(stems)) == len(stems) else [str(result.path) for result in results]
        labels = [f"{name}: {label}" if label else name for name, label in zip(names, labels, strict=True)]
    return labels


def stem(result: Results) -> str:
    """The name of the results file without the endings .h5 and .part."""
    path = result.path.with_suffix("") if result.partial else result.path
    return path.stem


def _flat(result: Results) -> dict[str, Any]:
    """The settings by dotted name, projection method first, and the changed parameters."""
    settings = asdict(result.settings)
    projection = {f"projection.{key}": value for key, value in settings.pop("projection").items()}
    return {**projection, **settings, **result.overrides}


def _reads(key: str, value: Any) -> str:
    return READS[key].format(value) if key in READS else f"{key.rpartition('.')[2]} = {value}"
