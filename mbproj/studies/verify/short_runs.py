"""Checks of short runs with the scene's own settings: the integrator's order, the energy balance, closed joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.errors import InputError
from mbproj.base.registry import EQUILIBRIUM, PROJECTIONS, integrators, with_fixed_steps
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.derivatives import tangent_force
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import drive_at
from mbproj.equations.tangent_space import moved, velocities
from mbproj.linear.equilibrium.find import Equilibrium, equilibrium
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.equilibrium.start import consistent
from mbproj.linear.modes import Modes, modes
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.system import System
from mbproj.motion.law_switches import switches_of
from mbproj.motion.simulate import simulate
from mbproj.scene.settings import settings_to_run
from mbproj.studies.measure.solve import DatasetRecorder, Solution
from mbproj.studies.verify.case import ABOVE, Case, Finding, Found, Order, ShortRun, ShortRuns
from mbproj.studies.verify.equations import EPS

#: An observed order is rounded to the nearest whole number.
ROUNDED = 0.5
#: An observed order with a larger uncertainty than this tells nothing.
UNTOLD = 2.0
#: The fewest runs that give an order.
FEWEST = 3
#: Energies below this part of Σm (rate × length)² count as zero.
STILL = 1e-12


def observed_order(case: Case) -> Found:
    """Check that the error at a run's end falls with the step at the integrator's order or faster. Of all motions the
    one with the lowest order counts."""
    findings = [(motion.name, _order_of(case, motion)) for motion in case.motions]
    remarked = [replace(each, remark=f"{each.remark}, {name}") for name, each in findings if isinstance(each, Finding)]
    return min(remarked, key=lambda each: each.measured - each.allowed) if remarked else findings[-1][1]


def _order_of(case: Case, motion: ShortRun) -> Found:
    runs, obstacle = motion.runs, _obstacle(case, motion)
    if obstacle:
        return obstacle
    order = runs.order(runs.errors) if len(runs.solutions) >= FEWEST else None
    if runs.failure is not None and runs.failure.status == "refused":  # the start moves into a stop
        return str(runs.failure)
    if order is None:
        unseen = "its error is no more than round-off and the projection leave: no order can be seen"
        return _stopped(case, runs) if runs.failure else unseen
    return _compared(case, order, "")


def energy_balance(case: Case) -> Found:
    """Check that the error of the energy balance falls with the step at the integrator's order, or is round-off. The
    balance is the energy less the work, plus the losses of dampers."""
    motion = case.motions[-1]
    runs, obstacle = motion.runs, _obstacle(case, motion)
    if obstacle:
        return obstacle
    if len(runs.solutions) < FEWEST:
        return _stopped(case, runs)
    size, system = max(map(_energy, runs.solutions)), case.system
    if size <= STILL * float(system.mass.sum()) * (case.rate * system.length) ** 2:
        return "nothing moves, and no energy changes"
    drifts = np.array([np.abs(each.energy_balance).max() for each in runs.solutions]) / size
    order = runs.order(drifts)
    if order is None:
        return Finding(float(drifts.min()), ABOVE * runs.floor, "of the energy, at the best step: round-off")
    return _compared(case, order, f", from {drifts[0]:.0e} of the energy to {drifts.min():.0e}")


def _compared(case: Case, order: Order, remark: str) -> Found:
    """Compare an observed order with the integrator's. It may be lower by its own uncertainty and by `ROUNDED`."""
    name = with_fixed_steps(case.scene.settings.integrator)
    wanted = integrators()[name].order
    if order.uncertainty > UNTOLD:
        return f"its errors fall too unevenly to tell an order ({order.value:.1f} ± {order.uncertainty:.1f})"
    said = f"{name} has order {wanted}, seen to ± {order.uncertainty:.1g}{remark}"
    return Finding(order.value, wanted - ROUNDED - order.uncertainty, said, at_least=True)


def joints_closed(case: Case) -> Found:
    """Compare the largest |C| after any step with the tolerance of the stop test."""
    projection = case.scene.settings.projection
    if not PROJECTIONS[projection.method].corrects:
        return f"'{projection.method}' does not close the joints"
    if not projection.position or projection.every > 1 or projection.threshold is not None:
        return "the scene does not project its positions after every step"
    if projection.test == "paper":
        return "the paper's stop test measures corrections, not how far joints are open"
    if not case.runs.solutions:
        return _stopped(case, case.runs)
    reports = [each.report for each in case.runs.solutions if each.report is not None]
    worst = max((report.position_violation for report in reports), key=lambda each: each.value)
    largest = max(float(np.abs(each.body_position).max()) for each in case.runs.solutions) + case.system.length
    return Finding(
        worst.value, projection.tolerance or max(THRESHOLDS.closed_to, 4.0 * EPS * largest), f"m or rad, {worst.owner}"
    )


