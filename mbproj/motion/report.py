"""The report of a run at its end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import brief, dataclass
from mbproj.base.errors import shortened
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.recorded import Block
from mbproj.model.system import System
from mbproj.motion.time_events import DECIDES, SHARED, Event
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.runs import RECORDED, ROWS

if TYPE_CHECKING:
    from mbproj.motion.projection import ProjectedState


# --- Counts of a run --------------------------------------------------------------------------------------------------
# Its work, and the largest violations at any step, recorded or not.


@dataclass(frozen=True)
class Peak:
    """The largest value so far, the row of C that had it, and the time (s)."""

    value: float = 0.0
    row: int = 0
    time: float = 0.0

    def or_larger(self, rows: Array, t: float) -> Peak:
        """Return this peak, or the largest of `rows` where that is larger."""
        row = int(np.argmax(rows)) if len(rows) else 0
        return Peak(float(rows[row]), row, t) if len(rows) and rows[row] > self.value else self


@dataclass(frozen=True)
class Passed:
    """A switch of a law that fixed steps pass over: its owner, a description, the first time (s), and the number of
    passes."""

    owner: str
    what: str
    first: float
    times: int


@dataclass(frozen=True)
class Halved:
    """Fixed steps that were halved for one cause: the force or body that Newton's method did not solve ("force
    'spring'", "body 'A'"), the first time (s), and the number of halvings."""

    where: str
    first: float
    times: int


@dataclass(frozen=True)
class RowsKept:
    """Counts of the rows for the energy balance and momenta; all 0 where none is asked for.

    `steps`, `rest`, `refused`: the numbers of steps whose correction was made, left out near rest, or refused. `added`:
    the energy in J that the rows added, signed; `furthest`: its largest absolute value so far; `moved`: the sum of
    absolute values. `largest`: their largest change of the velocities, divided by the velocities. `momenta`: the number
    of momenta conserved."""

    steps: int = 0
    rest: int = 0
    refused: int = 0
    added: float = 0.0
    moved: float = 0.0
    furthest: float = 0.0
    largest: float = 0.0
    momenta: int = 0

    @classmethod
    def of(cls, saved: Mapping[str, Any]) -> RowsKept:
        """Return the counts in a mark."""
        if not saved:
            return cls()
        steps, rest, refused = map(int, saved["often"])
        added, moved, furthest, largest = map(float, saved["sizes"])
        return cls(steps, rest, refused, added, moved, furthest, largest, len(saved["momenta"]))


def with_another(halved: Sequence[Halved], one: Halved) -> list[Halved]:
    """Return the list of halved steps with one more entry, merged with that of the same cause."""
    by_place = {each.where: each for each in halved}
    same = by_place.get(one.where, replace(one, times=0))
    by_place[one.where] = Halved(one.where, min(one.first, same.first), one.times + same.times)
    return list(by_place.values())


