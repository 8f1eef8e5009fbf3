"""The march in the compiled kernel, in blocks of samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Any, Protocol

import numpy as np

from mbproj.arrays import Array, Integers, may_overflow
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples, block_samples
from mbproj.integrate.events.halts import Halted, HaltedAt, Watched, WatchedGap, WatchedRow
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.formulations.compiled import PHASES, Compiled
from mbproj.integrate.loop.followed_steps import FollowedSteps
from mbproj.integrate.loop.looks import Looks, Standing
from mbproj.integrate.outcome.failures import of_a_rope, unsolved_owner
from mbproj.integrate.outcome.marks import START, Mark, Marks, restored_events, resuming, saved_events
from mbproj.integrate.outcome.tally import Halved, Passed, Peak, RowsKept, Tally, with_another
from mbproj.model.system import System
from mbproj.scene.records import Settings

#: The kernel comes back for Ctrl-C and for progress at least this often, s.
RETURN_SECONDS = 0.1


class Outside(Protocol):
    """What acts on a run from Python, each `period` in s."""

    @property
    def period(self) -> float:
        """Between two instants, s."""

    def exchange(self, compiled: Compiled, run: Any, leg: Leg) -> Callable[[], None]:
        """What is done where the run waits."""


class Inside(Protocol):
    """Contacts whose events the kernel's loop meets itself."""

    def jumps(self, work: Array) -> Array:
        """The work and the loss in no time since the leg began, in J, as `work` (..., 2 + K) has it."""

    def begin(self, run: Any) -> None:
        """Before the first step."""

    def take(self, run: Any) -> list[Event]:
        """What was recorded since the last call."""

    def samples(self, samples: Samples, block: Mapping[str, Any]) -> Samples:
        """A block of samples with what contacts do."""


def march(
    compiled: Compiled,
    state: State,
    settings: Settings,
    tally: Tally,
    marks: Marks | None = None,
    looks: Looks | None = None,
    leg: Leg | None = None,
    watched: Watched | None = None,
    inside: Inside | None = None,
    outside: Outside | None = None,
    steps: FollowedSteps | None = None,
) -> Iterator[Samples | None]:
    """Blocks of samples from the start to the end of a leg, the whole run where none is given, or from a mark on; None
    where the kernel came back without any, so that its caller can look whether the run is still wanted. Raises
    SimulationError where the run cannot go on, and Halted where it has met something that is `watched`, or that the
    contacts `inside` leave over."""
    asks = None if outside is None else outside.period
    leg, marks = leg or Leg.whole(compiled.system, settings, state.t, asks), marks or Marks()
    run = compiled.run(state, settings, leg if looks is None or looks.sampled else leg.without_samples)
    if watched is not None:
        run.watch(
            [_as_known(each) for each in watched.gaps], [_own(compiled, each) for each in watched.rows], watched.spacing
        )
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
        block = run.advance(most, RETURN_SECONDS, *(() if looks is None else (looks.due,)))
        tally.set_counters(run.counters.tolist())
        tally.phases = dict(zip(PHASES, run.phase_seconds, strict=True))
        tally.position_peak = _peak(compiled, run.position_peak)
        joint_peak = _peak(compiled, run.joint_peak)
        tally.joint_peak = replace(joint_peak, row=max(joint_peak.row - compiled.system.bodies, 0))
        tally.velocity_peak = _peak(compiled, run.velocity_peak)
        _take_events(compiled.system, run, tally, [] if inside is None else inside.take(run))
        tally.halved = _halved(compiled.system, run)
        tally.rows = RowsKept.of(run.kept)
        counters = dict(zip(tally.counters(), block["counters"].T, strict=True))
        if len(block["t"]):
            samples = _samples(compiled, block, counters)
            yield samples if inside is None else inside.samples(samples, block)
        else:
            tally.reached = float(run.standing["t"])
            yield None
        if act is not None and run.waits:
            act()
        if looks is not None and run.pauses and looks.look(_standing(compiled, run, tally)):
            return
    if run.outcome.status == compiled.core.Status.halted:
        raise Halted(_halted_at(compiled, run, inside))
    if steps is not None:
        steps.finish(compiled, run, leg, settings)
    failure = compiled.failure(run, settings)
    if failure is not None:
        at = run.standing
        raise of_a_rope(compiled.system, compiled.standing(at["t"], at["y"], at["turns"]), at["h"], failure)


