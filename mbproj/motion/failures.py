"""Errors of a run that cannot go on, in the same words for every formulation."""

from __future__ import annotations

from collections.abc import Callable
from math import floor, log10, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.registry import PROJECTIONS, explicit_integrators, implicit_integrators
from mbproj.base.settings import ProjectionSettings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import nearest
from mbproj.equations.assembly.gauss_newton import moved
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import Drive, drive_at
from mbproj.equations.rank.mobility import least_inertia
from mbproj.model.system import System
from mbproj.motion.steppers.runge_kutta import reach
from mbproj.motion.steppers.tableau import tableau_of

if TYPE_CHECKING:
    from mbproj.equations.assembly.assemble import State


SMALLER = "try a smaller step or tolerance"
LOOSER = "take smaller steps, or give a tolerance instead"
UNSOLVED = "Newton's method did not solve the equations of an implicit step"


def not_finite(t: float) -> SimulationError:
    """Return the error of a solution that has overflowed."""
    return SimulationError(t, "the solution is no longer finite", hint=SMALLER)


def singular(t: float, where: str | None) -> SimulationError:
    """Return the error of equations without a unique solution at this pose."""
    cause = "the constraints are no longer independent of each other (a singular position)"
    return SimulationError(t, cause, where=where, hint="start from another pose, or change the lengths a little")


def branch_untold(t: float, where: str | None = None) -> SimulationError:
    """Return the error of a motion without degrees of freedom, where Newton's method may come to another branch, or to
    none, however short the step."""
    cause = (
        "what the motions prescribe cannot be followed beyond here: the mechanism is at a dead centre, or branches of "
        "its motion cross"
    )
    return SimulationError(t, cause, where=where, hint="turn back before, drive another joint, or change the lengths")


def ill_conditioned(t: float, *, penalty: float | None) -> SimulationError:
    """Return the error of a matrix that is singular to working precision although the constraints are independent: its
    entries are too far apart. `penalty`: the projection's α, None where its method has none."""
    if penalty is None:
        cause = "masses and inertias are too far apart for this method: its equations are singular to working precision"
        return SimulationError(t, cause, hint="use gpopm with the bordered accelerations, in the reduced formulation")
    cause = f"the penalty α = {penalty:g} is too far from the masses: its equations are singular to working precision"
    return SimulationError(t, cause, hint="choose an α nearer to the masses in kg, or gpopm, which needs none")


def other_branch(t: float, change: float) -> SimulationError:
    """Return the error of a projection that led to another branch of the motion, which must not happen silently."""
    cause = (
        f"the projection would change the velocity by {100.0 * change:.0f} % at once: branches of the motion cross "
        "near here (a singular position), and the step has come nearer to another one than its own"
    )
    hint = "a smaller step or tolerance keeps nearer to the branch; or change a length a little"
    return SimulationError(t, cause, hint=hint)


class LostStep(SimulationError):
    """The error of a step so far from the motion that its projection is meaningless."""

    def __init__(self, t: float, change: float) -> None:
        cause = f"the projection would change the velocity by {100.0 * change:.0f} % at once"
        super().__init__(t, f"{cause}: the step has lost the motion", hint=SMALLER)


def branches_near(t: float) -> SimulationError:
    """Return the error of a step to where branches of the motion cannot be distinguished."""
    cause = (
        "branches of the motion cross near here (a singular position), and the step is too large to tell its own from "
        "another one"
    )
    hint = "a smaller step or tolerance keeps nearer to the branch; or change a length a little"
    return SimulationError(t, cause, hint=hint)


def unresolved(t: float, off: float) -> SimulationError:
    """Return the error of a step past a singular pose that differs from its two halves."""
    cause = (
        f"the step is too coarse for the singular position near here: in two halves it comes out {100.0 * off:.0f} % "
        "off, and branches of the motion cross there"
    )
    return SimulationError(t, cause, hint=SMALLER)


def left_open(
    t: float, where: str, by: float, passes: int, *, projection: ProjectionSettings, failed: bool
) -> SimulationError:
    """Return the error of a joint that is open by so much (m, rad) that it will not close again. `failed`: whether a
    projection has just failed."""
    if failed:
        cause = f"the projection did not close it: {by:.3g} is left after {passes} passes"
        more = "; where masses differ widely, --projection-fallback gopm may help"
        closes = projection.method == "gopm" or projection.fallback == "gopm"
        return SimulationError(t, cause, where=where, hint=SMALLER if closes else SMALLER + more)
    cause = f"it has drifted open by {by:.3g} (m, rad), and what follows would mean nothing"
    if not PROJECTIONS[projection.method].corrects:
        hint = "use a projection method, gpopm for example, or a smaller step"
    elif projection.position and projection.every == 1 and projection.threshold is None:
        hint = SMALLER
        cause = (
            "its bodies have run away: so far out, round-off of their coordinates leaves it open by "
            f"{by:.3g} (m, rad) after its projection"
        )
    else:
        hint = "project positions after every step, or take a smaller step"
    return SimulationError(t, cause, where=where, hint=hint)


