"""The case that all checks of a verification share: a mechanism, a moving state, and quantities that are computed from
it once.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError
from mbproj.base.registry import PROJECTIONS, with_fixed_steps
from mbproj.base.settings import ProjectionSettings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinate_values
from mbproj.equations.constraints import set_jacobian
from mbproj.equations.gaps import gaps, stop_sizes
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.row_space import scaled_jacobian
from mbproj.kernel import core
from mbproj.kernel.models import without_form
from mbproj.model.system import System
from mbproj.motion.formulations.choice import Choice
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows
from mbproj.motion.time_events import splits_of
from mbproj.scene.scene import Scene
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Failure, Mechanism, Solution, sample_times, solve
from mbproj.studies.verify.equations import EPS, RoundedEquations, equations_at, independent_rows

# --- Short runs with the scene's own settings and 2, 3, 4, 6, 8, 12 . -------------------------------------------------
# Steps, from which the order is determined.


#: Length of a run, in the time that the fastest part of the mechanism takes for 1 rad. The second is tried where runs
#: of the first fail, pass over an edge of a law, or show no order.
SPANS = (2.0, 0.5)
#: Numbers of steps. The full formulation, a thousand times slower, uses only the first `FEWER` of them.
STEPS, FEWER = tuple(sorted([*(2**power for power in range(1, 10)), *(3 * 2**power for power in range(8))])), 11
#: An error tells of the order only where it is this many times above its round-off.
ABOVE = 10.0
#: Errors that differ by less than this part do not fall: doubling the steps of a method of order 1 halves its error.
LEVEL = 0.1
#: An order is fitted to the last `FITTED` runs. From `BENT` runs on the fitted line may bend. Only runs with `COARSER`
#: times fewer steps than the finest are measured against it.
FITTED, BENT, COARSER = 6, 5, 4
#: A run tells of the order only where its steps are more than this many times its events.
CROWDED = 2


@dataclass(frozen=True)
class Order:
    """An observed order, and twice its standard error."""

    value: float
    uncertainty: float


@dataclass(frozen=True, eq=False)
class ShortRuns:
    """The runs of a mechanism that came to their end, by increasing number of `steps`. `failure` is that of a run that
    did not, or None.

    `length` (m) and `span` (s) are the units of errors. `floor` is the error that round-off and the projection's stop
    test leave in any run. `split` names a short movement for which steps are split; "" where there is none."""

    steps: Array
    solutions: tuple[Solution, ...]
    failure: Failure | None
    length: float
    span: float
    floor: float
    split: str = ""

    @property
    def passed(self) -> str:
        """An edge of a law that the steps of a run passed over, so that no method keeps its order; "" where there is
        none."""
        return next((each.report.passed for each in self.solutions if each.report and each.report.passed), "")

    @property
    def errors(self) -> Array:
        """The largest difference at the end between each of the coarser runs and the finest: in orientations, positions
        and velocities of bodies and markers."""
        if not self.solutions:
            return np.zeros(0)
        ends = np.array([self._end(each) for each in self.solutions])
        return np.abs(ends - ends[-1]).max(axis=1)[COARSER * self.steps <= self.steps[-1]]

    @property
    def events(self) -> Integers:
        """The number of times at which each run met events. Steps end there."""
        return np.array([0 if each.report is None else each.report.events for each in self.solutions], dtype=np.intp)

    @property
    def is_level(self) -> bool:
        """Whether events occur and the coarser half of the errors is constant: then something else decides the length
        of the steps."""
        coarse = self.errors[: len(self.errors) // 2]
        return (
            bool(self.events.any())
            and len(coarse) > 1
            and bool(coarse.min() > ABOVE * self.floor and np.ptp(coarse) < LEVEL * coarse.min())
        )

    def _end(self, solution: Solution) -> Array:
        places, rates = ("body_position", "marker_position"), ("body_velocity", "marker_velocity")
        turned = solution.body_orientation[-1]
        return np.concatenate(
            [
                np.einsum("ni,nj->nij", turned, turned).ravel(),  # Λ and -Λ are one orientation
                *(getattr(solution, name)[-1].ravel() / self.length for name in places),
                *(getattr(solution, name)[-1].ravel() * self.span / self.length for name in rates),
            ]
        )

    def order(self, values: Array) -> Order | None:
        """The power of the step with which `values`, one for each of the first runs, fall. A line is fitted to the
        logarithms of the last values above round-off. Runs whose steps mostly end at events do not count: such steps do
        not shorten. None where fewer than three runs are left."""
        low = np.flatnonzero(~(values > ABOVE * self.floor))
        above = values[: low[0]] if len(low) else values
        uncrowded = self.steps[: len(above)] > CROWDED * self.events[: len(above)]
        return order_of(self.steps[: len(above)][uncrowded][-FITTED:], above[uncrowded][-FITTED:])


def order_of(steps: Array, values: Array) -> Order | None:
    """Fit the power of the step with which values fall; None for fewer than three values.

    Coarse steps may hide it. So from `BENT` values on the next power of the step enters: log |c hᵖ (1 + a h)| ≈ log c +
    p log h + a h. Its slope at the finest step is taken where it is higher and less uncertain than the straight line's.
    Fewer values would bend any line downwards."""
    x, y = np.log2(steps), np.log2(values)
    if len(x) < 3:
        return None
    straight = _slope(y, np.column_stack([-x, np.ones(len(x))]))
    if len(x) < BENT:
        return straight
    h = steps[0] / steps
    # the last column has no slope at the finest step
    bent = _slope(y, np.column_stack([-x, np.ones(len(x)), h + h[-1] * np.log(2.0) * x]))
    return bent if bent.value > straight.value and bent.uncertainty < straight.uncertainty else straight


def _slope(y: Array, columns: Array) -> Order:
    """The coefficient of the first column in the least-squares fit of y, and twice its standard error."""
    solution = np.linalg.lstsq(columns, y, rcond=None)[0]
    residual = y - columns @ solution
    spread = residual @ residual / (len(y) - columns.shape[1]) * np.linalg.inv(columns.T @ columns)[0, 0]
    return Order(float(solution[0]), 2.0 * float(np.sqrt(spread)))


def short_runs(mechanism: Mechanism, rate: float, slow: bool) -> ShortRuns:
    """The runs of a mechanism that turns at up to `rate` (rad/s). `slow` says that steps are expensive."""
    longer, shorter = SPANS
    runs = _runs_over(mechanism, longer / rate, slow)
    if runs.failure is None and not runs.passed and runs.order(runs.errors) is not None:
        return runs
    again = _runs_over(mechanism, shorter / rate, slow)
    if runs.passed or again.passed:
        return runs if again.passed else again
    return again if again.order(again.errors) is not None or runs.failure is not None else runs


def _runs_over(mechanism: Mechanism, span: float, slow: bool) -> ShortRuns:
    """The runs over a span in s, with each number of steps."""
    setting, times = Setting.of(mechanism.scene.settings), sample_times(span, 1)
    setting = replace(setting, integrator=with_fixed_steps(setting.integrator))
    done, solutions, failure = [], [], None
    for steps in STEPS[:FEWER] if slow else STEPS:
        solution = solve(mechanism, replace(setting, step=span / steps, tolerance=None), times)
        if solution.failure is None:
            done.append(steps)
            solutions.append(solution)
        else:
            failure = solution.failure
    projection = mechanism.scene.settings.projection
    floor = max(_left_open(projection) / mechanism.system.length, STEPS[-1] * EPS)
    coarsest = mechanism.settings(replace(setting, step=span / STEPS[0], tolerance=None), span, span)
    splits = splits_of(mechanism.system, mechanism.state.t, coarsest)
    split = splits[0].owner if splits else ""
    return ShortRuns(np.array(done), tuple(solutions), failure, mechanism.system.length, span, floor, split)


def _left_open(projection: ProjectionSettings) -> float:
    """The largest violation that a projection may leave, m."""
    if not PROJECTIONS[projection.method].corrects or not projection.position:
        return 0.0
    stop = THRESHOLDS.paper_tolerance**0.75 if projection.test == "paper" else THRESHOLDS.closed_to
    return max(projection.tolerance or stop, projection.threshold or 0.0)


# --- The case that all checks of a verification share -----------------------------------------------------------------


#: Checks with dense matrices are made up to this number of bodies: there their error bounds take a few seconds.
DENSE = 40
#: The mass matrix is not definite where a body has no mass, or a ratio of its smallest to its largest moment of inertia
#: below this.
DEFINITE = 1e-12


class ShortRun(NamedTuple):
    """The short runs from one state, with different numbers of steps."""

    name: str
    state: State
    runs: ShortRuns


@dataclass(frozen=True, eq=False)
class Case:
    """A mechanism with all that its checks need, each computed when first asked for."""

    mechanism: Mechanism

    @property
    def scene(self) -> Scene:
        """The scene of the mechanism."""
        return self.mechanism.scene

    @property
    def system(self) -> System:
        """The scene compiled to arrays."""
        return self.mechanism.system

    @cached_property
    def choice(self) -> Choice:
        """The formulation that a run of the scene uses."""
        return self.mechanism.choice(self.scene.settings)

    @cached_property
    def state(self) -> State:
        """The start with a random velocity added."""
        return self._moving(1.0, 1.0)

    def _moving(self, translating: float, rotating: float) -> State:
        """Return the start with a random velocity added. `translating` and `rotating` scale the parts of that velocity.
        It is projected onto the motions that joints, and rigid stops that touch, allow. Its size is `rate` times the
        mechanism's length, or `rate`."""
        system, start = self.system, self.mechanism.state
        rows = scaled_jacobian(system, pose_of(start.q))[independent_rows(system, start.q)]
        weights = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
        rate = self.rate * np.random.default_rng(0).normal(size=len(weights))
        rate *= np.tile([translating] * 3 + [rotating] * 4, system.bodies)
        allowed = rate - np.linalg.lstsq(rows, rows @ rate, rcond=None)[0]
        touching = _touching(system, start) * weights
        if (touching @ allowed < 0.0).any():  # it would move into a stop: let it move along the stop
            rows = np.vstack([rows, touching])
            allowed = rate - np.linalg.lstsq(rows, rows @ rate, rcond=None)[0]
        return start.changed(velocities=start.v + weights * allowed)

    @cached_property
    def rate(self) -> float:
        """The rate of the mechanism's motion, rad/s: the largest of its rate at the start, √(g / length), and the
        square root of its largest acceleration at the start. It is 1 where all of these are zero."""
        system, start = self.system, self.mechanism.state
        pulls = [float(np.linalg.norm(system.gravity)) / system.length]
        if not self.too_large:
            pull = equations_at(system, start).accelerations().value[: 7 * system.bodies]
            pulls.append(_fastest(system, pull))
        return max(_fastest(system, start.v), float(np.sqrt(max(pulls)))) or 1.0

    @cached_property
    def equations(self) -> RoundedEquations:
        """The equations of motion at `state`."""
        return equations_at(self.system, self.state)

    @cached_property
    def runs(self) -> ShortRuns:
        """The short runs from `state`."""
        return self._from(self.state)

    @cached_property
    def motions(self) -> tuple[ShortRun, ...]:
        """The short runs from the scene's own start, and from starts that rotate, translate, and do both."""
        states = {
            "from the scene's own start": self.mechanism.state,
            "rotating": self._moving(0.0, 1.0),
            "translating": self._moving(1.0, 0.0),
        }
        others = (ShortRun(name, state, self._from(state)) for name, state in states.items())
        return *others, ShortRun("rotating and translating", self.state, self.runs)

    def _from(self, state: State) -> ShortRuns:
        fastest = max(_fastest(self.system, state.v), self.rate)
        return short_runs(Mechanism(self.scene, self.system, state), fastest, slow=self.choice.name == "full")

    @cached_property
    def displacement(self) -> Array:
        """A random change of all coordinates, (7n,), of the size of the mechanism's length and of 1 for Euler
        parameters."""
        weights = np.tile([self.system.length] * 3 + [1.0] * 4, self.system.bodies)
        return weights * np.random.default_rng(1).normal(size=len(weights))

    @property
    def reference(self) -> Array:
        """The joints' coordinates at `state`, with turns counted, (nc,)."""
        return coordinate_values(self.system, pose_of(self.state.q)) + 2.0 * np.pi * self.state.turns

    @property
    def redundant(self) -> bool:
        """Whether some constraint rows depend on others."""
        return len(self.equations.rows) < self.system.constraints

    @property
    def too_large(self) -> str | None:
        """The reason why checks with dense matrices do not apply; None where they do."""
        bodies = self.system.bodies
        return f"{bodies} bodies: checks with dense matrices stop at {DENSE}" if bodies > DENSE else None

    @property
    def indefinite(self) -> str | None:
        """The reason why M is not definite even in tangent coordinates; None where it is definite."""
        for name, mass, inertia in zip(self.system.names.carriers, self.system.mass, self.system.inertia, strict=True):
            moments = np.linalg.eigvalsh(inertia)
            if mass <= 0.0 or moments[0] <= DEFINITE * moments[-1]:
                return f"body '{name}' has no definite mass and inertia"
        return None

    @cached_property
    def reduced(self) -> Reduced | str:
        """The kernel's reduced formulation, or the reason why it is not available."""
        kernel = core()
        if kernel is None:
            return "there is no compiled kernel"
        missing = without_form(self.system)
        if missing is not None:
            return f"the kernel has no primitive '{missing}'"
        compiled = Reduced(kernel, self.system)
        redundant = settle_rows(compiled, self.mechanism.state)
        regular, _ = compiled.is_regular(self.mechanism.state)
        return compiled if regular and redundant is not None else "in space the start is a singular pose"

    @property
    def planar(self) -> Compiled | str:
        """The kernel's planar formulation, or the reason why it is not available."""
        compiled = self.choice.compiled
        return compiled if compiled is not None and compiled.name == "planar" else self.not_planar

    @property
    def not_planar(self) -> str:
        """The reason why the case is not computed in a plane."""
        try:
            self.mechanism.choice(replace(self.scene.settings, formulation="planar"))
        except InputError as error:
            return error.problems[0].message
        return f"the scene asks for the {self.choice.name} formulation"


