"""Check of the linear model: near its equilibrium a run follows the mode in which it starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dynamics import State
from mbproj.dynamics.derivatives.linear_equations import tangent_force
from mbproj.dynamics.derivatives.tangent import moved, velocities
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.errors import InputError
from mbproj.integrate import simulate
from mbproj.integrate.events.law_switches import switches_of
from mbproj.linear.equilibrium.find import Equilibrium, equilibrium
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.equilibrium.started import consistent
from mbproj.linear.modes import Modes, modes
from mbproj.model import initial_guess
from mbproj.model.system import System
from mbproj.registry import EQUILIBRIUM
from mbproj.scene.records import Settings
from mbproj.studies.verify.case import Case
from mbproj.studies.verify.finding import Finding, Found
from mbproj.studies.verify.turns import TurnRecorder

#: Amplitude of the motion (the mechanism's length, or rad), number of steps, and duration as a part of the slowest
#: mode's period. Half the difference of two runs with opposite amplitudes has an error of the amplitude squared; the
#: steps have the fourth order.
AMPLITUDE, STEPS, PART = 6e-5, 400, 0.25
ALLOWED = 1e-6
#: The largest phase of the fastest mode in one step, rad, and the most steps of a run.
STABLE, MOST_STEPS = 1.0, 20_000


def small_motions(case: Case) -> Found:
    """Check the joint coordinates after a part of the slowest oscillation against the mode. The error is relative to
    the amplitude."""
    if case.too_large:
        return case.too_large
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
    steps = max(STEPS, int(np.ceil(time * float(np.abs(modal.eigenvalues).max()) / STABLE)))
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
    recorder = TurnRecorder()
    formulation = case.scene.settings.formulation
    settings = Settings(duration=time, step=time / steps, output_step=time, formulation=formulation, start=EQUILIBRIUM)
    simulate(case.system, start, settings, recorder)
    return recorder.coordinate[-1]
