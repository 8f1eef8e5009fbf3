"""The quantities that can be varied: how a value changes the scene or its setting, their range, and the methods
concerned."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.scene.records import Scene
from mbproj.scene.text.suggestions import choose_from
from mbproj.studies.stability.gains import growth
from mbproj.studies.stability.judge import StabilityPoint, Subject, judged
from mbproj.studies.variants.livelier import with_damping, with_speed, with_stiffness
from mbproj.studies.variants.ratios import with_inertia_ratio, with_mass_ratio
from mbproj.studies.variants.rescaled import rescaled


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
    return ValueSpan(0.05 / subject.step, 1.0 / subject.step, 20.0 / subject.step)


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
            lambda subject: ValueSpan(1.0, subject.setting.alpha or 1e7, 1e16),
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
