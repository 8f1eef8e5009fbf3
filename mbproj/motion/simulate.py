"""`simulate` runs a system from a state with given settings and hands its samples to a recorder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial
from time import perf_counter, thread_time
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

import numpy as np

from mbproj.base.arrays import Array, may_overflow
from mbproj.base.errors import InputError, Problem, SimulationError
from mbproj.base.registry import AUTOMATIC
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.constraints import has_light_bodies, position_grain, velocity_grain
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.recorded import Block, Observer
from mbproj.equations.samples import Samples, block_samples
from mbproj.kernel import fingerprint
from mbproj.model.system import System
from mbproj.motion.formulations.choice import Choice, choose, refuse_without_steps
from mbproj.motion.interruption import in_blocks, interruption
from mbproj.motion.kernel_run import march
from mbproj.motion.marks import START, Keeping, Mark, Marks
from mbproj.motion.report import (
    EnergyWatch,
    Report,
    Tally,
    words_on_halvings,
    words_on_passes,
    words_on_shares,
    words_on_sharing,
    worst,
    worst_joint,
)
from mbproj.motion.time_events import DECIDES, SHARED, Event, crowded, events_of, splits_of, unresolved
from mbproj.scene.sampling import output_interval

if TYPE_CHECKING:
    from mbproj.motion.automatic import AutomaticMarch
    from mbproj.motion.kernel_run import FollowedSteps
    from mbproj.motion.stepwise import Function
    from mbproj.motion.stiffness import StiffnessWatch


class Recorder(Protocol):
    """Interface of a recorder of the blocks of a run, as `mbproj.results.writer.ResultsWriter`."""

    def write(self, block: Block) -> None:
        """Record T consecutive samples by dataset path."""


@runtime_checkable
class EventRecorder(Recorder, Protocol):
    """A recorder that also records the events of a run."""

    def events(self, events: Sequence[Event]) -> None:
        """Record all events, in the order of time, when the run ends or stops."""


#: Called with the simulated time reached, in s: after every block of samples, and now and then without samples.
Progress = Callable[[float], None]
#: Called now and then, and at the end, with the formulation, the program's build, and the newest mark.
Keep = Callable[[str, str, Mark], None]


#: The times at which the speeds of motions are looked at before a run.
LOOKS = 101


class _Clocks(NamedTuple):
    """Elapsed seconds, and the part of them in which this thread had the processor."""

    elapsed: float = 0.0
    busy: float = 0.0

    @classmethod
    def now(cls) -> _Clocks:
        """Return the readings of both clocks."""
        return cls(perf_counter(), thread_time())

    def __sub__(self, other: _Clocks) -> _Clocks:
        return _Clocks(self.elapsed - other.elapsed, self.busy - other.busy)

    def plus(self, other: _Clocks) -> _Clocks:
        """Return the sum of two spans."""
        return _Clocks(self.elapsed + other.elapsed, self.busy + other.busy)


def simulate(
    system: System,
    state: State,
    settings: Settings,
    recorder: Recorder | None = None,
    progress: Progress | None = None,
    *,
    keep: Keep | None = None,
    resumed: Mark = START,
    accounts: bool = True,
    controller: Function | None = None,
    period: float | None = None,
    steps: FollowedSteps | None = None,
    choice: Choice | None = None,
) -> Report:
    """Integrate from `state` over `settings.duration`, and return a report. From a mark that `keep` received before, it
    continues with the bits of one uninterrupted run. System, state and settings must be the same, except for the
    duration. Without `accounts` the report's energies are NaN. Once each `period` (s), `controller(t, signals)` sets
    states. `choice`: the result of `choose` for this run, if it is known already.

    Raises InputError where the settings do not fit the system or its equations have no unique solution. After all
    samples are recorded it raises SimulationError where it cannot go on, and KeyboardInterrupt after SIGINT or SIGTERM.
    """
    _refuse_at_the_start(system, state, settings)
    choice, asked_for = choice or choose(system, state, settings), settings
    refuse_without_steps(choice, settings)
    if choice.kinematic:
        from mbproj.motion.formulations.choice import settings_along

        settings = settings_along(system, settings)
    events = events_of(system, state.t, settings)
    weight = float(np.sum(system.mass) * np.linalg.norm(system.gravity))
    reach = system.length + float(np.abs(pose_of(state.q).position).max(initial=0.0))
    moves = choice.degrees_of_freedom > 0 or system.driven > 0
    tally, floors, marks = Tally(), np.zeros(3), Marks(resumed, wanted=keep is not None)
    energy = EnergyWatch(weight * reach, moves=moves, wanted=accounts)
    keeping = None if keep is None else Keeping(marks, partial(keep, choice.name, fingerprint()))
    automatic = _automatic() if settings.integrator == AUTOMATIC else None
    stiffness = _stiffness(choice, system, settings)
    observer, reached, last = Observer(system, state), (state.t, state.q), state
    started, recording = _Clocks.now(), _Clocks()
    with (
        _events(recorder, events, tally, automatic),
        interruption() as asked,
        _naming(choice.name, system, state.q, lambda: reached),
        nullcontext() if stiffness is None else stiffness.naming(),
        nullcontext() if keeping is None else keeping.to_the_end(),
    ):
        if controller is not None:
            from mbproj.motion import stepwise

            run = stepwise.march_with(controller, period, choice, system, state, settings, tally, marks)
        else:
            run = _march(choice, system, state, settings, tally=tally, marks=marks, automatic=automatic, steps=steps)

        def pause() -> None:
            if progress is not None:
                progress(tally.reached)

        for samples in in_blocks(run, asked, pause, block_samples(system.bodies)):
            last = samples.state(-1)
            reached = last.t, last.q
            handed_over = _Clocks.now()
            block = observer.at(samples)
            energy.watch(block)
            floors = np.maximum(floors, _floors(system, samples))
            if stiffness is not None:
                stiffness.take(samples, None if automatic is None else automatic.plan.implicit_at(samples.t))
            if keeping is not None:
                keeping.now_and_then()
            if recorder is not None:
                recorder.write(block)
            if progress is not None:
                progress(max(reached[0], tally.reached))
            recording = recording.plus(_Clocks.now() - handed_over)
    integration = _Clocks.now() - started - recording
    return Report(
        formulation=choice.name,
        why=choice.why,
        settings=asked_for,
        kinematic=choice.kinematic,
        degrees_of_freedom=choice.degrees_of_freedom,
        redundant_rows=system.constraints - 7 * system.bodies + choice.degrees_of_freedom,
        swamped=_swamped(system, state),
        counters=tally.counters(),
        position_violation=worst(system, tally.position_peak),
        velocity_violation=worst(system, tally.velocity_peak),
        position_floor=float(floors[0]),
        velocity_floor=float(floors[1]),
        fastest=float(floors[2]),
        worst_joint=worst_joint(system, tally.joint_peak),
        energy_drift=energy.drift,
        energy_drift_relative=energy.relative,
        energy=energy.account,
        rows=tally.rows,
        exchanged=energy.exchanged,
        integration_seconds=integration.elapsed,
        integration_cpu_seconds=integration.busy,
        recording_seconds=recording.elapsed,
        phases=tally.phases,
        stiffness="" if stiffness is None else stiffness.verdict(state.t + (settings.duration or 0.0)),
        events=len({event.time for event in (*events, *tally.met) if event.kind not in (SHARED, DECIDES)}),
        shared=words_on_sharing(tally.met),
        crowded=crowded(events),
        unresolved=(*unresolved(splits_of(system, state.t, settings)), *_unresolved_slips(system, settings, tally)),
        passed=words_on_passes(tally.passed),
        halved=words_on_halvings(tally.halved),
        decided_by_shares=words_on_shares(tally.met),
        round_off=float(floors[0]) / max(system.length, 1.0),
        methods=() if automatic is None else automatic.methods_taken(),
        state=last,
    )


def _refuse_at_the_start(system: System, state: State, settings: Settings) -> None:
    """Raise InputError where a run cannot start from the state. Modules that few scenes need are imported here."""
    if system.driven:
        _refuse_fast_motions(system, state.t, settings)
    if system.stops is not None:
        from mbproj.motion.contacts import refuse_penetration

        refuse_penetration(system, state, settings.start)
    if system.bearings is not None:
        from mbproj.equations.friction import refuse_shared_loads

        refuse_shared_loads(system, state)


def _refuse_fast_motions(system: System, start: float, settings: Settings) -> None:
    """Raise InputError where a motion is so fast that no computer follows it: its steps would have no end."""
    try:
        rates = np.abs(drive_at(system, np.linspace(start, start + (settings.duration or 0.0), LOOKS)).rate)
    except SimulationError:  # the run says at what time it has no value
        return
    step = settings.step or output_interval(settings)
    scales = np.where([unit == "rad" for unit in system.names.motion_units], 1.0, system.length)
    largest = rates.max(axis=0)
    for index in np.flatnonzero(largest * step > THRESHOLDS.most_driven * scales):
        unit, moved = system.names.motion_units[index], largest[index] * step
        speed = f"{largest[index]:.2g} {unit}/s, {moved:.2g} {unit} in a step"
        what = f"motion '{system.names.motions[index]}' reaches {speed}"
        raise InputError(Problem(what, hint="correct its function, or the unit of its time"))


def _unresolved_slips(system: System, settings: Settings, tally: Tally) -> tuple[str, ...]:
    """Return, in words, the frictions in a plane whose slip turned as it began, in steps of a fixed size: near rest the
    direction of v/|v| follows the forces at once, which makes any explicit method one of order 1."""
    if settings.step is None:
        return ()
    return tuple(f"friction '{system.names.frictions[k]}', whose slip turns as it begins" for k in tally.turned)


def _swamped(system: System, state: State) -> tuple[str, ...]:
    """Return, in words, the motions of bodies with hardly any mass or inertia beside the others."""
    if not system.cached("light bodies", (), partial(has_light_bodies, system)):
        return ()
    from mbproj.equations.rank.mobility import swamped_motions

    return tuple(str(motion) for motion in swamped_motions(system, pose_of(state.q)))


def _stiffness(choice: Choice, system: System, settings: Settings) -> StiffnessWatch | None:
    """Return the watch for modes that are too fast for the steps; None for a system without forces along coordinates,
    states of elements, and Baumgarte's terms."""
    can_be_fast = system.states.size > 0 or (system.forces.size > 0 and not choice.kinematic)
    if not can_be_fast and settings.projection.gains is None:
        return None
    from mbproj.motion.stiffness import StiffnessWatch

    return StiffnessWatch(choice, system, settings, partial(_march, choice, system, tally=Tally()))


