"""The choice of a run's coordinates, and its reason: planar or reduced ones in the kernel, or the full ones in
NumPy.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.registry import PROJECTIONS, is_explicit
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.kinematics import pose_of
from mbproj.kernel import build_info, core
from mbproj.kernel.models import without_form
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import NotPlanar, obstacle_in_plane, planar_reduction
from mbproj.model.system import System
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.reduced import InPlane, Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows
from mbproj.motion.steppers.tableau import QUADRATURE
from mbproj.scene.sampling import output_interval

#: The reason for a formulation that the settings name.
AS_ASKED = "as asked for"


@dataclass(frozen=True, eq=False)
class Choice:
    """The chosen formulation by name, the reason for it, and its degrees of freedom.

    `compiled` runs it in the kernel's loop; None for explicit steps of the full formulation, in NumPy. `redundant`: the
    number of rows that are left out because they follow from the others. `kinematic`: whether joints and motions alone
    determine the motion, so that it is not integrated."""

    name: str
    why: str
    degrees_of_freedom: int
    compiled: Compiled | None = None
    redundant: int = 0
    kinematic: bool = False

    @property
    def elimination(self) -> dict[str, int] | None:
        """Counts of the kernel's elimination: bodies from the leaves, bodies and joints of the loops, numbers and fill
        of their factor; None for the full formulation."""
        return None if self.compiled is None or self.name == "full" else dict(self.compiled.equations().topology)

    def responses(self, system: System, state: State, laws: Integers) -> Array | None:
        """Return the accelerations along the coordinates of these laws by unit forces, (e, e), joints closed; None
        where they are not unique."""
        if self.compiled is not None:
            return self.compiled.responses(state, laws)
        from mbproj.equations.fast_modes import responses

        try:
            return responses(system, pose_of(state.q), laws)
        except np.linalg.LinAlgError:
            return None


def choose(system: System, state: State, settings: Settings, kernel: Any = None) -> Choice:
    """Return the formulation for a run from `state`.

    Raises InputError where the requested one is not available, or the equations have no unique solution at the start.
    It is raised, too, where a motion jumps or goes beyond a rigid stop, and for a kinematic run with degrees of
    freedom. `kernel` makes the models; None: the compiled core."""
    choice = _formulation(system, state, settings, kernel)
    if choice.degrees_of_freedom == 0:
        _refuse_locked(system, state)
    rolls = choice.degrees_of_freedom == 0
    is_kinematic = _is_kinematic(_undecided(system, state, choice), settings, rolls=rolls)
    choice = replace(choice, kinematic=is_kinematic)
    if choice.compiled is not None:
        return choice
    used = replace(settings, projection=ProjectionSettings(), acceleration="bordered")
    if choice.kinematic and settings.formulation == "auto" and used != settings:  # a kinematic run uses none of these
        return choose(system, state, used, kernel)
    _refuse_beyond_numpy(choice, settings, kernel or core())
    return choice


def refuse_without_steps(choice: Choice, settings: Settings) -> None:
    """Raise InputError where a run has to be integrated, and neither a step nor a tolerance says how finely."""
    if not choice.kinematic and settings.step is None and settings.tolerance is None:
        hint = "add one of them to 'simulation', or --step or --tolerance"
        raise InputError(Problem("the scene has neither step nor tolerance", key=("simulation",), hint=hint))


def _refuse_beyond_numpy(choice: Choice, settings: Settings, kernel: Any) -> None:
    """Raise InputError for a run in NumPy's loop that asks for kinematic steps, or for rows of energy and momentum."""
    projection = settings.projection
    keeps = PROJECTIONS[projection.method].corrects and (projection.energy or projection.momentum)
    if not (choice.kinematic or keeps):
        return
    what = "kinematic steps" if choice.kinematic else "rows of energy and momentum"
    if kernel is None:
        raise InputError(Problem(f"{what} need the kernel", hint="install a C++ compiler, or a wheel"))
    why = "" if choice.why == AS_ASKED else f", and {choice.why}"
    hint = "use reduced" + (", which takes gpopm and bordered accelerations" if why else ": 'formulation: reduced'")
    hint += "; or integrate the motion, with 'kinematic: false'" if choice.kinematic else ""
    key = ("simulation", "formulation")
    raise InputError(Problem(f"the full formulation has no {what}{why}", key=key, hint=hint))