def locked(t: float, motion: str, at: str) -> SimulationError:
    """Return the error of a motion that drives the mechanism beyond where it can go; `at`, as "A.angle = 0.3 rad", is
    about where it is."""
    cause = f"it drives the mechanism to where its joints cannot stay closed: beyond about {at} there is no pose for it"
    hint = "end the motion or turn back before, or change the lengths"
    return SimulationError(t, cause, where=f"motion '{motion}'", hint=hint)


class TurnsUntold(SimulationError):
    """The error of a step too long to count the turns of a joint's angle `where` ("A.angle"). The teeth of gears and
    the threads of screws are then unknown, too.

    The rates turn it by `turned` rad in the step, and the pose differs from this by `off` rad (0: no pose closes). A
    step of `step` (s) would be short enough."""

    def __init__(self, t: float, where: str, turned: float, off: float, step: float, *, teeth: bool) -> None:
        self.step = step
        untold = "its turns, and so which teeth or threads are in mesh" if teeth else "its turns"
        result = f"comes out {off:.2g} rad from there" if off else "does not close there"
        cause = f"the step is too long to tell {untold}: the rates lead {turned:.3g} rad further, and the pose {result}"
        hint = f"use steps of at most {_rounded_down(step):g} s, or an integrator with error control"
        super().__init__(t, cause, where=where, hint=hint)


def _rounded_down(value: float) -> float:
    """Return a value rounded down to two digits."""
    digit = 10.0 ** (floor(log10(value)) - 1)
    return floor(value / digit) * digit


def unsolved_stage(t: float, system: System, body: int, force: int, *, is_near: bool) -> SimulationError:
    """Return the error of an implicit step that Newton's method has not solved. The cause is a force, by its number
    among the coordinates of forces, or for -1 a body. `is_near`: whether a singular pose is near."""
    cause = f"{UNSOLVED}: branches of the motion cross near here (a singular position)" if is_near else UNSOLVED
    return SimulationError(t, cause, where=unsolved_owner(system, body, force), hint=LOOSER)


def unsolved_owner(system: System, body: int, force: int) -> str:
    """Return the owner in words: a force, by its number among the coordinates of forces, then a state; a body for
    -1."""
    owners = system.forces.owners
    if force >= len(owners):
        return f"state '{system.names.states[force - len(owners)]}'"
    if force >= 0:
        return f"force '{owners[force]}'"
    return f"body '{system.names.carriers[body]}'"


def halved_in_vain(unsolved: SimulationError, h: float) -> SimulationError:
    """Return the error of a fixed step that stays unsolved in parts as short as `h` (s)."""
    cause = f"{unsolved.cause}; nor did it those of its parts, down to {h:.2g} s"
    hint = "look there for a law that jumps, or grows without bound, and smooth it; or try --integrator dop853"
    return SimulationError(unsolved.time, cause, where=unsolved.where, hint=hint)


def no_unique_sliding(t: float, where: str, hint: str = "") -> SimulationError:
    """Return the error of friction so strong, compared with the load of its joint, that sliding has no solution, or
    two."""
    cause = (
        "nothing sticks here, and sliding has no solution or two: friction increases its own load too much "
        "(Painlevé's paradox)"
    )
    hint = hint or "use a smaller 'coefficient', a longer bearing, or push nearer to it"
    return SimulationError(t, cause, where=where, hint=hint)


def jammed(t: float, system: System, bearing: int) -> SimulationError:
    """Return the error of friction at a bearing for which sliding has no unique solution."""
    return jammed_law(t, system, int(np.flatnonzero(system.forces.laws.bearing == bearing)[0]))


def jammed_law(t: float, system: System, law: int) -> SimulationError:
    """Return the error of a friction law for which sliding has no unique solution; it depends on a bearing, or on the
    push of a stop."""
    friction, bearing = f"friction '{system.forces.law_owners[law]}'", int(system.forces.laws.bearing[law])
    if bearing < 0 or system.bearings is None or system.bearings.is_push[bearing]:
        return no_unique_sliding(t, friction, "use a smaller 'coefficient', or another place of the point")
    return no_unique_sliding(t, f"{friction} of joint '{system.names.joints[int(system.bearings.joint[bearing])]}'")