def _touching(system: System, start: State) -> Array:
    """The gradients of the gaps of the rigid stops that touch, (k, 7n)."""
    stops, pose = system.stops, pose_of(start.q)
    if stops is None:
        return np.zeros((0, 7 * system.bodies))
    touch = stops.is_rigid & (gaps(stops, pose, start.turns) <= THRESHOLDS.same_written * stop_sizes(system))
    return np.asarray((stops.side[:, None] * set_jacobian(stops.coordinates, pose))[touch])


def _fastest(system: System, rates: Array) -> float:
    """The largest rate, 1/s, in the rates of all coordinates (7n,): speeds over the mechanism's length, and ω = 2
    |Λ'|."""
    parts = np.abs(rates.reshape(-1, 7))
    return max(float(parts[:, :3].max()) / system.length, 2.0 * float(parts[:, 3:].max()))


# --- The finding of a check -------------------------------------------------------------------------------------------
# A measured number, the bound on it, and whether the bound holds.


#: Where round-off alone may change a result by more than this part of it, a comparison tells nothing.
VACUOUS = 0.1


@dataclass(frozen=True)
class Finding:
    """A measured number and the bound `allowed` on it, in the same unit. `remark` is a note for the reader."""

    measured: float
    allowed: float
    remark: str = ""
    #: Whether `allowed` is a lower bound on `measured` instead of an upper one.
    at_least: bool = False

    @property
    def passed(self) -> bool:
        """Whether the bound holds."""
        good = self.measured >= self.allowed if self.at_least else self.measured <= self.allowed
        return bool(good)