def _is_kinematic(degrees_of_freedom: int, settings: Settings, *, rolls: bool) -> bool:
    """Return whether a run is kinematic. Raises InputError where that is asked for and the mechanism has degrees of
    freedom; with `rolls`, of the pose alone."""
    if settings.kinematic is True and degrees_of_freedom > 0:
        if rolls:
            freedoms = f"{degrees_of_freedom} freedom{'s' if degrees_of_freedom > 1 else ''} of the pose"
            message = f"rolling bodies and edges leave {freedoms}: it has to be integrated"
            raise InputError(Problem(message, key=("simulation", "kinematic"), hint="leave out 'kinematic'"))
        count = f"{degrees_of_freedom} degree{'s' if degrees_of_freedom > 1 else ''} of freedom"
        message = f"the mechanism has {count}: a kinematic run needs 0"
        hint = f"drive {degrees_of_freedom} more of its coordinates by 'motions', or leave out 'kinematic'"
        raise InputError(Problem(message, key=("simulation", "kinematic"), hint=hint))
    return degrees_of_freedom == 0 and settings.kinematic is not False


def _undecided(system: System, state: State, choice: Choice) -> int:
    """Return the degrees of freedom of poses with joints and motions: with rolling more than those of velocities."""
    if not system.rolls:
        return choice.degrees_of_freedom
    from mbproj.equations.rank.mobility import mobility

    return mobility(system, pose_of(state.q)).positions


def _formulation(system: System, state: State, settings: Settings, kernel: Any) -> Choice:
    """Return the choice without the decision on a kinematic run."""
    if system.driven:
        from mbproj.equations.assembly.assemble import refuse_jumps
        from mbproj.equations.contacts import refuse_driven_beyond

        refuse_jumps(system, state.t, state.t + (settings.duration or 0.0))
        refuse_driven_beyond(system, state.t, state.t + (settings.duration or 0.0))
    asked = settings.formulation
    obstacle = None if asked == "full" else obstacle_to_kernel(system, settings)
    if asked == "full" or obstacle is not None:
        if asked in ("reduced", "planar"):
            message = f"the {asked} formulation is not available here: {obstacle}"
            raise InputError(Problem(message, key=("simulation", "formulation")))
        if asked == "auto" and obstacle == _no_kernel():
            from mbproj.kernel import warn_of_absence

            warn_of_absence(str(build_info()))
        return _full(system, state, settings, obstacle or AS_ASKED, kernel or core())
    plane = (
        NotPlanar("") if asked == "reduced" else system.cached("plane", (state.q,), partial(_plane, system, state.q))
    )
    if isinstance(plane, NotPlanar):
        if asked == "planar":
            raise InputError(Problem(f"the scene is not planar: {plane.reason}", key=("simulation", "formulation")))
        why = f"not planar: {plane.reason}" if plane.reason else AS_ASKED
        return _solvable(Reduced(kernel or core(), system), system, state, settings, why)
    normal = ", ".join(f"{component + 0.0:.3g}" for component in plane.axes[:, 2])
    why = f"the joints keep every body in the plane normal to [{normal}]"
    return _solvable(InPlane(kernel or core(), system, plane), system, state, settings, why)


def _plane(system: System, q: Array) -> Plane | NotPlanar:
    """Return the plane of joints, forces and motions at a pose, or the reason against it."""
    plane = planar_reduction(system, q)
    if not isinstance(plane, Plane):
        return plane
    obstacle = obstacle_in_plane(system, plane)
    return plane if obstacle is None else NotPlanar(obstacle)


def obstacle_to_kernel(system: System, settings: Settings) -> str | None:
    """Return the reason for which the kernel cannot run this; None where it can."""
    method = settings.projection.method
    if not PROJECTIONS[method].compiled:
        return f"the projection '{method}' exists in the full formulation only"
    if settings.acceleration != "bordered":
        return f"'acceleration: {settings.acceleration}' exists in the full formulation only"
    if core() is None:
        return _no_kernel()
    missing = without_form(system)
    return None if missing is None else f"the primitive '{missing}' exists in the full formulation only"