@dataclass
class Tally:
    """Counters since the start, and the peaks of |C|, of |C'|, and of |C| over the joints' rows alone.

    `phases`: the seconds of each phase in a sample of the steps, where measured. `met`: the state events at which steps
    ended. `passed`, `halved`: the switches that fixed steps passed over, and the causes for which they were halved.
    `turned`: the numbers of frictions whose slip turned as it began. `rows`: the counts of the rows for energy and
    momenta. `reached`: the time in s of a run that has returned without samples."""

    steps: int = 0
    rejected_steps: int = 0
    evaluations: int = 0
    projections: int = 0
    projection_iterations: int = 0
    velocity_iterations: int = 0
    projection_failures: int = 0
    projection_fallbacks: int = 0
    factorisations: int = 0
    position_peak: Peak = field(default_factory=Peak)
    velocity_peak: Peak = field(default_factory=Peak)
    joint_peak: Peak = field(default_factory=Peak)
    phases: dict[str, float] = field(default_factory=dict)
    met: list[Event] = field(default_factory=list)
    passed: list[Passed] = field(default_factory=list)
    halved: list[Halved] = field(default_factory=list)
    turned: tuple[int, ...] = ()
    rows: RowsKept = field(default_factory=RowsKept)
    reached: float = 0.0

    def counters(self) -> dict[str, int]:
        """Return the counters by name."""
        return {name: value for name, value in vars(self).items() if isinstance(value, int)}

    def set_counters(self, values: Iterable[int]) -> None:
        """Set the counters, in the order of the fields."""
        for name, value in zip(self.counters(), values, strict=True):
            setattr(self, name, value)

    def reject_accepted(self) -> None:
        """Count the last accepted step as rejected."""
        self.steps -= 1
        self.rejected_steps += 1

    def count_evaluations(self, number: int) -> None:
        """Count evaluations of the accelerations, each with one factorisation."""
        self.evaluations += number
        self.factorisations += number

    def count_projection(self, projected: ProjectedState) -> None:
        """Count the work of one projection."""
        self.projections += projected.projections
        self.projection_iterations += projected.position_iterations
        self.velocity_iterations += projected.velocity_iterations
        self.projection_failures += projected.failures
        self.projection_fallbacks += projected.fallbacks
        self.factorisations += projected.position_iterations + projected.velocity_iterations

    def watch(self, position: Array, velocity: Array, joints: slice, t: float) -> None:
        """Take in |C| and |C'| (m,) of a step; `joints` is the slice of the joints' rows."""
        self.position_peak = self.position_peak.or_larger(position, t)
        self.joint_peak = self.joint_peak.or_larger(position[joints], t)
        self.velocity_peak = self.velocity_peak.or_larger(velocity, t)


# --- The report of a run at its end -----------------------------------------------------------------------------------


#: The most edges of laws that a report names.
MOST_PASSED = 3
#: The most contacts sharing a load that a report names.
MOST_SHARING = 6


@dataclass(frozen=True)
class Worst:
    """The largest violation of a run (m or rad, or per s), the owner of its row ("joint 'A'"), and its time (s)."""

    value: float
    owner: str
    time: float


@dataclass(frozen=True)
class EnergyAccount:
    """The balance of energy from the start to the end, in J.

    `work` is that of forces and motions, `dissipation` that of dampers, friction and impacts. `numerical` is E - E(0) -
    W + D, the energy put in by the integrator and the projection. It is negative where they take energy, which is how
    implicit methods damp vibration that they do not resolve."""

    work: float = 0.0
    dissipation: float = 0.0
    numerical: float = 0.0


