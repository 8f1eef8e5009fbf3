"""Inputs to a run from Python: a controller that reads signals at instants and sets states, or the caller's own
loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, final

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples
from mbproj.errors import InputError, Problem, choose_from
from mbproj.functions.program import CHANNELS
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.kernel_run import march
from mbproj.integrate.reporting.marks import Marks
from mbproj.integrate.reporting.tally import Tally
from mbproj.kernel.models import programs
from mbproj.model.system import System
from mbproj.registry import AUTOMATIC
from mbproj.scene.records import Settings

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
