"""`record_run`: a scene becomes recorded results; `Run` has all that a person or a pipeline reads of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from time import perf_counter
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbproj.base.dataclass import brief, dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.registry import EQUILIBRIUM, is_explicit
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import EPSILON, HARDLY_ANY
from mbproj.equations.rank.uniqueness import unique_components
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.system import System
from mbproj.motion.interruption import interruption
from mbproj.motion.report import Report, summary
from mbproj.motion.simulate import Progress, simulate
from mbproj.results.notes import KEY, Note, as_attribute
from mbproj.results.writer import ResultsWriter
from mbproj.scene.blocks.oversights import notes_on as notes_on_scene
from mbproj.scene.records import JointForce, PlaneStop
from mbproj.scene.scene import Scene
from mbproj.scene.settings import placed_in, settings_to_run

if TYPE_CHECKING:
    from mbproj.linear.equilibrium.find import Equilibrium
    from mbproj.motion.stepwise import Function
    from mbproj.results.analysis.contacts import CreepHistory, FrictionHistory, Pushed
    from mbproj.results.analysis.expectations import Outcome
    from mbproj.results.crash_safety import Checkpoint
    from mbproj.results.record import Results
    from mbproj.results.trust import Trust
    from mbproj.studies.certify import Certified

#: A Python function that acts on a run, and its period in s.
Acting = tuple["Function", "float | None"]
#: The number of earlier samples that are copied at once.
COPIED = 10_000
_NOTHING: Mapping[str, Any] = MappingProxyType({})


class Earlier(NamedTuple):
    """The run that is continued: its last state, and the results to copy before the new ones, or None."""

    checkpoint: Checkpoint
    results: Results | None


@dataclass(frozen=True, eq=False)
class Run:
    """A run that has come to its end, and its record at `output`.

    `attributes` are those of the file. `notes` are on the scene and on the run. `outcomes` are those of the scene's
    expectations, `frictions` and `creep` tell what each dry friction did, `ropes` which ropes pushed, by name; None
    where the scene has none.
    """

    scene: Scene
    output: Path
    system: System
    report: Report
    attributes: Mapping[str, Any]
    notes: tuple[Note, ...]
    trust: Trust | None = None
    outcomes: tuple[Outcome, ...] = ()
    frictions: Mapping[str, FrictionHistory] | None = None
    creep: Mapping[str, CreepHistory] | None = None
    ropes: Mapping[str, Pushed] | None = None

    __repr__ = brief


class Interrupted(KeyboardInterrupt):
    """A run that SIGINT or SIGTERM has interrupted; `output` has the samples until then."""

    def __init__(self, output: Path) -> None:
        super().__init__()
        self.output = output


def record_run(
    scene: Scene,
    output: Path | str,
    *,
    certified: Certified | None = None,
    earlier: Earlier | None = None,
    outside: Acting | None = None,
    progress: Progress | None = None,
    attributes: Mapping[str, Any] = _NOTHING,
    tell: Callable[[Note], None] | None = None,
) -> Run:
    """Run a scene, or continue an `earlier` run of it, into the results file `output`.

    With `certified` the run is judged too. `outside` acts on the run. `progress` is called with the time reached in s,
    `tell` with each note that is known before the run begins. `attributes` are added to those of the file.

    Raises InputError before any work where `output` cannot be written, and where the scene cannot run. Raises
    SimulationError where the run cannot go on, and Interrupted after SIGINT or SIGTERM; the `output` of both has the
    samples so far.
    """
    started = perf_counter()
    with placed_in(scene):
        settings, system = settings_to_run(scene), compile_system(scene)
    marks = {} if outside is None or outside[1] is None else {"controller_period": outside[1]}
    limits = None if certified is None else certified.limits
    writer = ResultsWriter(output, scene, system.names.as_mapping(), certified=limits, marks=marks)
    notes = [Note.on(problem) for problem in notes_on_scene(scene)]
    if system.adjustments:
        from mbproj.equations.assembly.compiled import adjustment_notes

        notes += map(Note.on, adjustment_notes(scene, system))
    with placed_in(scene):
        state = start_of(scene, system)
        writer.mark(unique_components(system, state))
    begun = False
    try:
        # A signal waits until the file is made, or closed: an exception inside HDF5 would leave it half done.
        with interruption() as asked, writer as recorder, placed_in(scene):
            begun = True
            if recorder.set_aside is not None:
                notes.append(Note(f"'{recorder.part}', which a killed run had left, is kept as '{recorder.set_aside}'"))
            if tell is not None:
                for note in notes:
                    tell(note)
            recorder.attributes({KEY: as_attribute(notes)})
            report, trust = _simulate(scene, system, state, settings, recorder, certified, earlier, outside, progress)
            notes += notes_on(report)
            looked_at = _looked_at(scene, recorder, judged=earlier is None or earlier.results is not None)
            notes += [_on_push(name, push) for name, push in looked_at.get("ropes", {}).items()]
            notes += _on_pulls(recorder) if system.names.stops else []
            seconds = perf_counter() - started
            known = summary(str(scene.path or "scene"), str(output), report, total_seconds=seconds)
            known |= attributes
            recorder.attributes({**known, KEY: as_attribute(notes)})
        if asked.requested:
            raise KeyboardInterrupt
    except SimulationError as error:
        error.output = Path(output) if begun else None
        raise
    except KeyboardInterrupt as error:
        if not begun:
            raise
        raise Interrupted(Path(output)) from error
    return Run(scene, Path(output), system, report, known, tuple(notes), trust, **looked_at)


def start_of(scene: Scene, system: System) -> State:
    """Return the initial state of a run, as `linear.equilibrium.started.start_state` does, which is imported for an
    equilibrium alone."""
    if scene.settings.start != EQUILIBRIUM:
        return assemble(system, initial_guess(scene, system))
    from mbproj.linear.equilibrium.start import start_state

    return start_state(scene, system)


def record_equilibrium(scene: Scene, output: Path | str, rest: Equilibrium, attributes: Mapping[str, Any]) -> None:
    """Write an equilibrium as a results file of one sample. Raises InputError where it cannot be written."""
    from mbproj.linear.equilibrium.start import observed

    system = rest.whole
    constants = unique_components(system, rest.state)
    with ResultsWriter(output, scene, system.names.as_mapping(), constants) as writer:
        writer.write(observed(rest))
        writer.attributes(attributes)


def _simulate(
    scene: Scene,
    system: System,
    state: State,
    settings: Settings,
    recorder: ResultsWriter,
    certified: Certified | None,
    earlier: Earlier | None,
    outside: Acting | None,
    progress: Progress | None,
) -> tuple[Report, Trust | None]:
    resumed = {} if earlier is None else earlier.checkpoint.state
    if earlier is not None and earlier.results is not None:
        _copy(earlier.results, recorder, until=float(resumed.get("t", "-inf")))
    if outside is not None:
        return simulate(system, state, settings, recorder, progress, controller=outside[0], period=outside[1]), None
    if certified is not None:
        return certified.simulate(scene, system, state, settings, recorder, progress, recorder.keep)
    return simulate(system, state, settings, recorder, progress, keep=recorder.keep, resumed=resumed), None


def _copy(results: Results, recorder: ResultsWriter, until: float) -> None:
    """Copy the samples up to the time `until` (s)."""
    count = int(np.searchsorted(results.time, until, side="right"))
    for first in range(0, count, COPIED):
        rows = slice(first, min(first + COPIED, count))
        shapes = {dataset: (None, *results.shape(dataset.path)[1:]) for dataset in results.datasets}
        read = results.contents.array
        recorder.write({each.path: read(each.path, shape, each.dtype, rows) for each, shape in shapes.items()})


def _looked_at(scene: Scene, recorder: ResultsWriter, *, judged: bool) -> dict[str, Any]:
    """What a `Run` tells of its samples. They are read only where the scene asks for something that is in them; where
    they are not `judged`, expectations are left out."""
    has_ropes = any("path" in joint.parameters for joint in scene.joints)
    rubs = any(_is_dry(force) for force in scene.forces)
    rubs = rubs or any(joint.parameters["path"].rubbing for joint in scene.joints if "path" in joint.parameters)
    if not (rubs or has_ropes or (judged and scene.expectations)):
        return {}
    fields: dict[str, Any] = {}
    samples = recorder.results()
    if judged and scene.expectations:
        from mbproj.results.analysis.expectations import outcomes

        fields["outcomes"] = tuple(outcomes(scene.expectations, samples))
    if rubs:
        from mbproj.results.analysis.contacts import creep_by_friction, friction_records

        fields |= {"frictions": friction_records(samples), "creep": creep_by_friction(samples, scene)}
    if has_ropes:
        from mbproj.results.analysis.contacts import pushed_by_ropes

        fields["ropes"] = pushed_by_ropes(samples, scene)
    return fields


def _is_dry(force: object) -> bool:
    return bool((isinstance(force, JointForce) and force.coulomb) or (isinstance(force, PlaneStop) and force.friction))


def _on_push(name: str, push: Pushed) -> Note:
    from mbproj.results.analysis.contacts import rope_in_words

    return Note(rope_in_words(name, push), doubts_motion=True)


def _on_pulls(recorder: ResultsWriter) -> Iterator[Note]:
    from mbproj.results.analysis.contacts import pulls_in_words, pulls_of_stops

    for name, pull in pulls_of_stops(recorder.results()).items():
        yield Note(pulls_in_words(name, pull), doubts_motion=True)


# --- The notes on a run that has ended --------------------------------------------------------------------------------
# What puts its motion in doubt, and what would make it better.


#: The violation above which a note tells that joints were open, relative to the coordinates in the rows.
FAR_OPEN = 1e-4
#: The most short movements that are named.
MOST_NAMED = 6


def notes_on(report: Report) -> Iterator[Note]:
    """Yield the notes that a user should not overlook."""
    if report.stiffness:
        # Errors grow in fixed explicit steps alone: else the note is on small steps, or on vibration that is damped.
        fixed = report.settings.step is not None and is_explicit(report.settings.integrator)
        yield Note(report.stiffness, doubts_motion=fixed)
    if report.passed:
        yield Note(
            f"fixed steps passed over edges of laws, from which the motion is pushed back ({report.passed}): no method "
            "keeps its order there; 'coulomb' of a friction on the joint sticks"
        )
    if report.shared:
        yield Note(
            f"contacts share a load arbitrarily ({report.shared}): the motion does not determine these forces, and the "
            "recorded ones are one share of many"
        )
    if report.halved:
        yield Note(
            f"fixed steps were halved {report.halved}: Newton's method did not solve them whole; a smaller step, or a "
            "tolerance in its place, does without"
        )
    if report.decided_by_shares:
        yield _doubt(
            f"the motion depends on how these share their load, which rigid bodies leave open: "
            f"{report.decided_by_shares}; they share as springs of one stiffness do. Make the stops compliant with "
            "'stiffness', or use three points"
        )
    if report.crowded:
        yield Note(
            f"{', '.join(report.crowded)}: more kinks in time than count; steps end at the first "
            f"{THRESHOLDS.most_kinks:,} of each, and meet later ones anywhere"
        )
    if report.unresolved:
        yield Note(
            f"{'; '.join(report.unresolved[:MOST_NAMED])}: fixed steps do not resolve what happens there, though "
            "they are split; take a tolerance in place of a step"
        )
    yield from notes_on_rows(report)
    if report.drifts:
        yield _doubt(
            f"the energy drifted by {100 * report.drift_of_exchanged:.2g} %: the motion may be wrong "
            "although the joints are closed; compare with a smaller step, or with the integrator dop853 at a "
            "tolerance of 1e-10"
        )
    open_by = report.position_violation
    if open_by.value > FAR_OPEN * report.position_floor / EPSILON:
        yield _doubt(
            f"{open_by.owner} was open by {open_by.value:.2g} (m, rad) at t = {open_by.time:.4g} s: this is not "
            "the mechanism's motion; use a projection method, gpopm for example, or a smaller step"
        )
    asked = report.settings.projection.tolerance
    if asked is not None and report.settings.projection.test == "violation" and asked < report.position_floor:
        yield Note(
            f"the projection's tolerance of {asked:.0e} is below round-off, {report.position_floor:.0e}: the "
            "iterations stop where the violation falls no further"
        )
    finest = report.settings.tolerance
    if finest is not None and finest < report.round_off:
        yield Note(
            f"the tolerance of {finest:.0e} is below what round-off leaves of positions, {report.round_off:.0e} of the "
            "mechanism's length: smaller steps make nothing more accurate"
        )
    if report.swamped:
        from mbproj.equations.rank.mobility import SHOWN

        yield _doubt(
            f"round-off of the other bodies' forces decides motions with less than {HARDLY_ANY:.0e} of the "
            f"largest inertia: {'; '.join(report.swamped[:SHOWN])}; give these bodies more inertia, or joints that "
            "hold them"
        )
    if report.counters["projection_failures"]:
        yield Note(
            f"{report.counters['projection_failures']} projections missed their tolerance; the largest violation "
            f"is {report.position_violation.value:.1e}"
        )


def notes_on_rows(report: Report) -> Iterator[Note]:
    """Yield notes where the rows of energy and momenta may hide a wrong motion, or correct nothing."""
    projection, rows = report.settings.projection, report.rows
    if rows.refused:
        yield _doubt(
            f"the rows of energy and momenta were refused at {rows.refused} of {rows.steps + rows.rest + rows.refused} "
            f"steps: there they asked for more than {100 * THRESHOLDS.row_refused:g} % of what the step changed; the "
            "motion may be wrong; take a smaller step or tolerance"
        )
    if report.hidden > 1.0:
        per_step = f"the energy row gave or took {rows.moved / rows.steps:.2g} J a step"
        in_sum = f"the energy row gave or took up to {rows.furthest:.2g} J in sum"
        yield _doubt(
            f"{per_step if report.degrees_of_freedom == 1 else in_sum}, where the run exchanged "
            f"{report.exchanged:.2g} J: the motion may be wrong although the balance is kept; take a smaller step or "
            "tolerance"
        )
    if projection.momentum and not rows.momenta and not projection.energy:
        yield Note("joints to the ground, gravity or forces act on every momentum: its rows keep none")


def _doubt(text: str) -> Note:
    return Note(text, doubts_motion=True)