def _automatic() -> AutomaticMarch:
    from mbproj.motion.automatic import AutomaticMarch

    return AutomaticMarch()


def _march(
    choice: Choice,
    system: System,
    state: State,
    settings: Settings,
    *,
    tally: Tally,
    marks: Marks | None = None,
    automatic: AutomaticMarch | None = None,
    steps: FollowedSteps | None = None,
) -> Iterator[Samples | None]:
    """Return the samples of a run of any mechanism."""
    if automatic is None:
        return march(choice, system, state, settings, tally=tally, marks=marks, steps=steps)
    return automatic.march(choice, system, state, settings, tally, marks or Marks())


@contextmanager
def _events(
    recorder: Recorder | None, in_time: Sequence[Event], tally: Tally, automatic: AutomaticMarch | None
) -> Iterator[None]:
    """Give the events to the recorder, if it records them, however the run in this block ends."""
    try:
        yield
    finally:
        if isinstance(recorder, EventRecorder):
            switched = () if automatic is None else [switch.event for switch in automatic.plan.switches]
            recorder.events(sorted([*in_time, *tally.met, *switched]))


@contextmanager
def _naming(
    formulation: str, system: System, start: Array, reached: Callable[[], tuple[float, Array]]
) -> Iterator[None]:
    """Add the formulation to an error of a run in this block, and the motion that has caused it, where one is found."""
    try:
        yield
    except SimulationError as error:
        from mbproj.motion.failures import explained

        explanation = explained(error, system, start, reached)
        explanation.formulation = formulation
        if explanation is error:
            raise
        raise explanation from error


def _floors(system: System, samples: Samples) -> Array:
    """Return the round-off of C and of C' at the last of some samples, and the fastest motion of them, (3,)."""
    with may_overflow():
        motion = samples.motion
        pose = pose_of(motion.q[-1])
        grains = position_grain(system, pose), velocity_grain(system, pose, twist_of(pose, motion.v[-1]))
        each = motion.v.reshape(len(samples.t), -1, 7)
        fastest = np.abs(each[..., :3]).max() / system.length + 2.0 * np.abs(each[..., 3:]).max()
    return np.array([*(grain.max(initial=0.0) for grain in grains), fastest])