def _stopped(case: Case, runs: ShortRuns) -> Found:
    """Return a failed finding for runs that do not get to their end."""
    wanted = integrators()[with_fixed_steps(case.scene.settings.integrator)].order
    return Finding(0.0, wanted - ROUNDED, f"the run stops: {runs.failure}", at_least=True)


def _energy(solution: Solution) -> float:
    """The largest kinetic energy plus the range of the potential energy, J."""
    potential = solution.potential_energy
    return float(solution.kinetic_energy.max() + potential.max() - potential.min())


def _obstacle(case: Case, motion: ShortRun) -> str | None:
    """The reason why no order can be expected; None where one can."""
    if motion.runs.split:
        return (
            f"steps are split for a shorter movement ({motion.runs.split}): then the error does not fall with the step"
        )
    if case.system.stops is not None and motion.runs.is_level:
        return "the motion meets a stop, which has steps of its own: the error does not fall with the run's step"
    passed = motion.runs.passed or _edge_at_start(case, motion.state)
    return f"fixed steps pass over edges of laws, where no method keeps its order ({passed})" if passed else None


def _edge_at_start(case: Case, state: State) -> str:
    """The switch of a law that the start lies exactly on; "" where there is none."""
    switches = switches_of(case.system)
    if switches is None:
        return ""
    free = np.flatnonzero(np.isnan(switches.branches(state.instant(case.system))))
    return f"{switches.owner(free[0])}: {switches.what(free[0])}, at the start" if len(free) else ""


# --- Check of the scene's own steps -----------------------------------------------------------------------------------
# Gears do not slip by teeth, screws by threads, or driven angles by turns.


#: Length of the run: this many of the scene's steps, or with error control this many radians of its fastest part.
TURN_STEPS, RADIANS = 64, 20.0
#: A deviation below this part of a tooth or turn is an error that the projection leaves, not a slip.
WHOLE = 0.5


def teeth_kept(case: Case) -> Found:
    """Count the teeth, threads or turns by which recorded coordinates leave what gears, screws and motions prescribe.
    The largest count over the scene's first steps is the finding."""
    if not (case.system.couplings.size or _driven_angles(case.system).size):
        return "there are no gears, screws or driven angles"
    recorder = DatasetRecorder(("joints/coordinate", "motions/value"))
    simulate(case.system, case.mechanism.state, _short(case), recorder)
    coordinate = recorder["joints/coordinate"]
    away = slipped(case.system, coordinate, recorder["motions/value"])
    return Finding(away, WHOLE, f"teeth or turns, in {len(coordinate) - 1} samples")


def slipped(system: System, coordinate: Array, prescribed: Array) -> float:
    """The largest number of teeth, threads or turns by which any sample differs from the first. `coordinate` (T, nc)
    are the joints' coordinates, `prescribed` (T, k) the values of motions."""
    sums, angles = system.couplings.sums(coordinate), _driven_angles(system)
    teeth = np.abs(sums - sums[0]) / np.where(system.couplings.period > 0.0, system.couplings.period, system.length)
    turns = np.abs(coordinate[:, system.motions.joint_coordinate] - prescribed)[:, angles] / (2.0 * np.pi)
    return float(max(teeth.max(initial=0.0), turns.max(initial=0.0)))


def _driven_angles(system: System) -> Integers:
    """The numbers of the motions that drive an angle."""
    return np.flatnonzero(~system.rows.is_length[system.joints.size :])


def _short(case: Case) -> Settings:
    """The scene's own settings, shortened to its first steps."""
    settings = settings_to_run(case.scene)
    assert settings.duration is not None
    if settings.step is not None:
        return replace(settings, duration=min(settings.duration, TURN_STEPS * settings.step), output_step=None)
    duration = min(settings.duration, RADIANS / case.rate)
    return replace(settings, duration=duration, output_step=duration / TURN_STEPS)


# --- Check of the linear model ----------------------------------------------------------------------------------------
# Near its equilibrium a run follows the mode in which it starts.


