"""What a run says of itself when it ends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.round_off import EPSILON
from mbproj.dynamics.observe.recorded import Block
from mbproj.integrate.events.time_events import DECIDES, SHARED, Event
from mbproj.integrate.outcome.tally import Halved, Passed, Peak, RowsKept
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS

#: So many edges of laws are named at most.
MOST_PASSED = 3
#: So many that share a load are named at most.
MOST_SHARING = 6


@dataclass(frozen=True)
class Worst:
    """The largest violation of a run (m or rad, or per s), whose row it was ("joint 'A'"), and when (s)."""

    value: float
    owner: str
    time: float


@dataclass(frozen=True)
class EnergyAccount:
    """What became of the energy from the start to the end, in J: the `work` that forces and motions put in, the
    `dissipation` of dampers, friction and impacts, and what is `numerical`, E - E(0) - W + D: what the integrator and
    the projection put in. Negative is what they took, which is how implicit methods damp vibration that they do not
    resolve."""

    work: float = 0.0
    dissipation: float = 0.0
    numerical: float = 0.0


@dataclass(frozen=True)
class Report:
    """What a run did, and how well.

    `formulation` is the one that was used, and `why`; `redundant_rows` counts the constraints in space that follow from
    the others. `swamped` names motions of light bodies that round-off of heavy ones' forces may rule. The largest
    violations are those over all steps, recorded or not; `position_floor` and `velocity_floor` are what round-off alone
    leaves (m or rad, per s). `fastest` is the speed of the fastest part, in lengths of the mechanism and rad per s.
    Each is the largest of the samples. `worst_joint` names the joint that was open most, None without joints.
    `energy_drift` in J, and relative to the largest kinetic energy + |ΔV|; `energy`: where it came from and went.
    `rows`: what those of the energy and of momenta did.
    `exchanged`: the largest kinetic energy + |ΔV|, J.
    `integration_seconds` went into the steps (`integration_cpu_seconds` of them with the processor, by the thread's own
    clock), `recording_seconds` into observing and writing the samples. `phases`: seconds by phase in a sample of the
    steps; empty where they were not measured. `stiffness`: which force was too stiff for the step, and what to do; ""
    where none was. `events`: at how many times steps ended because of what happens there; `crowded` names functions
    with so many kinks that not all count, `unresolved` short moves that fixed steps are not split for finely enough.
    `passed`: which edges of laws fixed steps passed over, and `halved` for want of what they were halved; "" where
    nothing is. `decided_by_shares`: the stops on whose shares of a load, which rigid bodies leave open, the motion
    depends. `methods`: of `integrator: auto` which method made the steps, line by line. `round_off`: what it leaves of
    positions, in lengths of the mechanism or rad. `shared`: whose forces stops that touch and frictions at rest shared
    arbitrarily at some time, and when first; "" where nothing is. `kinematic`: nothing of the motion was integrated.
    `state` is where it ended: another run can start from it, unless a compliant stop is pressed, or a friction sticks.
    `continue_run` goes on from any.
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

    @property
    def rests(self) -> bool:
        """Whether nothing moves: no speed changes a position by more than round-off in a second, nor in the run."""
        return self.fastest * max(self.settings.duration or 0.0, 1.0) <= THRESHOLDS.rests * EPSILON

    @property
    def drift_of_exchanged(self) -> float:
        """The energy drift over what the run exchanged: the largest kinetic energy, |ΔV| and what was dissipated."""
        if not self.energy_drift_relative > 0.0:
            return self.energy_drift_relative
        moved = self.energy_drift / self.energy_drift_relative
        return self.energy_drift / (moved + abs(self.energy.dissipation))

    @property
    def drifts(self) -> bool:
        """Whether the energy says that the motion may be wrong. It does not where nothing moves, and where nothing is
        free to move but what motions drive: there the joints alone say where it is, whatever the work."""
        is_free = self.degrees_of_freedom > 0 and not self.rests
        return is_free and self.drift_of_exchanged > THRESHOLDS.suspicious_drift

    @property
    def hidden(self) -> float:
        """What the row of the energy has given, over what goes without a note. With one degree of freedom the energy
        alone says how fast it moves, and the sum does no harm: then it is that of a step in the mean. With more it is
        the drift that the run would have had."""
        if not self.rows.steps or not self.exchanged > 0.0:
            return 0.0
        exchanged = self.exchanged + abs(self.energy.dissipation)
        if self.degrees_of_freedom == 1:
            return self.rows.moved / self.rows.steps / exchanged / THRESHOLDS.row_suspicious
        return self.rows.furthest / exchanged / THRESHOLDS.suspicious_drift

    @property
    def doubt(self) -> float:
        """How far the energy is beyond what goes without a note that the motion may be wrong: at most 1 without one."""
        drift = self.drift_of_exchanged / THRESHOLDS.suspicious_drift if self.drifts else 0.0
        return max(drift, self.hidden, 1.0 + self.rows.refused if self.rows.refused else 0.0)


def worst(system: System, peak: Peak) -> Worst:
    """A peak with the name of its row."""
    return Worst(peak.value, system.row_owner(peak.row), peak.time)


def worst_joint(system: System, peak: Peak) -> str | None:
    """The joint that had a peak over the joints' rows."""
    return system.names.joints[system.joints.owner[peak.row]] if system.joints.size else None