def _as_known(gap: WatchedGap) -> tuple[Any, ...]:
    """What is watched, where the kernel knows no idleness."""
    return gap._replace(slack=gap.slack + gap.idle)[:-1]


def _own(compiled: Compiled, row: WatchedRow) -> WatchedRow:
    """What is watched of the kernel's rows."""
    other = -1 if row.other < 0 else compiled.own_row(row.other)
    return row._replace(row=compiled.own_row(row.row), other=other)


def _halted_at(compiled: Compiled, run: Any, inside: Inside | None) -> HaltedAt:
    """Where a run stands before a step that meets a stop, or at one."""
    at = run.standing
    state, work = compiled.standing(at["t"], at["y"], at["turns"]), at["y"][compiled.layout["quadratures"]]
    if inside is not None:
        work = work if len(work) else np.zeros(2)
        work = work + inside.jumps(work)
    return HaltedAt(state, at["h"], work, bool(run.here()["shaped"]))


def _take_events(system: System, run: Any, tally: Tally, of_stops: list[Event]) -> None:
    """The events in the state since the last call, and what fixed steps have passed over."""
    switches = switches_of(system)
    if switches is not None:
        known = [switches.event(t, k, direction) for t, k, direction in run.take_met()]
        of_stops = _in_order(known, of_stops) if known else of_stops
        tally.passed = [Passed(switches.owner(k), switches.what(k), first, times) for k, first, times in run.passed]
    tally.met += of_stops


def _in_order(known: list[Event], of_stops: list[Event]) -> list[Event]:
    """Events as they became known: that a bounce will have come to rest is recorded with its impact."""
    recorded, t = [(event.time, event) for event in known], 0.0
    for event in of_stops:
        t = t if event.kind == "rest" else event.time
        recorded.append((t, event))
    return [event for _, event in sorted(recorded, key=itemgetter(0))]


def _halved(system: System, run: Any) -> list[Halved]:
    """For want of what fixed steps were halved."""
    found: list[Halved] = []
    for body, force, first, times in run.halved:
        found = with_another(found, Halved(unsolved_owner(system, body, force), first, times))
    return found


def _resume(run: Any, tally: Tally, mark: Mark) -> None:
    """Before the first step: the run goes on from a mark. Raises InputError where it is not of this scene."""
    with resuming():
        run.resume(dict(mark))
        tally.met = restored_events(mark["met"])


def _mark(run: Any, tally: Tally) -> Mark:
    """Where a longer run can go on from."""
    mark = run.mark()
    return {**mark, "met": saved_events(_until(tally.met, mark), np.inf)} if mark else START


def _until(met: Sequence[Event], mark: Mapping[str, Any]) -> list[Event]:
    """The events up to a mark. When a bounce will have come to rest is known before: those of contacts are counted, of
    stops and frictions alike."""
    left, found = mark.get("contacts", {"events": 0})["events"], list[Event]()
    for event in met:
        of_contact = "contacts" in mark and event.name.startswith(("stop '", "friction '"))
        if (left > 0) if of_contact else event.time <= mark["t"]:
            found.append(event)
        left -= of_contact
    return found


def _standing(compiled: Compiled, run: Any, tally: Tally) -> Standing:
    """Where a run stands that has come back between two steps."""
    mark = run.here()
    return Standing(
        steps=tally.steps,
        rejected=tally.rejected_steps,
        evaluations=tally.evaluations,
        shaped=mark["shaped"],
        mark={**mark, "met": saved_events(_until(tally.met, mark), np.inf)},
        state=lambda: compiled.standing(mark["t"], mark["y"], mark["turns"]),
    )


def _samples(compiled: Compiled, block: Mapping[str, Any], counters: Mapping[str, Integers]) -> Samples:
    """A block in the coordinates of all formulations; of a run that is lost it may overflow there."""
    with may_overflow():
        return compiled.samples(block, counters)


def _peak(compiled: Compiled, peak: Any) -> Peak:
    first = compiled.system.bodies if compiled.system.constraints > compiled.system.bodies else 0
    return Peak(peak.value, compiled.row(peak.row) if peak.value > 0.0 else first, peak.time)
