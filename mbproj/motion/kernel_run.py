"""A run: in the compiled kernel, in blocks of samples, or for explicit steps of the full formulation in NumPy's loop.

Between two steps a run in the kernel can pause, or wait for inputs from Python. It can follow the steps of another run,
and continue from a mark.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Any, Protocol

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.registry import is_explicit
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.samples import Samples, block_samples, stack
from mbproj.model.system import System
from mbproj.motion.formulations.choice import Choice
from mbproj.motion.formulations.compiled import PHASES, Compiled
from mbproj.motion.marks import START, Mark, Marks, restored_events, resuming, saved_events
from mbproj.motion.report import Halved, Passed, Peak, RowsKept, Tally, with_another
from mbproj.motion.time_events import SHARED, Event, Leg
from mbproj.scene.sampling import output_interval

#: The kernel returns for Ctrl-C and for progress at least this often, in s.
RETURN_SECONDS = 0.1


class Outside(Protocol):
    """Interface of an action on a run from Python, once each `period`."""

    @property
    def period(self) -> float:
        """The time between two instants, in s."""

    def exchange(self, compiled: Compiled, run: Any, leg: Leg) -> Callable[[], None]:
        """Return the function to call where the run waits."""


class Halted(Exception):
    """Raised where a trial of a method ends at t in s, before a contact event. `shaped`: whether the run's end has
    influenced the step to there."""

    def __init__(self, t: float, *, shaped: bool) -> None:
        super().__init__(f"halted at t = {t:.6g} s")
        self.t, self.shaped = t, shaped


class LoopContacts(Protocol):
    """Interface of contacts whose events the kernel's loop handles. `compiled`: the equations with laws for all
    frictions and compliant stops. `halts`: whether the run ends before its first contact event."""

    compiled: Compiled
    halts: bool

    def begin(self, run: Any) -> None:
        """Prepare a run before its first step."""

    def take(self, run: Any) -> list[Event]:
        """Return the events since the last call."""

    def failure(self, run: Any) -> SimulationError | None:
        """Return the error of a run that ended because the kernel could not decide on contacts; None for other ends."""

    def samples(self, samples: Samples, block: Mapping[str, Any]) -> Samples:
        """Return a block of samples with the forces of contacts."""


@dataclass(frozen=True, eq=False)
class Standing:
    """The state of a run between two steps: its counts so far, and the mark from which another method can continue.

    `shaped`: whether the run's end has influenced the way here. `state` returns the state of the system."""

    steps: int
    rejected: int
    evaluations: int
    shaped: bool
    mark: Mark
    state: Callable[[], State]

    @property
    def attempts(self) -> int:
        """The number of steps tried since the start."""
        return self.steps + self.rejected


@dataclass
class Pauses:
    """The pauses of one run by one method. When `due` steps were tried since the start, `look` is called: it returns
    whether the run ends here, and sets `due` anew. The steps do not depend on it. `sampled`: whether the run also makes
    samples."""

    due: int
    look: Callable[[Standing], bool]
    sampled: bool = True


@dataclass
class FollowedSteps:
    """The ends of the steps of a run with error control, in s, and its breaks. A run follows these ends; where there
    are none, it records the ends of its own steps here. `left`: whether a run could not follow, because its breaks or
    its end differ."""

    ends: tuple[float, ...] = ()
    breaks: tuple[float, ...] = ()
    left: bool = False

    @property
    def are_recorded(self) -> bool:
        """Whether a run has recorded its steps."""
        return bool(self.ends)

    def of_another(self) -> FollowedSteps:
        """Return the steps for another run to follow."""
        return FollowedSteps(self.ends, self.breaks)

    def begin(self, run: Any, leg: Leg) -> None:
        """Prepare a run in the kernel before its first step: it follows the known steps, or records its own."""
        if leg.step is not None:
            return
        if not self.ends:
            run.keep_ends()
        elif self.breaks == _times(leg) and self.ends[-1] == leg.end:
            run.follow(list(self.ends))
        else:
            self.left = True

    def finish(self, compiled: Compiled, run: Any, leg: Leg, settings: Settings) -> None:
        """Record the steps after the last one."""
        if leg.step is None and not self.ends:
            self.ends, self.breaks = tuple(run.ends), _times(leg)


