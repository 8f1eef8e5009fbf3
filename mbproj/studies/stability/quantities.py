"""The quantities that can be varied: how a value changes the scene or its setting, their range, and the methods
concerned.

Baumgarte's gains have a limit: those from which an offset of C grows over 300 steps, and the limit from the tableau.

With α = β the violation obeys C'' + 2αC' + α²C = 0, whose double eigenvalue is -α. A Runge-Kutta method has the
stability function R(z) = 1 + z bᵀ(I - zA)⁻¹1. It keeps the violation bounded while |R(-αh)| <= 1 (Hairer & Wanner 1996,
sect. IV.2).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import constraint_at
from mbproj.dynamics.observe.recorded import Block
from mbproj.errors import InputError, MbprojError, Problem, SimulationError, choose_from
from mbproj.integrate import simulate
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.formulations.planar import InPlane
from mbproj.model import System
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.scene.read import Scene
from mbproj.settings import SETTINGS
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.stability.judge import FAILS, HOLDS, StabilityPoint, Subject, cause_of, judged
from mbproj.studies.variants.livelier import with_damping, with_speed, with_stiffness
from mbproj.studies.variants.ratios import with_inertia_ratio, with_mass_ratio
from mbproj.studies.variants.rescaled import rescaled

#: The number of steps over which |C| is watched, and the initial offset in units of the mechanism's length.
STEPS, OFFSET = 300, 1e-8


def growth(subject: Subject, value: float) -> StabilityPoint:
    """Test whether an offset of C grows with these gains.

    The difference to a run without the offset is watched, because the integrator's error adds to C in both. `closure`
    is this difference after the last step, in lengths or rad."""
    try:
        mechanism = Mechanism.of(subject.scene)
        own, opened = (_violations(subject, each) for each in (mechanism, _shifted(subject, mechanism)))
    except MbprojError as error:
        where, time = (error.where, error.time) if isinstance(error, SimulationError) else (None, 0.0)
        return StabilityPoint(value, FAILS, np.nan, np.nan, time, where, cause_of(error), ended=False)
    first, last = (float(part) for part in np.abs(opened - own).max(axis=1))
    if last <= first:
        return StabilityPoint(value, HOLDS, last, np.nan)
    said = f"an offset has grown from {first:.1e} to {last:.1e}"
    return StabilityPoint(
        value, FAILS, last, np.nan, STEPS * subject.step, _worst(mechanism.system, opened - own), said
    )


def _shifted(subject: Subject, mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with its bodies shifted by random offsets. The offsets stay in the plane where the run is
    planar."""
    state, random = mechanism.state, np.random.default_rng(0)
    shift = np.zeros((mechanism.system.bodies, 7))
    shift[:, :3] = OFFSET * mechanism.system.length * random.choice([-1.0, 1.0], (mechanism.system.bodies, 3))
    run = choose(mechanism.system, state, subject.setting.settings(STEPS * subject.step, subject.step)).compiled
    if isinstance(run, InPlane):
        normal = run.plane.axes[:, 2]
        shift[:, :3] -= np.outer(shift[:, :3] @ normal, normal)
    return replace(mechanism, state=state.changed(positions=state.q + shift.ravel()))


def _violations(subject: Subject, mechanism: Mechanism) -> Array:
    """The violation C of joints and motions at the start and after the last step, (2, m), in the mechanism's length or
    rad."""
    span, kept, system = STEPS * subject.step, list[Block](), mechanism.system

    class Kept:
        def write(self, block: Block) -> None:
            kept.append(block)

    with np.errstate(all="ignore"):
        simulate(system, mechanism.state, mechanism.settings(subject.setting, span, span), Kept())
    times = np.concatenate([block["time"] for block in kept])
    q = np.concatenate([_coordinates(system, block) for block in kept])
    return np.asarray((constraint_at(system, q, times) / system.row_scale)[:, system.bodies :])


def _coordinates(system: System, block: Block) -> Array:
    """The coordinates q (T, 7n) of the carriers, each computed from the first body that is fixed to it."""
    first = [int(np.argmax(system.body_carrier == carrier)) for carrier in range(system.bodies)]
    back = system.body_turn[first] * np.array([1.0, -1.0, -1.0, -1.0])
    orientation = product(block["bodies/orientation"][:, first], back)
    arm = (rotation_matrix(orientation) @ system.body_offset[first][..., None])[..., 0]
    q = np.concatenate([block["bodies/position"][:, first] - arm, orientation], axis=-1)
    return np.asarray(q.reshape(len(q), -1))


def _worst(system: System, offset: Array) -> str:
    """The owner of the row that has grown most."""
    return system.row_owner(system.bodies + int(np.argmax(np.abs(offset[-1]))))


@dataclass(frozen=True)
class ValueSpan:
    """The range in which a quantity is varied, and its value in the scene itself."""

    low: float
    own: float
    high: float


@dataclass(frozen=True)
class VariedQuantity:
    """A quantity that can be varied. `option` is the option that a projection method must have for it ("gains",
    "alpha"), or "". `run` judges a subject at a value.

    `of_forces`: the quantity makes forces stiff, so an implicit method is tried too. `of_motion`: the quantity changes
    the mechanism itself, so small motions are judged too."""

    unit: str
    summary: str
    span: Callable[[Subject], ValueSpan]
    changed: Callable[[Subject, float], Subject]
    option: str = ""
    run: Callable[[Subject, float], StabilityPoint] = judged
    of_forces: bool = False
    of_motion: bool = False