@dataclass(frozen=True)
class Report:
    """The work of a run, and its accuracy.

    `formulation` is the one that was used, for the reason `why`. `redundant_rows` counts the constraints in space that
    follow from the others. `swamped` names motions of light bodies that round-off of heavy bodies' forces may dominate.
    The largest violations are over all steps, recorded or not. `position_floor` and `velocity_floor` are the violations
    by round-off alone (m or rad, per s). `fastest` is the speed of the fastest part, in lengths of the mechanism and
    rad per s. Each of these is the largest of the samples. `worst_joint` is the joint that was open most, None without
    joints.

    `energy_drift` is in J, and relative to the largest kinetic energy + |ΔV|, which is `exchanged`, in J. `energy` is
    the balance. `rows` are the counts of the rows for energy and momenta. `integration_seconds` were spent on the steps
    (`integration_cpu_seconds` of them by the thread's own clock), `recording_seconds` on observing and writing samples.
    `phases` are seconds by phase in a sample of the steps; empty where not measured. `stiffness` says which force was
    too stiff for the step, and what to do. `events` is the number of times at which steps ended at an event. `crowded`
    names functions with so many kinks that some are ignored, `unresolved` short moves that fixed steps do not resolve.
    `passed` lists edges of laws that fixed steps passed over, and `halved` the causes for which steps were halved.
    `decided_by_shares` lists stops on whose arbitrary shares of a load the motion depends. `methods` lists the methods
    of `integrator: auto`. `round_off` is that of positions, in lengths of the mechanism or rad. `shared` lists stops
    and frictions that shared a force arbitrarily, and since when. `kinematic`: whether nothing was integrated. These
    texts are "" for none.

    `state` is where it ended: another run can start from it, unless a compliant stop is pressed, or a friction sticks.
    `continue_run` continues from any.
    """

    formulation: str
    why: str
    settings: Settings
    degrees_of_freedom: int
    redundant_rows: int
    swamped: tuple[str, ...]
    counters: dict[str, int]
    position_violation: Worst
    velocity_violation: Worst
    position_floor: float
    velocity_floor: float
    fastest: float
    worst_joint: str | None
    energy_drift: float
    energy_drift_relative: float
    integration_seconds: float
    integration_cpu_seconds: float
    recording_seconds: float
    phases: dict[str, float]
    stiffness: str
    events: int = 0
    crowded: tuple[str, ...] = ()
    unresolved: tuple[str, ...] = ()
    passed: str = ""
    halved: str = ""
    decided_by_shares: str = ""
    methods: tuple[str, ...] = ()
    round_off: float = 0.0
    shared: str = ""
    energy: EnergyAccount = EnergyAccount()
    kinematic: bool = False
    rows: RowsKept = RowsKept()
    exchanged: float = 0.0
    state: State | None = None

    __repr__ = brief

    @property
    def rests(self) -> bool:
        """Whether nothing moves: no speed changes a position by more than round-off in a second, nor in the run."""
        return self.fastest * max(self.settings.duration or 0.0, 1.0) <= THRESHOLDS.rounding

    @property
    def drift_of_exchanged(self) -> float:
        """The energy drift over the energy exchanged in the run: the largest kinetic energy, |ΔV| and the
        dissipation."""
        if not self.energy_drift_relative > 0.0:
            return self.energy_drift_relative
        moved = self.energy_drift / self.energy_drift_relative
        return self.energy_drift / (moved + abs(self.energy.dissipation))

    @property
    def drifts(self) -> bool:
        """Whether the energy suggests that the motion may be wrong. It does not where nothing moves, nor where motions
        drive every degree of freedom: there the joints alone determine the pose."""
        is_free = self.degrees_of_freedom > 0 and not self.rests
        return is_free and self.drift_of_exchanged > THRESHOLDS.suspicious_drift

    @property
    def hidden(self) -> float:
        """The energy that the energy row has added, divided by the largest amount that needs no note.

        With one degree of freedom the energy alone determines the speed, and the sum is harmless: the mean over the
        steps counts. With more degrees of freedom the sum is the drift that the run would have without the row."""
        if not self.rows.steps or not self.exchanged > 0.0:
            return 0.0
        exchanged = self.exchanged + abs(self.energy.dissipation)
        if self.degrees_of_freedom == 1:
            return self.rows.moved / self.rows.steps / exchanged / THRESHOLDS.row_suspicious
        return self.rows.furthest / exchanged / THRESHOLDS.suspicious_drift

    @property
    def doubt(self) -> float:
        """The energy error divided by the largest amount that needs no note on a wrong motion."""
        drift = self.drift_of_exchanged / THRESHOLDS.suspicious_drift if self.drifts else 0.0
        return max(drift, self.hidden, 1.0 + self.rows.refused if self.rows.refused else 0.0)


def worst(system: System, peak: Peak) -> Worst:
    """Return a peak with the name of its row's owner."""
    return Worst(peak.value, system.row_owner(peak.row), peak.time)


def worst_joint(system: System, peak: Peak) -> str | None:
    """Return the joint that had a peak over the joints' rows; None without joints."""
    return system.names.joints[system.joints.owner[peak.row]] if system.joints.size else None


def words_on_passes(passed: Sequence[Passed]) -> str:
    """Return words on the edges that fixed steps have passed over; "" for none."""
    said = [
        f"{each.owner}: {each.what}, {_often(each.times)}, first before t = {each.first:.6g} s"
        for each in passed[:MOST_PASSED]
    ]
    more = f"; and {len(passed) - MOST_PASSED} more" if len(passed) > MOST_PASSED else ""
    return "; ".join(said) + more


def words_on_sharing(events: Sequence[Event]) -> str:
    """Return words on contacts that share forces arbitrarily, and since when; "" for none."""
    shared = [event for event in events if event.kind == SHARED]
    names = list(dict.fromkeys(event.name for event in shared))
    return f"{shortened(names, MOST_SHARING)}, first at t = {shared[0].time:.6g} s" if names else ""


