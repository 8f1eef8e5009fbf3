"""A run that advances on demand: from one instant to the next, with inputs from Python in between.

It is for hardware in the loop, reinforcement learning, and co-simulation. The time loop is that of every run: a step
ends at each instant, and an input is a state of the scene, which changes at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, final

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.base.registry import AUTOMATIC
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.samples import Samples
from mbproj.functions.program import CHANNELS
from mbproj.kernel.models import programs
from mbproj.model.system import System
from mbproj.motion.formulations.choice import Choice, choose, refuse_without_steps
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.kernel_run import march
from mbproj.motion.marks import Marks
from mbproj.motion.report import Tally
from mbproj.motion.time_events import Leg

# --- Inputs to a run from Python --------------------------------------------------------------------------------------
# A controller that reads signals at instants and sets states, or the caller's own loop.


#: Called with the time in s and the signals by name; returns states by name, or None.
Function = Callable[[float, Mapping[str, float]], Mapping[str, float] | None]


@final
class Exchange:
    """The exchange with a run in the kernel where it waits: at its start and once each period."""

    def __init__(self, compiled: Compiled, system: System, run: Any, leg: Leg) -> None:
        self._run, self._signals = run, system.names.signals
        self._numbers = {name: at for at, name in enumerate(system.names.states)}
        self._programs = compiled.core.Programs(functions=programs(system.signals, CHANNELS + system.channels.size))
        self._instants: Iterator[float] = iter([each.time for each in leg.breaks if each.asks])

    def next(self) -> float:
        """Return the time of the next instant, in s."""
        return next(self._instants)

    @property
    def signals(self) -> dict[str, float]:
        """The scene's signals at this instant, by name, before states are set."""
        return dict(zip(self._signals, self._run.values(self._programs), strict=True))

    def give(self, inputs: Mapping[str, float]) -> None:
        """Set states of the scene. Raises InputError for one that does not exist, or a value that is not finite."""
        self._run.give([self._input(name, float(value)) for name, value in inputs.items()])

    def _input(self, name: str, value: float) -> tuple[int, float]:
        if name not in self._numbers:
            hint = choose_from(name, self._numbers) if self._numbers else "write it as  states: {u: {derivative: 0}}"
            raise InputError(Problem(f"'{name}' is no state of the scene", hint=hint))
        if not abs(value) < float("inf"):
            raise InputError(
                Problem(f"input '{name}' is {value}, which is not finite", hint="check the code that computes it")
            )
        return self._numbers[name], value


@dataclass(frozen=True)
class Acting:
    """A `function` from Python that acts once each `period`, in s."""

    function: Function
    period: float

    def exchange(self, compiled: Compiled, run: Any, leg: Leg) -> Callable[[], None]:
        """Return the function to call where the run waits."""
        exchange = Exchange(compiled, compiled.system, run, leg)

        def act() -> None:
            exchange.give(self.function(exchange.next(), exchange.signals) or {})

        return act


def march_with(
    function: Function,
    period: float | None,
    choice: Choice,
    system: System,
    state: State,
    settings: Settings,
    tally: Tally,
    marks: Marks,
) -> Iterator[Samples | None]:
    """Return samples of a run on which a function acts once each `period`. Raises InputError where none can act."""
    if period is None or not 0.0 < period < float("inf"):
        raise InputError(Problem(f"a controller acts each period, a time in s, found {period!r}", hint="give a period"))
    refuse_outside(system, settings, has_kernel=choice.compiled is not None)
    outside = Acting(function, period)
    return march(choice, system, state, settings, tally=tally, marks=marks, outside=outside)


def refuse_outside(system: System, settings: Settings, *, has_kernel: bool) -> None:
    """Raise InputError where nothing from Python can act on a run."""
    if system.has_contacts:
        what = "stops and dry friction that sticks cannot be run step by step from Python"
        raise InputError(Problem(what, hint="let them give way: 'stiffness', 'regularised'"))
    if not has_kernel:
        what = "a run step by step is made in the kernel"
        raise InputError(Problem(what, hint="let 'formulation' be auto, reduced or planar"))
    if settings.integrator == AUTOMATIC:
        what = "the integrator auto cannot be run step by step"
        raise InputError(Problem(what, hint="choose one, as dop853 or radau5"))


# --- A run that advances on demand ------------------------------------------------------------------------------------


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
        refuse_without_steps(choice, settings)
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
