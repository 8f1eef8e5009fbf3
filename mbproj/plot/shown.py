"""Which names a picture has room for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.results import Results

#: Rows of panels in one picture, and lines in one panel.
MAX_ROWS, MAX_LINES = 8, 7


def all_names(results: Sequence[Results], kind: str) -> list[str]:
    """Every name of `kind` in any of the results, in the order of the first."""
    return list(dict.fromkeys(name for result in results for name in result.names(kind)))


def rows(results: Sequence[Results], kind: str, option: str) -> tuple[list[str], str]:
    """The names that are drawn a row each, and a remark where they are not all."""
    names = all_names(results, kind)
    if len(names) <= MAX_ROWS:
        return names, ""
    return names[:MAX_ROWS], f"the first {MAX_ROWS} of {len(names)} {kind}: choose others with {option}"


def largest_joints(results: Sequence[Results], path: str) -> tuple[list[str], str]:
    """The joints whose values in the dataset `path` (T, nj, ...) are the largest, and a remark where not all are."""
    names = all_names(results, "joints")
    if len(names) <= MAX_LINES:
        return names, ""
    size = dict.fromkeys(names, 0.0)
    for result in results:
        values = np.abs(result[path]).reshape(len(result.time), len(result.names("joints")), -1)
        for name, value in zip(result.names("joints"), np.nanmax(values, axis=(0, 2), initial=0.0), strict=True):
            size[name] = max(size[name], float(value))
    chosen = sorted(sorted(names, key=lambda name: -size[name])[:MAX_LINES], key=names.index)
    return chosen, f"the {MAX_LINES} largest of {len(names)} joints: choose others with --joint"
