"""A run that goes on when it is told to: from one instant to the next, with inputs from Python in between.

It is for hardware in the loop, reinforcement learning, and co-simulation. The time loop is that of every run: a step
ends at each instant, and what is set there is a state of the scene, which changes at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

from mbproj.dynamics.assembly.assemble import State
from mbproj.errors import InputError, Problem
from mbproj.functions.program import CHANNELS
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.choice import choose
from mbproj.kernel.loads import programs
from mbproj.model.system import System
from mbproj.registry import AUTOMATIC
from mbproj.scene.records import Settings
from mbproj.scene.text.suggestions import choose_from

#: Steps are counted in blocks of so many samples, and of so many seconds.
MOST, SECONDS = 1_000_000, 1e9
_NONE: Mapping[str, float] = {}


@final
class Stepwise:
    """Waits at the start of a run, and at each instant start + k period until its end.

    `t` is the time in s, `is_over` whether the end of the run is reached. Raises InputError where a mechanism cannot be
    run so: with stops or dry friction that sticks, without the kernel, or by the integrator auto.
    """

    def __init__(self, system: System, state: State, settings: Settings, period: float) -> None:
        choice = choose(system, state, settings)
        _refuse(system, settings, has_kernel=choice.compiled is not None)
        assert choice.compiled is not None
        self._compiled, self._settings, self._system = choice.compiled, settings, system
        leg = Leg.whole(system, settings, state.t, asks=period)
        self._run: Any = choice.compiled.run(state, settings, leg if leg.step else leg.without_samples)
        self._numbers = {name: at for at, name in enumerate(system.names.states)}
        self._programs = programs(choice.compiled.core, system.signals, CHANNELS + system.channels.size)
        self._instants = iter([each.time for each in leg.breaks if each.asks])
        self.t, self.is_over = state.t, False
        self._go_on()

    @property
    def signals(self) -> dict[str, float]:
        """The scene's signals here, by name, before what is set here."""
        return dict(zip(self._system.names.signals, self._run.values(self._programs), strict=True))

    @property
    def state(self) -> State:
        """The state here, from which another run can begin."""
        at = self._run.here()
        return self._compiled.standing(at["t"], at["y"], at["turns"])

    def advance(self, until: float | None = None, inputs: Mapping[str, float] = _NONE) -> float:
        """Sets states of the scene to these `inputs`, and goes on to the next instant, or to the first that is not
        before `until`; the time there, in s. Raises SimulationError where the run cannot go on, and InputError where it
        is over, or an input is no state of the scene."""
        given = [(self._number(name), float(value)) for name, value in inputs.items()]
        if self.is_over:
            raise InputError(Problem(f"the run is over, at t = {self.t:.6g} s", hint="give it a longer duration"))
        while True:
            self._run.give(given)
            self._go_on()
            given = []
            if until is None or self.is_over or self.t >= until - 1e-9 * abs(until):
                return self.t

    def _number(self, name: str) -> int:
        if name not in self._numbers:
            hint = choose_from(name, self._numbers) if self._numbers else "write it as  states: {u: {derivative: 0}}"
            raise InputError(Problem(f"'{name}' is no state of the scene", hint=hint))
        return self._numbers[name]

    def _go_on(self) -> None:
        run = self._run
        run.advance(MOST, SECONDS)
        self.is_over = not run.waits
        if not self.is_over:
            self.t = next(self._instants)
            return
        failure = self._compiled.failure(run, self._settings)
        if failure is not None:
            raise failure
        self.t = float(run.standing["t"])


def _refuse(system: System, settings: Settings, *, has_kernel: bool) -> None:
    if system.has_contacts:
        what = "stops and dry friction that sticks cannot be run step by step from Python"
        raise InputError(Problem(what, hint="let them give way: 'stiffness', 'regularised'"))
    if not has_kernel:
        what = "a run step by step is made in the kernel"
        raise InputError(Problem(what, hint="let 'formulation' be auto, reduced or planar"))
    if settings.integrator == AUTOMATIC:
        what = "the integrator auto cannot be run step by step"
        raise InputError(Problem(what, hint="choose one, as dop853 or radau5"))
