"""A run that advances on demand: from one instant to the next, with inputs from Python in between.

It is for hardware in the loop, reinforcement learning, and co-simulation. The time loop is that of every run: a step
ends at each instant, and an input is a state of the scene, which changes at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

from mbproj.dynamics.assembly.assemble import State
from mbproj.errors import InputError, Problem
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.outside import Exchange, refuse_outside
from mbproj.model.system import System
from mbproj.scene.records import Settings

#: The most samples and the longest time (s) of the kernel's blocks: so large that only instants end a block.
MOST, SECONDS = 1_000_000, 1e9
_NONE: Mapping[str, float] = {}


@final
class Stepwise:
    """A run that waits at its start, and at each instant start + k period until its end.

    `t` is the time in s, `is_over` whether the end of the run is reached. Raises InputError for a mechanism that cannot
    be run so: with stops or dry friction that sticks, without the kernel, or by the integrator auto.
    """

    def __init__(self, system: System, state: State, settings: Settings, period: float) -> None:
        choice = choose(system, state, settings)
        refuse_outside(system, settings, has_kernel=choice.compiled is not None)
        assert choice.compiled is not None
        self._compiled, self._settings = choice.compiled, settings
        leg = Leg.whole(system, settings, state.t, asks=period)
        self._run: Any = choice.compiled.run(state, settings, leg if leg.step else leg.without_samples)
        self._outside = Exchange(choice.compiled, system, self._run, leg)
        self.t, self.is_over = state.t, False
        self._go_on()

    @property
    def signals(self) -> dict[str, float]:
        """The scene's signals at this instant, by name, before states are set."""
        return self._outside.signals

    @property
    def state(self) -> State:
        """The state at this instant, from which another run can begin."""
        at = self._run.here()
        return self._compiled.standing(at["t"], at["y"], at["turns"])

    def advance(self, until: float | None = None, inputs: Mapping[str, float] = _NONE) -> float:
        """Set states of the scene to these `inputs`, go on to the next instant, and return its time in s.

        With `until`, go on to the first instant that is not before that time. Raises SimulationError where the run
        cannot go on, and InputError where it is over, or an input is no state of the scene."""
        if self.is_over:
            raise InputError(Problem(f"the run is over, at t = {self.t:.6g} s", hint="give it a longer duration"))
        while True:
            self._outside.give(inputs)
            self._go_on()
            inputs = _NONE
            if until is None or self.is_over or self.t >= until - 1e-9 * abs(until):
                return self.t

    def _go_on(self) -> None:
        run = self._run
        run.advance(MOST, SECONDS)
        self.is_over = not run.waits
        if not self.is_over:
            self.t = self._outside.next()
            return
        failure = self._compiled.failure(run, self._settings)
        if failure is not None:
            raise failure
        self.t = float(run.standing["t"])
