"""The forces or bodies that limited the smaller steps of a run, as a table or for JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.base.errors import InputError, Problem
from mbproj.base.registry import AUTOMATIC, WHERE_SMOOTH
from mbproj.commands.report.text import columns
from mbproj.commands.stored_run import stored_scene

if TYPE_CHECKING:
    from mbproj.motion.stiffness import StepLimit
    from mbproj.results.record import Results

#: The number of smaller steps that are examined, and the most bodies that are named.
LOOKED_AT, NAMED = 8, 3


def limits_of(results: Results) -> list[StepLimit]:
    """The limits of steps not larger than the median, chosen evenly over the run. Raises InputError for fixed steps."""
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.linear.states import stored_state
    from mbproj.motion.stiffness import step_limit

    settings = results.settings
    if results.attributes.get("kinematic"):
        raise InputError(Problem(f"{results.path}: the run is kinematic, and no error limits its steps"))
    if settings.tolerance is None:
        raise InputError(
            Problem(f"{results.path}: its steps are fixed, and nothing limits them", hint="run it with a --tolerance")
        )
    system, sizes, time = compile_system(stored_scene(results)), results["diagnostics/step_size"], results.time
    smaller = np.flatnonzero((sizes > 0.0) & (sizes <= np.median(sizes)))
    chosen = smaller[np.unique(np.linspace(0, len(smaller) - 1, min(len(smaller), LOOKED_AT)).astype(int))]
    return [
        step_limit(
            system,
            stored_state(system, results, float(time[at])),
            replace(settings, integrator=_method(results, float(time[at]))),
            float(sizes[at]),
        )
        for at in chosen
    ]


def _method(results: Results, time: float) -> str:
    """The method that made the steps at a time."""
    if results.settings.integrator != AUTOMATIC:
        return results.settings.integrator
    changes = [event.kind.split()[0] for event in results.events if event.name == "integrator" and event.time < time]
    return changes[-1] if changes else WHERE_SMOOTH


def facts(results: Results) -> dict[str, Any]:
    """The limits as a dictionary for JSON."""
    return {
        "file": str(results.path),
        "steps": [{**asdict(each), "shares": dict(each.shares)} for each in limits_of(results)],
    }


def lines(results: Results) -> Iterator[str]:
    """A line for each step."""
    return table(results, limits_of(results))


def remark(limits: Sequence[StepLimit]) -> str:
    """A sentence for a picture: the force that limits each step, or the body with the largest part in its error."""
    times: dict[str, list[str]] = {}
    for each in limits:
        what = each.reason.partition(":")[0] or (_owner(each.shares[0][0]) if each.shares else "nothing")
        times.setdefault(what, []).append(f"{each.time:.3g}")
    return "; ".join(f"steps limited by {what} at {', '.join(moments)} s" for what, moments in times.items())


def table(results: Results, limits: Sequence[StepLimit]) -> Iterator[str]:
    """A line for each step."""
    rows = [
        [f"{each.time:.4g} s", f"{each.step:.3g} s", f"{each.error:.2g}", _bodies(each), each.reason or "accuracy"]
        for each in limits
    ]
    yield f"{results.path}: what limits the smaller steps; errors in tolerances, bodies with their part in the error"
    yield columns(["at", "step", "error", "bodies", "held by"], rows)


def _owner(name: str) -> str:
    return name if name.startswith("state ") else f"body '{name}'"


def _bodies(limit: StepLimit) -> str:
    return ", ".join(f"{name} {100.0 * part:.0f} %" for name, part in limit.shares[:NAMED] if part >= 0.01)