def words_on_shares(met: Sequence[Event]) -> str:
    """Return words on stops on whose shares the motion depends, and since when; "" for none."""
    which = [event for event in met if event.kind == DECIDES]
    names = ", ".join(dict.fromkeys(event.name for event in which))
    return f"{names}, first at t = {which[0].time:.6g} s" if which else ""


def sharing_stops(met: Sequence[Event]) -> tuple[str, ...]:
    """Return the names of the stops on whose shares of a load the motion depends."""
    named = (event.name.partition("'")[2].rpartition("'")[0] for event in met if event.kind == DECIDES)
    return tuple(dict.fromkeys(named))


def words_on_halvings(halved: Sequence[Halved]) -> str:
    """Return words on the causes for which fixed steps were halved, the most frequent first; "" for none."""
    if not halved:
        return ""
    most = sorted(halved, key=lambda each: -each.times)
    said = [f"{each.where} {_often(each.times)}, first at t = {each.first:.6g} s" for each in most[:MOST_PASSED]]
    more = f"; {len(most) - MOST_PASSED} more" if len(most) > MOST_PASSED else ""
    return f"{_often(sum(each.times for each in halved))}, for want of {'; '.join(said)}{more}"


def _often(times: int) -> str:
    return {1: "once", 2: "twice"}.get(times, f"{times:,} times")


def summary(scene: str, output: str, report: Report, total_seconds: float) -> dict[str, Any]:
    """Return the attributes of the results file, which --json also prints, for the run of the scene at `scene` to
    `output`."""
    projection = report.settings.projection
    known = {
        **report.counters,
        "scene": scene,
        "output": output,
        "total_seconds": total_seconds,
        "methods": "; ".join(report.methods),
        "status": "complete",
    }
    said = (*RECORDED, *ROWS) if projection.energy or projection.momentum else RECORDED
    return report_of(said, report, **known)


class EnergyWatch:
    """The energies of one run so far: the largest |balance|, kinetic energy, and range of the potential energy."""

    def __init__(self, scale: float = 0.0, *, moves: bool = True, wanted: bool = True) -> None:
        """`scale`: the mechanism's energy in J, its weight times its size. `moves`: whether it can move at all. Without
        `wanted` energies all values are NaN."""
        self._scale, self._moves, self._wanted = scale, moves, wanted
        self.drift = self.kinetic = 0.0 if wanted else float("nan")
        self.lowest, self.highest = float("inf"), float("-inf")
        self.account = EnergyAccount() if wanted else EnergyAccount(*[float("nan")] * 3)

    def watch(self, block: Block) -> None:
        """Take in a block of samples, and the balance of energy at its end."""
        if not self._wanted:
            return
        potential, balance = block["diagnostics/potential_energy"], block["diagnostics/energy_balance"]
        work, dissipation = (float(block[f"diagnostics/{name}"][-1]) for name in ("work", "dissipation"))
        self.account = EnergyAccount(work, dissipation, float(balance[-1]))
        kinetic = float(block["diagnostics/kinetic_energy"].max())
        self.take(float(np.abs(balance).max()), kinetic, float(potential.min()), float(potential.max()))

    def take(self, balance: float, kinetic: float, lowest: float, highest: float) -> None:
        """Take in the largest |balance| and kinetic energy, and the range of the potential energy, of a block."""
        self.drift, self.kinetic = max(self.drift, balance), max(self.kinetic, kinetic)
        self.lowest, self.highest = min(self.lowest, lowest), max(self.highest, highest)

    @property
    def exchanged(self) -> float:
        """The largest kinetic energy + |ΔV| of the run."""
        return self.kinetic + max(self.highest - self.lowest, 0.0)

    @property
    def relative(self) -> float:
        """The drift over the largest kinetic energy + |ΔV| of the run; 0 where nothing but round-off moved."""
        size = self.exchanged
        nothing = THRESHOLDS.rounding * max(self._scale, abs(self.lowest), abs(self.highest))
        rests = max(size, self.drift) <= nothing or size == 0.0
        return 0.0 if rests or not self._moves else self.drift / size