#: The result of a check: its finding, or the reason why it does not apply.
Found = Finding | str


def difference(one: Array, other: Array, bound: Array, scale: Array | float = 1.0, whole: float | None = None) -> Found:
    """Compare two results that are to be equal to within `bound`, component by component.

    Differences are in units of `scale`, as parts of `whole`, by default the largest component of `other`. Return the
    component that is nearest to its bound or farthest beyond it, or the reason why nothing can be told."""
    if not one.size:
        return "nothing to compare"
    if whole is None:
        whole = float(np.abs(other / scale).max())
    if whole == 0.0:
        return "nothing moves: all that is compared is zero"
    gap, allowed = np.abs(one - other) / (scale * whole), bound / (scale * whole) + EPS
    worst = int(np.argmax(gap / allowed))
    if allowed.flat[worst] > 1.0:
        return "both results are nothing but round-off"
    if allowed.flat[worst] > VACUOUS:
        return f"round-off alone may change it by {allowed.flat[worst]:.1g} of its size: nothing can be told"
    return Finding(float(gap.flat[worst]), float(allowed.flat[worst]))


def worse(findings: list[Found]) -> Found:
    """The finding that is nearest to its bound or farthest beyond it. Where there is none, return the first reason."""
    numbers = [each for each in findings if isinstance(each, Finding)]
    if not numbers:
        return findings[0]
    return max(numbers, key=lambda each: each.measured / each.allowed if each.allowed else np.inf)
