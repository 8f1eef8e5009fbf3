"""The names that a picture has room for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.results import Results

#: The most lines in one panel.
MAX_LINES = 7


def all_names(results: Sequence[Results], kind: str) -> list[str]:
    """Every name of `kind` in any of the results, in the order of the first."""
    return list(dict.fromkeys(name for result in results for name in result.names(kind)))


def note(kind: str, drawn: int, all_of_them: int, others: str) -> str:
    """A note where only the first names of a kind are drawn. `others` tells how to see the others."""
    return "" if drawn == all_of_them else f"the first {drawn} of {all_of_them} {kind}: {others}"


def largest_joints(results: Sequence[Results], path: str, most: int = MAX_LINES) -> tuple[list[str], str]:
    """The joints with the largest values in the dataset `path` (T, nj, ...), and a remark where these are not all."""
    names = all_names(results, "joints")
    if len(names) <= most:
        return names, ""
    size = dict.fromkeys(names, 0.0)
    for result in results:
        values = np.abs(result[path]).reshape(len(result.time), len(result.names("joints")), -1)
        for name, value in zip(result.names("joints"), np.nanmax(values, axis=(0, 2), initial=0.0), strict=True):
            size[name] = max(size[name], float(value))
    chosen = sorted(sorted(names, key=lambda name: -size[name])[:most], key=names.index)
    return chosen, f"the {most} largest of {len(names)} joints: choose others with --joint"
