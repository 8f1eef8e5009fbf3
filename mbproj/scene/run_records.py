"""The settings of a run, and the expectations that its results have to meet, as frozen records."""

from __future__ import annotations

from dataclasses import field
from typing import NamedTuple

from mbproj.dataclass import dataclass
from mbproj.registry import USUAL_IMPACT_LAW


@dataclass(frozen=True)
class ProjectionSettings:
    """How the constraints are enforced. `tolerance` None is max(1e-13, 4 ε × the largest coordinate) for the test
    "violation", and 1e-12 for the test "paper". A correction is made every `every` steps, with a `threshold` only
    where the violation exceeds it. `alpha` and `gains` are None where the method has no such option. With `energy` or
    `momentum` the velocity correction keeps the energy balance or the momenta, too."""

    method: str = "gpopm"
    tolerance: float | None = None
    test: str = "violation"
    every: int = 1
    threshold: float | None = None
    position: bool = True
    velocity: bool = True
    max_iterations: int = 25
    alpha: float | None = None
    gains: tuple[float, float] | None = None
    fallback: str = "none"
    energy: bool = False
    momentum: bool = False


@dataclass(frozen=True)
class Settings:
    """The `simulation` block with defaults resolved. Exactly one of `step` and `tolerance` is set in a run; `duration`
    and both may be None in a scene that leaves them to the command line. Steps end at `break_times` (s) too. `start` is
    one of `registry.STARTS`. Joints may move by `adjust_joints` (m) where loops of rounded numbers do not close.
    `kinematic`: with None, a mechanism without degrees of freedom is not integrated; with False it is. True refuses
    mechanisms with degrees of freedom."""

    duration: float | None = None
    step: float | None = None
    tolerance: float | None = None
    integrator: str = "rk4"
    formulation: str = "auto"
    acceleration: str = "bordered"
    impact_law: str = USUAL_IMPACT_LAW
    output_step: float | None = None
    break_times: tuple[float, ...] = ()
    start: str = "scene"
    adjust_joints: float | None = None
    kinematic: bool | None = None
    projection: ProjectionSettings = field(default_factory=ProjectionSettings)


class Passage(NamedTuple):
    """The first time at which a joint coordinate ("crank.angle") has a value in its `unit`; angles modulo a turn."""

    coordinate: str
    value: float
    unit: str


@dataclass(frozen=True)
class Expectation:
    """A result that a run has to give: a `value` within `tolerance`, or at most `below`, or at least `above`. `source`
    says where the number comes from.

    `of` ("marker", .., "diagnostic") is the kind of the `item`. `quantity` is one of `mbproj.scene.blocks.observables`,
    in the SI unit `unit`; `component` is "x", "y", "z", "norm" or "" for all. `over` is the input of a ratio, `between`
    the markers of a transmission angle. `at` is a time in s, a passage, or one of `observables.MOMENTS`."""

    name: str
    of: str
    item: str
    quantity: str
    unit: str
    component: str
    at: float | str | Passage
    source: str
    value: tuple[float, ...] | None = None
    tolerance: float | None = None
    below: float | None = None
    above: float | None = None
    over: str = ""
    between: tuple[str, ...] = ()
