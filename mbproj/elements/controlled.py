"""Quantities that a scene computes beside its motion: signals, states and controllers."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program


@dataclass(frozen=True)
class Signal:
    """A named expression, in `unit` of SI, "" where the scene gives none."""

    name: str
    program: Program
    unit: str = ""


@dataclass(frozen=True)
class ScalarState:
    """A state x' = rate from `start`, in `unit` of SI, "" where the scene gives none. Its absolute tolerance is
    relative to `scale`."""

    name: str
    rate: Program
    start: float = 0.0
    scale: float = 1.0
    unit: str = ""

    @property
    def of_element(self) -> tuple[Program, float, float, str]:
        """The fields that `mbproj.elements.State` takes after the name."""
        return self.rate, self.start, self.scale, self.unit


@dataclass(frozen=True)
class Held:
    """A value that a controller sets at its instants to that of the program, in `unit` of SI, "" where the scene gives
    none. Before the first instant it is `start`."""

    name: str
    program: Program
    start: float = 0.0
    unit: str = ""


@dataclass(frozen=True)
class Controller:
    """A controller that acts at the times start + k period, k = 0, 1, ... It computes the values that it will `hold`,
    which take effect `delay` later, and the next values of its `states`. All new values are computed from values before
    the action."""

    name: str
    period: float
    hold: tuple[Held, ...]
    states: tuple[Held, ...] = ()
    delay: float = 0.0
    start: float = 0.0