def words_on_passes(passed: Sequence[Passed]) -> str:
    """What fixed steps have passed over; "" where that is nothing."""
    said = [
        f"{each.owner}: {each.what}, {_often(each.times)}, first before t = {each.first:.6g} s"
        for each in passed[:MOST_PASSED]
    ]
    more = f"; and {len(passed) - MOST_PASSED} more" if len(passed) > MOST_PASSED else ""
    return "; ".join(said) + more


def words_on_sharing(events: Sequence[Event]) -> str:
    """Whose forces are shared arbitrarily, and when first; "" where nothing is."""
    shared = [event for event in events if event.kind == SHARED]
    names = list(dict.fromkeys(event.name for event in shared))
    more = f" and {len(names) - MOST_SHARING} more" if len(names) > MOST_SHARING else ""
    return f"{', '.join(names[:MOST_SHARING])}{more}, first at t = {shared[0].time:.6g} s" if names else ""


def words_on_shares(met: Sequence[Event]) -> str:
    """On which stops' shares the motion depends, and since when; "" where it does not."""
    which = [event for event in met if event.kind == DECIDES]
    names = ", ".join(dict.fromkeys(event.name for event in which))
    return f"{names}, first at t = {which[0].time:.6g} s" if which else ""


def words_on_halvings(halved: Sequence[Halved]) -> str:
    """For want of what fixed steps were halved, the most frequent first; "" where none was."""
    if not halved:
        return ""
    most = sorted(halved, key=lambda each: -each.times)
    said = [f"{each.where} {_often(each.times)}, first at t = {each.first:.6g} s" for each in most[:MOST_PASSED]]
    more = f"; {len(most) - MOST_PASSED} more" if len(most) > MOST_PASSED else ""
    return f"{_often(sum(each.times for each in halved))}, for want of {'; '.join(said)}{more}"


def _often(times: int) -> str:
    return {1: "once", 2: "twice"}.get(times, f"{times:,} times")


def summary(scene: str, output: str, report: Report, total_seconds: float) -> dict[str, Any]:
    """What the results file keeps as attributes, and --json prints: the run of the scene at `scene` to `output`."""
    return {
        "scene": str(scene),
        "output": str(output),
        "formulation": report.formulation,
        "formulation_why": report.why,
        "projection": report.settings.projection.method,
        "integrator": report.settings.integrator,
        "degrees_of_freedom": report.degrees_of_freedom,
        "kinematic": report.kinematic,
        "redundant_rows": report.redundant_rows,
        **report.counters,
        "integration_seconds": report.integration_seconds,
        "recording_seconds": report.recording_seconds,
        "total_seconds": total_seconds,
        "position_violation_max": report.position_violation.value,
        "velocity_violation_max": report.velocity_violation.value,
        "position_violation_floor": report.position_floor,
        "velocity_violation_floor": report.velocity_floor,
        "worst_joint": report.worst_joint,
        "energy_drift": report.energy_drift,
        "energy_drift_relative": report.energy_drift_relative,
        "energy_put_in": report.energy.work,
        "energy_dissipated": report.energy.dissipation,
        "energy_numerical": report.energy.numerical,
        **_of_rows(report),
        "stiffness": report.stiffness,
        "events": report.events,
        "passed_over": report.passed,
        "halved": report.halved,
        "shared_at_contacts": report.shared,
        "decided_by_shares": report.decided_by_shares,
        "methods": "; ".join(report.methods),
        "status": "complete",
    }


def _of_rows(report: Report) -> dict[str, Any]:
    """What the rows of the energy and of momenta did, where they were asked for."""
    projection, rows = report.settings.projection, report.rows
    if not (projection.energy or projection.momentum):
        return {}
    return {
        "rows_steps": rows.steps,
        "rows_left_near_rest": rows.rest,
        "rows_refused": rows.refused,
        "rows_momenta": rows.momenta,
        "energy_row_given": rows.given,
        "energy_row_furthest": rows.furthest,
        "energy_row_moved": rows.moved,
        "rows_largest_correction": rows.largest,
    }


class EnergyWatch:
    """Scratch of a run: the largest |balance|, kinetic energy, and range of the potential energy so far."""

    def __init__(self, scale: float = 0.0, *, moves: bool = True, wanted: bool = True) -> None:
        """`scale`: the mechanism's energy in J, as its weight times its size; `moves`: whether it can move at all. All
        is NaN of a run whose energies are not `wanted`."""
        self._scale, self._moves, self._wanted = scale, moves, wanted
        self.drift = self.kinetic = 0.0 if wanted else float("nan")
        self.lowest, self.highest = float("inf"), float("-inf")
        self.account = EnergyAccount() if wanted else EnergyAccount(*[float("nan")] * 3)

    def watch(self, block: Block) -> None:
        """Takes in a block, and where the energy has gone until its end."""
        if not self._wanted:
            return
        potential, balance = block["diagnostics/potential_energy"], block["diagnostics/energy_balance"]
        work, dissipation = (float(block[f"diagnostics/{name}"][-1]) for name in ("work", "dissipation"))
        self.account = EnergyAccount(work, dissipation, float(balance[-1]))
        kinetic = float(block["diagnostics/kinetic_energy"].max())
        self.take(float(np.abs(balance).max()), kinetic, float(potential.min()), float(potential.max()))

    def take(self, balance: float, kinetic: float, lowest: float, highest: float) -> None:
        """Takes in a block: its largest |balance| and kinetic energy, and its range of the potential energy."""
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
        nothing = THRESHOLDS.rests * EPSILON * max(self._scale, abs(self.lowest), abs(self.highest))
        rests = max(size, self.drift) <= nothing or size == 0.0
        return 0.0 if rests or not self._moves else self.drift / size
