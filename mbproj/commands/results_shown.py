"""The results that a command shows: opened with a note where they are incomplete, and reduced to the selected part."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.base.errors import InputError, Problem

if TYPE_CHECKING:
    from mbproj.results.record import Results


def open_with_note(path: Path) -> Results:
    """Open the results at a path, with a note where they are incomplete."""
    from mbproj.results.reader import open_results

    results = open_results(path)
    if results.partial:
        click.echo(f"note: '{results.path}' is incomplete: its run was killed, or still goes on", err=True)
    elif results.status != "complete":
        click.echo(f"note: '{results.path}': {results.status}", err=True)
    return results


def selected(
    runs: Sequence[Results],
    start: float | None,
    stop: float | None,
    markers: Sequence[str] = (),
    joints: Sequence[str] = (),
    acting: Sequence[str] = (),
) -> list[Results]:
    """Reduce the results to a time window and to names. Each name must be in one of the results, and each result must
    have a sample. `acting` are forces, motions, stops and frictions."""
    from math import inf

    from mbproj.base.errors import choose_from
    from mbproj.results.faults import no_such_name
    from mbproj.results.record import ACTING

    low, high = -inf if start is None else start, inf if stop is None else stop
    if not low <= high:
        raise InputError(Problem(f"--from {low:g} is not before --to {high:g}", hint="exchange them"))
    for kind, wanted in (("markers", markers), ("joints", joints)):
        present = list(dict.fromkeys(name for results in runs for name in results.names(kind)))
        for name in wanted:
            if name not in present:
                raise no_such_name(kind, name, present, "the results")
    able = dict.fromkeys(name for results in runs for kind in ACTING for name in results.names(kind))
    able |= dict.fromkeys(name.partition(".")[0] for name in able)
    for name in acting:
        if name not in able:
            message = f"no force, motion, stop or friction '{name}' in the results"
            raise InputError(Problem(message, hint=choose_from(name, able)))
    selection = []
    for results in runs:
        chosen = {
            kind: [name for name in dict.fromkeys(wanted) if name in results.names(kind)] if wanted else None
            for kind, wanted in (("markers", markers), ("joints", joints))
        }
        selection.append(results.select(start=low, stop=high, acting=acting or None, **chosen))
        if not len(selection[-1].time):
            raise _nothing(results, low, high)
    return selection


def _nothing(results: Results, low: float, high: float) -> InputError:
    if not len(results.time):
        return InputError(Problem(f"'{results.path}' holds no samples", hint=f"its status: {results.status}"))
    span = f"its samples go from {results.time[0]:g} s to {results.time[-1]:g} s"
    window = "".join(f" {word} {at:g} s" for word, at in (("from", low), ("to", high)) if abs(at) < float("inf"))
    return InputError(Problem(f"'{results.path}' has no sample{window}", hint=span))


def require_markers(names: Sequence[str], runs: Sequence[Results]) -> None:
    """Raises InputError for a marker that none of the results has."""
    from mbproj.results.faults import no_such_name

    present = list(dict.fromkeys(name for results in runs for name in results.names("markers")))
    for name in names:
        if name not in present:
            raise no_such_name("markers", name, present, "the results")