def off_rope(t: float, system: System, coordinate: int, circle: int, span: int) -> SimulationError:
    """Return the error of a rope, by its coordinate, that leaves a circle of its path, or whose span has vanished. Both
    count from 0; the other one is -1."""
    name = system.names.coordinates[coordinate].partition(".")[0]
    where, place = f"rope '{name}'", span + 1
    if circle >= 0:
        cause = f"it leaves its place {circle + 1}: the rope no longer lies on that sheave, wheel or drum"
        return SimulationError(t, cause, where=where, hint="end the run before, or give a path without that place")
    cause = f"its places {place} and {place + 1} overlap, or the line between them has turned by half a turn"
    return SimulationError(t, cause, where=where, hint="end the run before, or move the places apart")


def overlap(t: float, joint: str) -> SimulationError:
    """Return the error of a joint whose two curves overlap away from their point of contact."""
    cause = "its curves overlap away from where they touch: another pair of places has met, as a next tooth does"
    hint = "end the run before; give the parts of the outlines that touch, as one flank of a tooth each"
    return SimulationError(t, cause, where=f"joint '{joint}'", hint=hint)


def drawn_into(t: float, system: System, coordinate: int, span: int) -> SimulationError:
    """Return the error of a rope, by its coordinate, that is so short that one of its parts, counted from 0, has
    vanished."""
    name = system.names.coordinates[coordinate].partition(".")[0]
    cause = f"its part between places {span + 1} and {span + 2} is gone: what hangs there was drawn in"
    hint = "end the run before, or keep them apart: by a longer rope, or a stop"
    return SimulationError(t, cause, where=f"rope '{name}'", hint=hint)


def of_a_rope(system: System, state: State, h: float, failure: SimulationError) -> SimulationError:
    """Return the error of a run that cannot go on from a state, with steps of h s: that of the rope which has caused
    it, or `failure`."""
    from mbproj.equations.curve_checks import drawn_in

    gone = drawn_in(system, state.q, state.v, max(h, failure.time - state.t))
    return failure if gone is None else drawn_into(failure.time, system, gone.coordinate, gone.span)


def pushed_back(t: float, where: str, what: str, *, jumps: bool) -> SimulationError:
    """Return the error of a motion that leads back onto a law's edge from both sides. Where the law `jumps`, no branch
    holds."""
    if jumps:
        cause = (
            f"the motion leads back onto the edge of {what} from both sides, and neither holds: this is dry friction "
            "that sticks, which no function can hold"
        )
        hint = "on a joint write type: friction with 'coulomb', which sticks; or 'tanh(x/width)' in place of 'sign(x)'"
        return SimulationError(t, cause, where=where, hint=hint)
    cause = (
        f"the motion crosses the edge of {what} again and again: the force has no jump there, but is so steep that "
        "explicit steps go from one side to the other"
    )
    hint = f"{' and '.join(implicit_integrators())} take long steps where forces are stiff; or use a softer force"
    return SimulationError(t, cause, where=where, hint=hint)


def step_vanished(t: float) -> SimulationError:
    """Return the error of error control that asks for steps shorter than the resolution of time."""
    cause = "the error cannot be kept below the tolerance: the step has shrunk to nothing"
    return SimulationError(t, cause, hint="loosen the tolerance")


# --- Explains why a run has stopped where it cannot go on -------------------------------------------------------------
# Lock-up: its motions drive the mechanism to where it cannot go. Examples are a rod too short for the turn of its
# crank, or a slider pulled further than its links reach. Only a motion leads there: a free mechanism turns back
# before.
# Lost mass: its motion loses all inertia, as for a massless crank and rod at their dead centre, where the slider
# stands. Its speed then grows beyond all bounds.


#: Changes of motions in rad and parts of the mechanism's length, by which it is moved beyond the point where the run
#: stopped.
FURTHER = (1e-3, 1e-2, 1e-1)


def explained(
    error: SimulationError, system: System, start: Array, reached: Callable[[], tuple[float, Array]]
) -> SimulationError:
    """Return an error that names the motion which has led to the `error` of a run; the error itself where none has.

    The mechanism has lost mass where a motion has inertia at the `start` (7n,), and hardly any near the last sample.
    `reached` returns that sample's time and q (7n,)."""
    if system.bodies > THRESHOLDS.large or (error.where or "").startswith("rope '"):
        return error  # a rope is the cause itself
    error_explained = _lock_up(system, *reached(), error.time) if system.driven else None
    massless = not np.all(np.linalg.det(system.inertia) * system.mass)
    if error_explained is not None or not massless or isinstance(error.__cause__, SimulationError):
        return error_explained or error
    lost = _lost(system, start, *reached())
    if lost is None:
        return error
    cause = f"near here a motion moves no mass, so that its speed grows beyond all bounds: {lost}"
    hint = "give the bodies that move mass and inertia"
    return SimulationError(error.time, cause, where=error.where, hint=hint)


