"""The march of a mechanism with stops or dry friction: legs of the time loop, between the times at which one of them
changes.

while t < end:
    run a leg until something is met            # gaps closed, contacts that pull, sliding at rest, sticking that slips
    find when, on the step itself               # locate
    step there, and see what happens            # meet: impact, contact, release, stick, slip
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.automatic.march import Automatic
from mbproj.integrate.events.halts import Halted, HaltedAt, Watched, resting, watched_gaps
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.loop.one_method import march_by_one_method
from mbproj.integrate.loop.pauses import Pauses
from mbproj.integrate.reporting.marks import START, Mark, Marks, resuming, saved_events
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.stiff.modes_at_a_step import FastModes
from mbproj.integrate.stops.failures import never_ends
from mbproj.integrate.stops.inside import Inside, inside_of, is_of_the_march, meets_inside
from mbproj.integrate.stops.legs import Reached, chosen, one_step, only
from mbproj.integrate.stops.locate import Margins, locate, margins
from mbproj.integrate.stops.meeting import Meeting, meet
from mbproj.integrate.stops.saved import restore, saved
from mbproj.integrate.stops.sharing import changed, sharing
from mbproj.integrate.stops.variants import Variant, Variants
from mbproj.integrate.stops.watching import Meaning, Met, watched_of
from mbproj.integrate.stops.whole import (
    integrals_of_the_whole,
    of_the_whole,
    row_of_the_whole,
    speed_of,
    stored_by,
    stored_in_stops,
)
from mbproj.model.contacts import Contacts
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS


class StopMarch:
    """Scratch of a run from `start`: where it is, what touches, and what has been lost and worked in no time."""

    def __init__(
        self, choice: Choice, system: System, start: State, settings: Settings, tally: Tally, marks: Marks
    ) -> None:
        self.automatic: Automatic | None = None
        self.marks, self.mark = marks, marks.resumed
        self.system, self.settings, self.tally = system, settings, tally
        self.whole = Leg.whole(system, settings, start.t)
        self.variants = Variants(choice, system, settings)
        self.state, self.contacts, self.push = start, Contacts(), 0.0
        self.meets_inside = meets_inside(choice, system, start)
        self.fastest = max(speed_of(system, start), THRESHOLDS.slow_motion / self.whole.interval)
        self.integrals = np.zeros(2 + len(system.names.frictions))  # work, dissipation, and that of each friction
        self.shaped = False  # whether a longer run may meet things in other bits
        self.met_at, self.recorded, self.met_often = -np.inf, -np.inf, 0
        self.shared: tuple[str, ...] = ()  # whose forces share a load at will
        self._inner, self._resumed, self._begin, self._met = Marks(), START, dict[str, Any](), 0
        self._last: tuple[Mark, dict[str, Any], int] | None = None

    def samples(self) -> Iterator[Samples | None]:
        """Those of the whole run, or from a mark on. Raises InputError where that is not of this mechanism."""
        self.marks.newest = self._newest
        if self.mark:
            with resuming():
                restore(self, self.mark["stops"])
                self.recorded = float(self.mark["t"])
                self._resumed = {name: value for name, value in self.mark.items() if name != "stops"}
                self.meets_inside = self.meets_inside and not is_of_the_march(self._resumed)
        elif not self.meets_inside:
            self._meet(self.state, Meaning())
        while self.state.t < self.whole.end:
            inside = inside_of(self)
            variant = self.variants.of(inside.laws if inside else self.contacts, self.state)
            try:
                watched, _ = watched_of(variant, self.push, self.fastest, self.whole.interval)
                yield from self._leg(variant, self._next_leg(), None if inside else watched, inside)
            except Halted as halted:
                if inside is None:
                    yield from self._to_stop(variant, halted.standing)
                else:
                    self.shaped, self.state = self.shaped or halted.standing.shaped, halted.standing.state
                    inside.tell(self)
                    if inside.left_over is not None or np.isinf(self.met_at):
                        self._meet(self.state, inside.left_over or Meaning())
                    else:  # rows that are held have come to depend on each other
                        self.meets_inside = False

    def _next_leg(self) -> Leg:
        """From where the run is to its end; of fixed steps that are cut, to the next of their grid."""
        t = self.state.t
        whole = self.whole if t == self.whole.start else self.whole.after_actions(t)
        if whole.step is None:
            assert whole.times is not None
            duration = whole.end - t
            return replace(whole, start=t, duration=duration, times=whole.times.part(t, t + duration))
        made = (t - whole.start) / whole.step
        k = round(made)
        if abs(made - k) > THRESHOLDS.on_grid or k >= whole.count:  # near the end there is a step as well
            k = int(np.ceil(made))
            h = (whole.end if k >= whole.count else whole.start + k * whole.step) - t
            return replace(whole, start=t, duration=h, step=h, count=1, every=1)
        return replace(whole, start=t, duration=whole.end - t, count=whole.count - k, every=1)

    def _leg(
        self, variant: Variant, leg: Leg, watched: Watched | None, inside: Inside | None = None
    ) -> Iterator[Samples | None]:
        """The samples of a leg that are due; at its end the run is there. Raises Halted. A run can go on from within a
        leg that lasts to its end."""
        own, start = Tally(), self.tally.counters()
        lasts = not (watched is None and inside is None) and leg.end == self.whole.end
        shaped = self.shaped or (self.automatic is not None and self.automatic.shaped)
        inner = Marks(self._resumed, self.marks.wanted and lasts and not shaped)
        self._resumed = START
        self._begin = saved(self) if inner.wanted else {}
        self._met = len(self.tally.met)
        settings = replace(self._by_method(), duration=leg.duration, step=leg.step)
        if leg.step is not None:
            settings = replace(settings, tolerance=None)
        last = None
        before, stored = self.integrals, stored_by(self.system, self.state)
        self._inner = inner
        try:
            for samples in chosen(variant, self.state, settings, leg, own, watched, inner, self.automatic, inside):
                self._count(start, own)
                if samples is None:
                    yield None
                    continue
                work = before + integrals_of_the_whole(variant, samples.work)
                work[:, 1] -= stored_in_stops(variant, samples) - stored
                last = replace(samples, work=work), variant
                times = self._times(samples.t)
                due = ~np.isnan(times) & (times > self.recorded)
                if due.any():
                    self.recorded = float(times[due][-1])
                    counted = {name: start[name] + values[due] for name, values in samples.counters.items()}
                    whole = last[0] if inside is not None else of_the_whole(variant, last[0])
                    yield replace(only(whole, due), t=times[due], counters=counted)
        except Halted as halted:
            self.integrals = before + integrals_of_the_whole(variant, halted.standing.work)
            self.integrals[1] -= stored_by(self.system, halted.standing.state) - stored
            raise
        finally:
            self._count(start, own)
            self._end_leg(own)
            self._last, self._inner = self._known(), Marks()
        assert last is not None
        self.integrals = last[0].work[-1].copy()
        if inside is not None:
            inside.tell(self)
        self.state = replace(last[0].state(-1), t=leg.end)

    def _by_method(self) -> Settings:
        """The settings with the method that makes the steps at present."""
        now = self.automatic
        return self.settings if now is None else replace(self.settings, integrator=now.plan.method)

    def _times(self, t: Array) -> Array:
        """The times of the whole run's samples that these are, NaN for those that are none."""
        whole = self.whole
        if whole.step is None:
            found = np.where(whole.records_at(t), t, np.nan)
        else:
            n = np.round((t - whole.start) / whole.step)
            is_one = (np.abs(t - whole.start - n * whole.step) <= THRESHOLDS.on_grid * whole.step) & (
                n % whole.every == 0
            )
            found = np.where(is_one, whole.start + n * whole.step, np.nan)
        return np.where(t >= whole.end - 4.0 * np.spacing(whole.end), whole.end, found)

    def _count(self, start: dict[str, int], own: Tally) -> None:
        """The whole run's counters and peaks, with those of a leg."""
        self.tally.set_counters(start[name] + value for name, value in own.counters().items())
        self.tally.reached = own.reached
        for name in ("position_peak", "velocity_peak", "joint_peak"):
            peak = getattr(own, name)
            of_joints = 0 if name == "joint_peak" else self.system.bodies
            row = row_of_the_whole(self.system, self.contacts, peak.row, of_joints)
            if peak.value > getattr(self.tally, name).value and (of_joints or row < self.system.joints.size):
                setattr(self.tally, name, replace(peak, row=row))

    def _end_leg(self, own: Tally) -> None:
        """What belongs to a leg as a whole: its events, what it halved and passed over, the seconds of phases."""
        if self.automatic is not None:
            self.automatic.plan.end_leg(own)
        self.tally.join(own)

    def _newest(self) -> Mark:
        """Where a longer run can go on from: what the leg at hand knows, and where that began."""
        found = self._known()
        if found is None:
            return self.mark
        inner, begin, before = found
        met = saved_events(self.tally.met[:before], np.inf)
        return {**inner, "stops": {**begin, "tally": {**begin["tally"], "met": met}}}

    def _known(self) -> tuple[Mark, dict[str, Any], int] | None:
        """What a leg knows of where a run can go on, how it began, and how many events were before it."""
        inner = self._inner.newest()
        return (dict(inner), self._begin, self._met) if inner else self._last

    def _to_stop(self, variant: Variant, standing: HaltedAt) -> Iterator[Samples | None]:
        """From where a leg has halted to where something is met, and what happens there."""
        self.shaped = self.shaped or standing.shaped
        self.state, self.fastest = standing.state, max(self.fastest, speed_of(self.system, standing.state))
        watched, meanings = watched_of(variant, self.push, self.fastest, self.whole.interval)
        tried = dict[float, Reached]()

        def reach(h: float) -> Reached:
            if h not in tried:
                tried[h] = one_step(variant, standing.state, self._by_method(), self.whole, h, self.tally)
            return tried[h]

        def at(h: float) -> Margins:
            if h == 0.0:
                none = np.zeros(variant.system.constraints - variant.system.bodies)  # how hard they push is not known
                return margins(variant.system, watched, Reached(standing.state, none))
            return margins(variant.system, watched, reach(h))

        grain = 4.0 * float(np.finfo(float).eps) * max(abs(standing.state.t), self.whole.interval)
        ends = [watched_gaps(variant.system, watched, each) for each in (standing.state, reach(standing.h).state)]
        if (rests := resting(watched, ends[0], ends[1], standing.h)) is not None:
            return self._meet(self.state, meanings[rests])
        met = locate(at, reach, standing.h, grain, watched)
        if met.h >= 0.25 * THRESHOLDS.fewest_grains * grain:  # a shorter step is none
            yield from self._leg(variant, self._short_leg(standing, met.h), None)
        if met.which is not None:
            self._meet(self.state, meanings[met.which])

    def _short_leg(self, standing: HaltedAt, h: float) -> Leg:
        """One step of size h, with the samples inside."""
        t, whole = standing.state.t, self.whole
        if whole.step is not None:
            return replace(whole, start=t, duration=h, step=h, count=1, every=1).after_actions(t)
        assert whole.times is not None
        return replace(whole, start=t, duration=h, times=whole.times.part(t, t + h), first=h).after_actions(t)

    def _meet(self, state: State, what: Meaning) -> None:
        """What happens at a state; from here on these contacts hold."""
        since, before = state.t - self.met_at, self.met_often
        self.met_often = before + 1 if since <= 16.0 * np.finfo(float).eps * max(state.t, self.whole.interval) else 1
        again = what.stop if self.met_often > 1 and not what.released else None
        met = Met(what.let_go, what.friction if what.rest else None, self.fastest, again)
        meeting: Meeting = meet(self.system, state, self.contacts, met, begins=what == Meaning())
        self.state, self.contacts, self.push = meeting.state, meeting.contacts, meeting.push
        self.integrals[:2] += (meeting.work, meeting.lost)
        if meeting.rubbed is not None:
            self.integrals[2 + meeting.rubbed[0]] += meeting.rubbed[1]
        shared = sharing(self.system, self.state, self.contacts, self.fastest)
        events = (*meeting.events, *changed(state.t, self.shared, shared))
        if not events and since * self.fastest <= THRESHOLDS.met_soon:
            self.met_often = before + 1
        if self.met_often > THRESHOLDS.most_meetings:
            raise never_ends(state.t, what.name(self.system))
        self.tally.met += events
        self.met_at, self.shared = state.t, shared


def march(
    choice: Choice,
    system: System,
    state: State,
    settings: Settings,
    *,
    tally: Tally,
    marks: Marks | None = None,
    automatic: Automatic | None = None,
) -> Iterator[Samples | None]:
    """Samples in the order of time, by one method or by those that `automatic` chooses, of any mechanism."""
    marks = marks or Marks()
    if system.stops is not None or system.frictions is not None:
        legs = StopMarch(choice, system, state, settings, tally, marks)
        legs.automatic = automatic
        yield from legs.samples()
        return

    def by(method: str, own: Marks, counted: Tally, pauses: Pauses | None) -> Iterator[Samples | None]:
        with_method = replace(settings, integrator=method)
        return march_by_one_method(choice, system, state, with_method, tally=counted, marks=own, pauses=pauses)

    if automatic is None:
        yield from by(settings.integrator, marks, tally, None)
    else:
        leg = Leg.whole(system, settings, state.t)
        yield from automatic.march(system, lambda _: FastModes(choice, system), by, leg, tally, marks)
