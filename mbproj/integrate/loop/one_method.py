"""The march by one method, in the chosen formulation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples, stack
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.loop.compiled_march import Outside
from mbproj.integrate.loop.compiled_march import march as march_compiled
from mbproj.integrate.reporting.marks import Marks
from mbproj.integrate.reporting.tally import Tally
from mbproj.model.system import System
from mbproj.registry import is_explicit
from mbproj.scene.records import Settings
from mbproj.scene.sampling import output_interval

if TYPE_CHECKING:
    from mbproj.integrate.loop.followed_steps import FollowedSteps
    from mbproj.integrate.loop.pauses import Pauses


def march_by_one_method(
    choice: Choice,
    system: System,
    state: State,
    settings: Settings,
    *,
    tally: Tally,
    marks: Marks | None = None,
    pauses: Pauses | None = None,
    outside: Outside | None = None,
    steps: FollowedSteps | None = None,
) -> Iterator[Samples | None]:
    """Yield samples in the order of time, in portions as they come; None where time has passed without a sample."""
    marks = marks or Marks()
    if choice.compiled is not None:
        inside = None
        if system.has_contacts:
            from mbproj.integrate.stops.inside import Inside

            is_trial = pauses is not None and not pauses.sampled
            inside, steps = Inside(choice, system, state, output_interval(settings), halts=is_trial), None
        is_smooth = is_explicit(settings.integrator) or settings.kinematic is True
        own = steps if is_smooth and choice.name != "full" else None  # stages solved to a tolerance are not smooth
        yield from march_compiled(choice.compiled, state, settings, tally, marks, pauses, inside, outside, own)
    else:  # a run in the kernel does not need these imports
        from mbproj.integrate.formulations.full import FullFormulation
        from mbproj.integrate.loop.march import march

        formulation = FullFormulation.of(system, state, settings, choice.redundant)
        for sample in march(formulation, state, tally, marks):
            yield stack([sample])
