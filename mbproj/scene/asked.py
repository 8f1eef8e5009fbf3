"""What a scene asks of a run: how constraints are enforced, how time goes on, what is recorded, what is expected."""

from __future__ import annotations

from dataclasses import field
from typing import NamedTuple

from mbproj.dataclass import dataclass


@dataclass(frozen=True)
class ProjectionSettings:
    """How the constraints are enforced. `tolerance` None: max(1e-13, 4 ε × the largest coordinate) for the violation
    test, 1e-12 for the paper's. `threshold` (violation) None: by `every` alone. `alpha`, `gains`: None where the
    method has no such option. `energy`, `momentum`: whether velocities keep the energy balance and momenta, too."""

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
    `kinematic`: None does not integrate what has no degrees of freedom, True refuses all else, False integrates all."""

    duration: float | None = None
    step: float | None = None
    tolerance: float | None = None
    integrator: str = "rk4"
    formulation: str = "auto"
    acceleration: str = "bordered"
    impact_law: str = "newton"
    output_step: float | None = None
    break_times: tuple[float, ...] = ()
    start: str = "scene"
    adjust_joints: float | None = None
    kinematic: bool | None = None
    projection: ProjectionSettings = field(default_factory=ProjectionSettings)


class Passage(NamedTuple):
    """Where a joint coordinate ("crank.angle") first has a value in its `unit`; angles modulo a turn."""

    coordinate: str
    value: float
    unit: str


@dataclass(frozen=True)
class Expectation:
    """What a run has to find: a `value` within `tolerance`, or at most `below`, or at least `above`, by its `source`.

    `of` ("marker", .., "diagnostic") and `item` say of what; `quantity` is of `mbproj.scene.blocks.observables`, in the
    SI unit `unit`; `component` "x", "y", "z", "norm" or "" for all; `over` the input of a ratio; `between` the markers
    of a transmission angle; `at` a time in s, a passage, or one of `MOMENTS` there."""

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