def _lock_up(system: System, t: float, q: Array, stop: float) -> SimulationError | None:
    """Return the error where the poses that meet the motions end on the way from q at time t to beyond `stop`; None
    where they do not."""
    from mbproj.equations.rank.row_space import NO_CONDITIONS

    try:
        at, drive = drive_at(system, t), drive_at(system, stop)
        for time in _way(system, t, stop, drive):
            before, at = at, drive_at(system, time)
            if np.abs((at.value - before.value) / _units(system)).max() > 4.0 * THRESHOLDS.short_way:
                return None
            q, residual = nearest(system, q, NO_CONDITIONS, at, THRESHOLDS.rounding)
            if np.abs(residual).max(initial=0.0) > THRESHOLDS.same_pose:
                return _locked(system, stop, drive, residual[system.joints.size :])
            drive = at if time > stop else drive
    except (SimulationError, np.linalg.LinAlgError):  # a motion may have no value there
        pass
    return None


def _way(system: System, t: float, stop: float, drive: Drive) -> list[float]:
    """Return times from t to `stop` and beyond; none where it is too far, or the motions stand still."""
    fastest = float(np.abs(drive.rate / _units(system)).max())
    steps = np.ceil(fastest * (stop - t) / THRESHOLDS.short_way)
    if not fastest > 0.0 or not steps <= THRESHOLDS.most_passes:
        return []
    return [*np.linspace(t, stop, int(steps) + 1).tolist(), *(stop + part / fastest for part in FURTHER)]


def _units(system: System) -> Array:
    """Return 1 rad, or the mechanism's length, for each motion, (k,)."""
    return system.row_scale[-system.driven :]


def _locked(system: System, t: float, drive: Drive, missed: Array) -> SimulationError:
    """Return the error of the motion whose own row has the largest violation in `missed` (k,)."""
    worst = int(np.argmax(np.abs(missed)))
    coordinate = int(system.motions.joint_coordinate[worst])
    name, unit = system.names.coordinates[coordinate], system.names.coordinate_units[coordinate]
    return locked(t, system.names.motions[worst], f"{name} = {drive.value[worst]:.3g} {unit}")


def _lost(system: System, start: Array, t: float, q: Array) -> str | None:
    """Return in words the motion of least inertia, followed both ways from q to where it has next to none; None without
    one."""
    drive, motion = drive_at(system, t), least_inertia(system, pose_of(start))
    if motion is None:
        return None
    ways = (_followed(system, drive, q, way, THRESHOLDS.rounded * motion.inertia) for way in (1.0, -1.0))
    return next((name for name in ways if name is not None), None)


def _followed(system: System, drive: Drive, q: Array, way: float, enough: float) -> str | None:
    """Return in words the motion followed one way, in steps of half of the rest: the root of the inertia falls linearly
    towards a dead centre."""
    from mbproj.equations.rank.row_space import NO_CONDITIONS

    shortest, longest = THRESHOLDS.short_way / 5.0, 10.0 * THRESHOLDS.short_way
    before, last, step = None, 0.0, shortest
    for _ in range(THRESHOLDS.most_passes):
        lightest = least_inertia(system, pose_of(q))
        if lightest is None or lightest.inertia < enough:
            return None if lightest is None else str(lightest)
        size = sqrt(lightest.inertia)
        if size < last:
            step = min(max(0.5 * step * size / (last - size), shortest), longest)
        motion = lightest.motion if before is None or lightest.motion @ before > 0.0 else -lightest.motion
        before, last = motion, size
        q, left = nearest(system, moved(system, q, way * step * motion), NO_CONDITIONS, drive, THRESHOLDS.rounding)
        if np.abs(left).max(initial=0.0) > THRESHOLDS.same_pose:
            return None
    return None


# --- The effect of stiffness on a run, in words, with remedies --------------------------------------------------------