def _factor(
    low: float,
    high: float,
    change: Callable[[Scene, float], Scene],
    summary: str,
    *,
    applies_to_all: bool = False,
    of_forces: bool = False,
) -> VariedQuantity:
    """A factor that is 1 in the scene itself. `change` raises InputError for scenes to which it does not apply."""

    def span(subject: Subject) -> ValueSpan:
        if not applies_to_all:
            change(subject.scene, 1.0)
        return ValueSpan(low, 1.0, high)

    def changed(subject: Subject, value: float) -> Subject:
        return replace(subject, scene=change(subject.scene, value))

    return VariedQuantity("", summary, span, changed, of_forces=of_forces)


def _steps(subject: Subject) -> ValueSpan:
    return ValueSpan(subject.step / 8.0, subject.step, min(64.0 * subject.step, subject.until))


def _of_setting(changes: Callable[[float], dict[str, Any]]) -> Callable[[Subject, float], Subject]:
    return lambda subject, value: replace(subject, setting=replace(subject.setting, **changes(value)))


def _gains(subject: Subject) -> ValueSpan:
    if not (subject.scene.joints or subject.scene.motions):
        said = "the scene has no joints for Baumgarte's terms to close"
        raise InputError(Problem(said, hint="vary something else, 'step' for example"))
    own = subject.setting.gains or SETTINGS["gains"].where_taken
    return ValueSpan(0.05 / subject.step, own[0], 20.0 / subject.step)


#: Every quantity by name. A new one is an entry here, and the function in `mbproj.studies.variants` that applies it.
QUANTITIES: Mapping[str, VariedQuantity] = MappingProxyType(
    {
        "step": VariedQuantity("s", "the integrator's fixed step", _steps, _of_setting(lambda h: {"step": h})),
        "mass-ratio": _factor(
            1e-12,
            1e12,
            with_mass_ratio,
            "every second body, counted from the ground along the joints, √r times as heavy, the others 1/√r times",
        ),
        "inertia-ratio": _factor(1e-12, 1e12, with_inertia_ratio, "as `mass-ratio`, of the moments of inertia alone"),
        "speed": _factor(1e-3, 1e3, with_speed, "a factor on the velocities of the start and the speed of all motions"),
        "length-scale": _factor(
            1e-6,
            1e6,
            rescaled,
            "a factor on lengths, velocities and gravity: the same motion in another unit of length",
            applies_to_all=True,
        ),
        "stiffness": _factor(1e-6, 1e6, with_stiffness, "a factor on the stiffness of all springs", of_forces=True),
        "damping": _factor(1e-6, 1e6, with_damping, "a factor on the damping of all dampers", of_forces=True),
        "baumgarte-gain": VariedQuantity(
            "1/s",
            "Baumgarte's gains α = β: whether |C| grows over 300 steps from an offset of 1e-8",
            _gains,
            _of_setting(lambda gain: {"gains": (gain, gain)}),
            "gains",
            growth,
        ),
        "penalty": VariedQuantity(
            "",
            "the penalty α of mass-orthogonal and mmopm",
            lambda subject: ValueSpan(1.0, subject.setting.alpha or SETTINGS["alpha"].where_taken, 1e16),
            _of_setting(lambda alpha: {"alpha": alpha}),
            "alpha",
        ),
        "duration": VariedQuantity(
            "s",
            "how long the run is",
            lambda subject: ValueSpan(subject.until / 10.0, subject.until, 100.0 * subject.until),
            lambda subject, until: replace(subject, until=until),
        ),
    }
)


#: The prefix that names a parameter of the scene.
PARAMETER = "parameters."


def _of_parameter(name: str) -> VariedQuantity:
    """A parameter of the scene, varied from a tenth of its value to ten times its value."""

    def span(subject: Subject) -> ValueSpan:
        known = subject.scene.parameters
        if name not in known:
            hint = choose_from(name, known, "parameters are") if known else "name a number: `parameters: {T: 20 ms}`"
            raise InputError(Problem(f"the scene has no parameter '{name}'", hint=hint))
        own = known[name]
        if not own > 0.0:
            said = f"parameter '{name}' is {own:.6g}, and values are varied by their logarithms"
            raise InputError(Problem(said, hint="let a positive parameter be a factor of it"))
        return ValueSpan(0.1 * own, own, 10.0 * own)

    def changed(subject: Subject, value: float) -> Subject:
        return replace(subject, scene=subject.scene.with_({name: value}))

    return VariedQuantity("", f"the scene's parameter {name}", span, changed, of_motion=True)


def quantity_named(name: str) -> VariedQuantity:
    """The quantity with this name in `QUANTITIES`, or the parameter of the scene: `parameters.T`. Raises InputError for
    an unknown name."""
    if name.startswith(PARAMETER):
        return _of_parameter(name.removeprefix(PARAMETER))
    if name not in QUANTITIES:
        raise InputError(
            Problem(f"unknown quantity '{name}'", hint=choose_from(name, [*QUANTITIES, f"{PARAMETER}NAME"]))
        )
    return QUANTITIES[name]