def _no_kernel() -> str:
    return f"the compiled kernel is missing ({build_info()})"


def _full(system: System, state: State, settings: Settings, why: str, kernel: Any) -> Choice:
    from mbproj.equations.rank.mobility import mobility, refuse_unsolvable
    from mbproj.equations.rank.redundancy import redundancy

    ranks = mobility(system, pose_of(state.q))
    if not ranks.redundant or ranks.massless or ranks.locked or not redundancy(system, state).is_constant:
        refuse_unsolvable(system, ranks)
    redundant = ranks.constraints - ranks.rank
    choice, needs = Choice("full", why, ranks.degrees_of_freedom, redundant=redundant), _needs(system, settings)
    if needs is None:
        return choice
    if kernel is None:
        raise InputError(Problem(f"{needs} need the kernel", hint="install a C++ compiler, or a wheel"))
    if missing := without_form(system):
        message = f"{needs} need the kernel, which has no primitive '{missing}'"
        raise InputError(Problem(message, hint="take joints without it, or add it: mbproj help contributing"))
    name = settings.projection.method
    if not (is_explicit(settings.integrator) or PROJECTIONS[name].corrects or PROJECTIONS[name].compiled):
        message = f"the kernel, which makes implicit steps, does not know the stabilisation of the plug-in '{name}'"
        raise InputError(Problem(message, key=("simulation", "integrator"), hint="take an explicit integrator"))
    from mbproj.motion.formulations.full_in_loop import FullInLoop

    compiled = FullInLoop(kernel, system, system, redundant)
    settle_rows(compiled, state)
    return replace(choice, compiled=compiled)


def _needs(system: System, settings: Settings) -> str | None:
    """Return the feature of a run, in words, that only the kernel's loop supports; None where NumPy's loop supports
    all."""
    if system.has_contacts:
        return "stops and dry friction"
    from mbproj.motion.law_switches import switches_of

    if switches_of(system) is not None:
        return "events at which a function of the state has a kink or a jump"
    return None if is_explicit(settings.integrator) else "implicit steps"


class _Rows(NamedTuple):
    """The rows of a run that are held at most poses, as the kernel's class; the number of redundant ones, None where it
    is not constant; and the result of `Compiled.is_regular` at the start."""

    usual: Any
    redundant: int | None
    is_regular: bool
    singular_joint: int


def _rows(compiled: Compiled, state: State, projection: ProjectionSettings) -> _Rows:
    """Return the rows of a run from this state."""
    redundant = settle_rows(compiled, state, projection)
    return _Rows(compiled.model.rows, redundant, *compiled.is_regular(state))


def _solvable(compiled: Compiled, system: System, state: State, settings: Settings, why: str) -> Choice:
    """Return the choice, with redundant rows left out, unless the equations have no unique solution at the start."""
    _refuse_massless(system, state, settings)
    inputs = (compiled.core, compiled.plane, state.t, state.y, settings.projection)
    at_start = system.cached("rows", inputs, partial(_rows, compiled, state, settings.projection))
    redundant, regular, number = at_start.redundant, at_start.is_regular, at_start.singular_joint
    compiled.settled = settings.projection
    compiled.hold(at_start.usual)
    if regular and redundant is not None:
        return Choice(compiled.name, why, compiled.degrees_of_freedom, compiled, redundant or 0)
    from mbproj.equations.rank.mobility import mobility, refuse_unsolvable

    if system.bodies <= THRESHOLDS.large:
        _refuse_locked(system, state)
        refuse_unsolvable(system, mobility(system, pose_of(state.q)))
    owner = compiled.owner(number) or "the mechanism"
    if (
        compiled.name == "reduced"
        and settings.formulation == "auto"
        and not regular
        and system.bodies <= THRESHOLDS.large
    ):
        return _full(system, state, settings, f"the start is near to a singular pose ({owner})", compiled.core)
    joint = compiled.joint(number) if number >= 0 else len(system.joint_places)
    place = system.joint_places[joint] if joint < len(system.joint_places) else None
    raise InputError(
        Problem(
            f"{owner}: the start is a singular pose, or so near to one that its constraints cannot be told apart",
            place,
            "start from a pose that is not stretched or folded; drive no coordinate that the others fix already",
        )
    )