@dataclass(frozen=True, eq=False)
class Trace:
    """A run in the kernel: its model, its settings and its leg; the ends `t` (n,) of its steps, their sizes `h` (n,),
    and the kernel's states `y` (n, S) there."""

    compiled: Compiled
    settings: Settings
    leg: Leg
    t: Array
    h: Array
    y: Array


@dataclass
class TracedSteps(FollowedSteps):
    """Steps that also record the states at their ends: `trace`, for a run that came to its end."""

    trace: Trace | None = None

    def begin(self, run: Any, leg: Leg) -> None:
        """Prepare a run before its first step."""
        super().begin(run, leg)
        run.keep_path()

    def finish(self, compiled: Compiled, run: Any, leg: Leg, settings: Settings) -> None:
        """Record the steps and the trace after the last step."""
        super().finish(compiled, run, leg, settings)
        self.trace = Trace(compiled, settings, leg, *run.path)


def _times(leg: Leg) -> tuple[float, ...]:
    return tuple(each.time for each in leg.breaks)


def march(
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
            from mbproj.motion.contacts import Inside

            is_trial = pauses is not None and not pauses.sampled
            inside, steps = Inside(choice, system, state, output_interval(settings), halts=is_trial), None
        is_smooth = is_explicit(settings.integrator) or settings.kinematic is True
        # Stages solved to a tolerance are not smooth.
        smooth = steps if is_smooth and choice.name != "full" else None
        yield from march_in_kernel(choice.compiled, state, settings, tally, marks, pauses, inside, outside, smooth)
    else:  # a run in the kernel does not need these imports
        from mbproj.motion import numpy_loop
        from mbproj.motion.formulations.full import FullFormulation

        formulation = FullFormulation.of(system, state, settings, choice.redundant)
        for sample in numpy_loop.march(formulation, state, tally, marks):
            yield stack([sample])


def march_in_kernel(
    compiled: Compiled,
    state: State,
    settings: Settings,
    tally: Tally,
    marks: Marks | None = None,
    pauses: Pauses | None = None,
    inside: LoopContacts | None = None,
    outside: Outside | None = None,
    steps: FollowedSteps | None = None,
) -> Iterator[Samples | None]:
    """Yield blocks of samples from the start, or from a mark on.

    None is yielded where the kernel returned without samples, so that the caller can check whether the run is still
    wanted. Raises SimulationError where the run cannot go on, and Halted where the contacts `inside` ask for that."""
    asks = None if outside is None else outside.period
    leg, marks = Leg.whole(compiled.system, settings, state.t, asks), marks or Marks()
    compiled = compiled if inside is None else inside.compiled
    run = compiled.run(state, settings, leg if pauses is None or pauses.sampled else leg.without_samples)
    if steps is not None:
        steps.begin(run, leg)
    if inside is not None:
        inside.begin(run)
    if marks.resumed:
        _resume(run, tally, marks.resumed)
    act = None if outside is None else outside.exchange(compiled, run, leg)
    run.keeps_marks = marks.wanted
    marks.newest = lambda: _mark(run, tally)
    running, most = compiled.core.Status.running, block_samples(compiled.system.bodies)
    while run.outcome.status == running:
        block = run.advance(most, RETURN_SECONDS, *(() if pauses is None else (pauses.due,)))
        tally.set_counters(run.counters.tolist())
        tally.phases = dict(zip(PHASES, run.phase_seconds, strict=True))
        tally.position_peak = _peak(compiled, run.position_peak)
        joint_peak = _peak(compiled, run.joint_peak)
        tally.joint_peak = replace(joint_peak, row=max(joint_peak.row - compiled.system.bodies, 0))
        tally.velocity_peak = _peak(compiled, run.velocity_peak)
        _take_events(compiled.system, run, tally, [] if inside is None else inside.take(run))
        tally.halved = _halved(compiled.system, run)
        tally.turned = () if inside is None else tuple(run.contacts["turned"])
        tally.rows = RowsKept.of(run.kept)
        counters = dict(zip(tally.counters(), block["counters"].T, strict=True))
        if len(block["t"]):
            samples = compiled.samples(block, counters)
            yield samples if inside is None else inside.samples(samples, block)
        else:
            tally.reached = float(run.standing["t"])
            yield None
        if act is not None and run.waits:
            act()
        if pauses is not None and run.pauses and pauses.look(_standing(compiled, run, tally)):
            return
        if run.outcome.status == compiled.core.Status.halted:
            raise Halted(run.standing["t"], shaped=run.here()["shaped"])
    undecided = None if inside is None else inside.failure(run)
    if undecided is not None:
        raise undecided
    if steps is not None:
        steps.finish(compiled, run, leg, settings)
    failure = compiled.failure(run, settings)
    if failure is not None:
        from mbproj.motion.failures import of_a_rope

        at = run.standing
        raise of_a_rope(compiled.system, compiled.standing(at["t"], at["y"], at["turns"]), at["h"], failure)


def _take_events(system: System, run: Any, tally: Tally, of_stops: list[Event]) -> None:
    """Add to the tally the state events since the last call, and switches that fixed steps have passed over."""
    switches = None
    if system.programs.size:
        from mbproj.motion.law_switches import switches_of

        switches = switches_of(system)
    if switches is not None:
        known = [switches.event(t, k, direction) for t, k, direction in run.take_met()]
        of_stops = _in_order(known, of_stops) if known else of_stops
        tally.passed = [Passed(switches.owner(k), switches.what(k), first, times) for k, first, times in run.passed]
    tally.met += of_stops


def _in_order(known: list[Event], of_stops: list[Event]) -> list[Event]:
    """Return events in the order in which they became known. The end of bouncing is known, and recorded, with an impact
    before."""
    recorded, t = [(event.time, event) for event in known], 0.0
    for event in of_stops:
        t = t if event.kind == "rest" else event.time
        recorded.append((t, event))
    return [event for _, event in sorted(recorded, key=itemgetter(0))]


def _halved(system: System, run: Any) -> list[Halved]:
    """Return the forces and bodies for which fixed steps were halved."""
    halvings: list[Halved] = []
    for body, force, first, times in run.halved:
        from mbproj.motion.failures import unsolved_owner

        halvings = with_another(halvings, Halved(unsolved_owner(system, body, force), first, times))
    return halvings


def _resume(run: Any, tally: Tally, mark: Mark) -> None:
    """Continue a run from a mark, before its first step. Raises InputError where the mark is not of this scene."""
    with resuming():
        run.resume(dict(_as_one_run(mark)))
        tally.met = restored_events(mark["met"])


def _as_one_run(mark: Mark) -> Mark:
    """Return a mark in the kernel's present form. With stops, older versions of mbproj marked a part of a run. It is
    taken as a whole run where nothing was counted before. Raises ValueError for other parts, and for another law of
    stops."""
    part = mark.get("stops")
    if part is None:
        return mark
    if "contacts" not in mark or any(part["tally"]["counters"].values()):
        raise ValueError("an older mbproj made it, which met stops in another way")
    if mark["contacts"]["pushing"] and part.get("law") != 2:
        raise ValueError("an older mbproj made it, with another law of stops that give way")
    return {name: value for name, value in mark.items() if name != "stops"}


def _mark(run: Any, tally: Tally) -> Mark:
    """Return the mark from which a longer run can continue."""
    mark = run.mark()
    return {**mark, "met": saved_events(_until(tally.met, mark), np.inf)} if mark else START


def _until(met: Sequence[Event], mark: Mapping[str, Any]) -> list[Event]:
    """Return the events up to a mark. Events of stops, frictions and shared loads are selected by number, not by time,
    because the end of bouncing is recorded before it is reached."""
    left, events = mark.get("contacts", {"events": 0})["events"], list[Event]()
    for event in met:
        of_contact = event.kind == SHARED or event.name.startswith(("stop '", "friction '"))
        if (left > 0) if of_contact and "contacts" in mark else event.time <= mark["t"]:
            events.append(event)
        left -= of_contact
    return events


def _standing(compiled: Compiled, run: Any, tally: Tally) -> Standing:
    """Return the standing of a run that has returned between two steps."""
    mark = run.here()
    return Standing(
        steps=tally.steps,
        rejected=tally.rejected_steps,
        evaluations=tally.evaluations,
        shaped=mark["shaped"],
        mark={**mark, "met": saved_events(_until(tally.met, mark), np.inf)},
        state=lambda: compiled.standing(mark["t"], mark["y"], mark["turns"]),
    )


def _peak(compiled: Compiled, peak: Any) -> Peak:
    first = compiled.system.bodies if compiled.system.constraints > compiled.system.bodies else 0
    return Peak(peak.value, compiled.row(peak.row) if peak.value > 0.0 else first, peak.time)
