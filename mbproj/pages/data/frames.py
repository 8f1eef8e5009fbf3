"""The samples of a run that a page shows: as many as 60 frames a second can show, and a browser can hold."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem

#: Frames a second, and the fewest frames of a run: a short run is watched more slowly.
RATE, FEWEST = 60.0, 600
#: The count of pose numbers (7 for each body and frame) above which frames are left out, and above which no page is
#: made. A browser holds four bytes for each, the file about two.
THINNED, REFUSED = 10_000_000, 60_000_000


@dataclass(frozen=True, eq=False)
class PageFrames:
    """The samples (F,) that are shown, and a remark where these are not all."""

    rows: Integers
    remark: str


def frames_of(time: Array, whole: Integers, bodies: int, full: bool = False) -> PageFrames:
    """The frames of a run with samples at `time` (T,), chosen from the samples `whole`, which are finite. With `full`,
    all of those.

    Raises InputError where no browser could hold them."""
    span = float(time[whole[-1]] - time[whole[0]]) if len(whole) else 0.0
    wanted = len(whole) if full else min(len(whole), max(FEWEST, int(np.ceil(RATE * span))) + 1)
    room = max(2, THINNED // (7 * max(bodies, 1)))
    if full and 7 * bodies * wanted > REFUSED:
        message = f"{wanted} frames of {bodies} bodies are {7e-6 * bodies * wanted:.0f} million numbers"
        hint = f"leave --full out, or take a part with --from and --to; a page holds {REFUSED // 1_000_000} million"
        raise InputError(Problem(f"{message}, more than a browser opens", hint=hint))
    if 14 * bodies > REFUSED:
        message = f"{bodies} bodies are more than a browser shows"
        raise InputError(Problem(message, hint=f"a page holds {REFUSED // 14} bodies"))
    count = wanted if full else min(wanted, room)
    rows = whole if count >= len(whole) else whole[_spread(time[whole], count)]
    return PageFrames(rows, _remark(len(rows), len(whole), count < wanted))


def _spread(time: Array, count: int) -> Integers:
    """Samples that are spread evenly in time: the nearest to `count` even times."""
    even = np.linspace(time[0], time[-1], count)
    after = np.clip(np.searchsorted(time, even), 1, len(time) - 1)
    nearer = np.where(even - time[after - 1] < time[after] - even, after - 1, after)
    return np.unique(nearer)


def _remark(shown: int, recorded: int, cramped: bool) -> str:
    if shown == recorded:
        return ""
    why = "the page would be too large for a browser with more" if cramped else "more than a screen can show"
    return f"{shown} of {recorded} samples are shown: {why}"


def largest_between(values: Array, whole: Integers, rows: Integers) -> Array:
    """The largest of `values` (T, c) since the frame before, (F, c), so that a peak between two frames is not lost."""
    starts = np.concatenate([[whole[0]], rows[:-1] + 1]) if len(rows) else rows
    largest = [np.fmax.reduce(values[start : row + 1], axis=0) for start, row in zip(starts, rows, strict=True)]
    return np.array(largest).reshape(len(rows), values.shape[1])