def _refuse_locked(system: System, state: State) -> None:
    """Raise InputError where the joints leave no freedom but for a distance that rounded numbers make, within which
    runs look for redundant rows. Without motions such a mechanism would stay as it is, without a word."""
    from mbproj.equations.assembly.compiled import needed, rounded_up
    from mbproj.equations.rank.mobility import mobility
    from mbproj.equations.rank.redundancy import conditioning

    pose = pose_of(state.q)
    if system.driven or system.bodies > THRESHOLDS.large or mobility(system, pose).degrees_of_freedom:
        return
    condition = conditioning(system, pose)
    if condition.distance is None or condition.distance**2 >= THRESHOLDS.half_digits:
        return
    size = needed(system, state.q)
    places = dict(zip(system.names.joints, system.joint_places, strict=True))
    raise InputError(
        Problem(
            f"the joints lock: they leave no freedom, but would leave one if the rows of {condition.owner} were "
            f"changed by {condition.distance:.2g}",
            next((place for name, place in places.items() if condition.owner == f"joint '{name}'"), None),
            "look whether an axis of the loop is tilted, or numbers are rounded"
            + (f", or give adjust_joints: {rounded_up(size)}" if size else ""),
        )
    )


def _massless(system: System) -> Integers:
    """Return the numbers of the bodies without mass, or without inertia about some axis."""
    smallest = np.linalg.eigvalsh(system.inertia)[:, 0] / np.linalg.norm(system.inertia, axis=(1, 2)).clip(1e-300)
    return np.flatnonzero((system.mass <= 0.0) | (smallest < THRESHOLDS.no_digits))


def _refuse_massless(system: System, state: State, settings: Settings) -> None:
    """Raise InputError where bodies without mass, or without inertia about some axis, are free to move (Eq. 20), or
    where the method weighs corrections with M alone."""
    light = system.cached("massless", (), partial(_massless, system))
    if not len(light):
        return
    if settings.projection.method == "popm":
        name = system.names.carriers[light[0]]
        raise InputError(
            Problem(
                f"popm needs a definite mass matrix, and body '{name}' has no definite mass and inertia",
                hint="use gpopm, which does not",
            )
        )
    from mbproj.equations.rank.mobility import mobility, refuse_unsolvable

    ranks = mobility(system, pose_of(state.q))
    if ranks.massless:
        refuse_unsolvable(system, ranks)


# --- Kinematic runs ---------------------------------------------------------------------------------------------------
# Without degrees of freedom joints and motions determine all poses, and nothing is integrated.


#: Words for the settings of the scene that a kinematic run does not use.
UNUSED = "each sample is closed by Newton's method; the scene's integrator, step, tolerance and projection are not used"


def settings_along(system: System, settings: Settings) -> Settings:
    """Return the settings that a kinematic run uses in place of the scene's.

    Positions and velocities are closed at each stage and sample by Newton's method. States of elements are integrated
    by the scene's integrator, whose implicit steps close their predictions. Without states a quadrature of high order
    integrates the work. Raises InputError where states need a step or tolerance and the scene has none."""
    closed = replace(settings, projection=ProjectionSettings(), kinematic=True)
    if not system.states.size:
        interval = output_interval(settings)
        return replace(closed, integrator=QUADRATURE, step=None, tolerance=THRESHOLDS.half_digits, output_step=interval)
    if settings.step is None and settings.tolerance is None:
        message = "states of elements are integrated along the motion: that needs a step or a tolerance"
        raise InputError(Problem(message, key=("simulation",), hint="add 'tolerance' to 'simulation'"))
    return closed


def kinematic_description(system: System, settings: Settings) -> str:
    """Return, for the summary, the description of a kinematic run with these settings of the scene."""
    if not system.states.size:
        return UNUSED
    how = "explicit steps" if is_explicit(settings.integrator) else "implicit steps"
    size = f"step {settings.step:g} s" if settings.step is not None else f"tolerance {settings.tolerance:g}"
    return f"positions are closed by Newton's method; {how} of {settings.integrator}, {size}, integrate the states"