#: Amplitude of the motion (the mechanism's length, or rad), number of steps, and duration as a part of the slowest
#: mode's period. Half the difference of two runs with opposite amplitudes has an error of the amplitude squared; the
#: steps have the fourth order.
AMPLITUDE, MODE_STEPS, PART = 6e-5, 400, 0.25
ALLOWED = 1e-6
#: The largest phase of the fastest mode in one step, rad, and the most steps of a run.
STABLE, MOST_STEPS = 1.0, 20_000


def small_motions(case: Case) -> Found:
    """Check the joint coordinates after a part of the slowest oscillation against the mode. The error is relative to
    the amplitude."""
    if not case.system.coordinates.size:
        return "there are no joint coordinates to compare"
    try:
        rest = equilibrium(case.system, case.mechanism.state)
        modal = modes(rest.reference)
    except (NoEquilibrium, InputError) as error:
        return f"there is nothing to linearise: {str(error).splitlines()[0].removeprefix('error: ')}"
    if rest.reference.held:
        return f"dry friction holds it: {', '.join(rest.reference.held)}"
    slow = np.flatnonzero((modal.eigenvalues.imag > 0.0) & np.any(np.abs(modal.coordinates) > 0.0, axis=1))
    if not len(slow):
        return "no mode oscillates"
    mode = int(slow[0])
    time = PART * 2.0 * np.pi / float(abs(modal.eigenvalues[mode]))
    if _depends_on_time(case, rest, time):
        return "forces or motions change with time, and the linear model with them"
    steps = max(MODE_STEPS, int(np.ceil(time * float(np.abs(modal.eigenvalues).max()) / STABLE)))
    if steps > MOST_STEPS:
        return f"its modes are so far apart that following the slowest takes {steps} steps"
    sides = [_displaced_along(case, rest, modal, mode, size) for size in (AMPLITUDE, -AMPLITUDE)]
    edge = _edge_between(case.system, *sides)
    if edge:
        return f"it rests at the edge of a law, and moves differently on its two sides: {edge}"
    ends = [_final_coordinates(case, side, time, steps) for side in sides]
    moves: Numbers = modal.coordinates[mode]
    expected = (moves * np.exp(modal.eigenvalues[mode] * time)).real
    off = np.abs((ends[0] - ends[1]) / (2.0 * AMPLITUDE) - expected).max() / np.abs(moves).max()
    return Finding(float(off), ALLOWED, f"in the mode of {modal.frequencies[mode]:.4g} Hz")


def _displaced_along(case: Case, rest: Equilibrium, modal: Modes, mode: int, size: float) -> State:
    """The equilibrium, displaced by `size` along a mode and moving in that mode."""
    motion, λ = rest.reference.motion, modal.eigenvalues[mode]
    ξ = modal.shapes[mode].copy()
    ξ[:, 3:] = np.einsum("bji,bj->bi", motion.pose.rotation[:-1], ξ[:, 3:])
    q = moved(motion.q, size * ξ.real.ravel())
    v = velocities(pose_of(q), size * (λ * ξ).real.ravel())
    state = consistent(case.system, replace(initial_guess(case.scene, case.system), q=q, v=v))
    return state.changed(turns=rest.state.turns, states=rest.state.x + size * modal.states[mode].real)


def _edge_between(system: System, one: State, other: State) -> str:
    """The law whose branch differs between two states; "" where no branch does."""
    switches = switches_of(system)
    if switches is None:
        return ""
    branches = [switches.branches(state.instant(system)) for state in (one, other)]
    differ = np.flatnonzero(branches[0] != branches[1])
    return f"{switches.owner(differ[0])}: {switches.what(differ[0])}" if len(differ) else ""


def _depends_on_time(case: Case, rest: Equilibrium, time: float) -> bool:
    """Whether the forces, or the prescribed motions, change within `time`."""
    motion, system = rest.reference.motion, case.system
    forces = [tangent_force(system, replace(motion, t=t)) for t in (motion.t, motion.t + 0.5 * time, motion.t + time)]
    drives = [drive_at(system, t) for t in (motion.t, motion.t + time)]
    moves = any(drive.rate.any() or drive.acceleration.any() for drive in drives)
    return moves or any(not np.array_equal(forces[0], other) for other in forces[1:])


def _final_coordinates(case: Case, start: State, time: float, steps: int) -> Array:
    """The joints' coordinates at the end of a run of length `time` (s)."""
    recorder = DatasetRecorder(("joints/coordinate",))
    formulation = case.scene.settings.formulation
    settings = Settings(duration=time, step=time / steps, output_step=time, formulation=formulation, start=EQUILIBRIUM)
    simulate(case.system, start, settings, recorder)
    return np.asarray(recorder["joints/coordinate"][-1])