@dataclass(frozen=True)
class Stiffness:
    """The mode that limited the step.

    `where` is its cause ("force 'coil'", "state 'current'"), `omega_h` |hλ| with the `step` h in s. `limit` is the
    largest |hλ| at which the integrator is stable along the `direction` of λ. `growth` is that of an error in a
    step."""

    where: str
    omega_h: float
    limit: float
    growth: float
    step: float
    direction: complex
    integrator: str

    @property
    def what(self) -> str:
        """|hλ|, with the symbol of its kind, and the limit, in words."""
        name = "ω h" if abs(self.direction.imag) > 0.5 else "c h / m"
        on = " on the masses that it moves"
        if not self.is_of_forces:
            name = "|λ| h" if self.is_of_states else "α h"
            on = f" at {self.omega_h / self.step:.3g} 1/s" if self.is_of_states else ""
        return f"{name} = {self.omega_h:.3g}{on}, and {self.integrator} is stable up to {self.limit:.3g}"

    @property
    def is_of_forces(self) -> bool:
        """Whether forces cause the mode."""
        return self.where.startswith("force")

    @property
    def is_of_states(self) -> bool:
        """Whether states of elements cause the mode."""
        return self.where.startswith("state")

    def with_verb(self, one: str, several: str) -> str:
        """Return the cause with its verb, `one` or `several`."""
        return f"{self.where} {several if self.where.startswith(('forces', 'states')) else one}"

    @property
    def grows(self) -> str:
        """The growth of an error in a step, in words."""
        size = (
            f"{self.growth:.3g}-fold"
            if self.growth < THRESHOLDS.spoilt**2
            else f"more than {THRESHOLDS.spoilt**2:.0e}-fold"
        )
        return f"errors grow {size} in each step"

    @property
    def stable_step(self) -> str:
        """The advice of a stable step, with two digits."""
        step = THRESHOLDS.safety * self.limit / self.omega_h * self.step
        unit = 10.0 ** (floor(log10(step)) - 1)
        return f"take steps of {unit * floor(step / unit):.2g} s or less"

    @property
    def remedies(self) -> str:
        """The advice of other methods, or a softer mechanism."""
        softer = "a softer force" if self.is_of_forces else "slower states" if self.is_of_states else "smaller gains"
        limits = {name: reach(tableau_of(name), self.direction) for name in explicit_integrators()}
        best = max(limits, key=lambda name: limits[name])
        larger = f"{best}, which is stable up to {limits[best]:.3g}, or " if limits[best] > 1.2 * self.limit else ""
        implicit = " or ".join(implicit_integrators())
        return f"{larger}{softer}; {implicit} is not held up by it"


def too_stiff(stopped: SimulationError, stiffness: Stiffness) -> SimulationError:
    """Return the error of a run that stopped because a force or a state is too stiff for its step."""
    cause = f"stiff: {stiffness.what}, so that {stiffness.grows} of {stiffness.step:.3g} s"
    return SimulationError(
        stopped.time, cause, where=stiffness.where, hint=f"{stiffness.stable_step}, {stiffness.remedies}"
    )


def grows(stiffness: Stiffness) -> str:
    """Return the note on a run that has ended with errors that grew."""
    return (
        f"{stiffness.with_verb('is', 'are')} too stiff for steps of {stiffness.step:.3g} s: {stiffness.what}, so that "
        f"{stiffness.grows} and the motion is not to be trusted; {stiffness.stable_step}, {stiffness.remedies}"
    )


def holds(stiffness: Stiffness) -> str:
    """Return the note on a run with error control that made small steps for stability alone."""
    return (
        f"{stiffness.with_verb('is stiff and holds', 'are stiff and hold')} the step at "
        f"{stiffness.step:.2g} s for stability alone ({stiffness.what}), "
        f"where accuracy would allow larger ones; quicker would be {stiffness.remedies}"
    )


def damps(stiffness: Stiffness) -> str:
    """Return the note on an implicit run that has damped a vibration which the mechanism itself hardly damps."""
    frequency, lost = stiffness.omega_h / stiffness.step / (2.0 * pi), 100.0 * (1.0 - min(stiffness.growth, 1.0))
    follows = 0.5 * THRESHOLDS.unresolved_vibration * stiffness.step / stiffness.omega_h
    on = " on the masses that it moves" if stiffness.is_of_forces else ""
    where = (
        ". The energy that it loses so is in the energy drift, not in the dissipation" if stiffness.is_of_forces else ""
    )
    return (
        f"{stiffness.with_verb('vibrates', 'vibrate')} with {frequency:.3g} Hz{on}; {stiffness.integrator} damps that "
        f"by {lost:.2g} % in a step of {stiffness.step:.2g} s (ω h = {stiffness.omega_h:.3g}); "
        f"steps of {follows:.2g} s would follow it{where}"
    )
