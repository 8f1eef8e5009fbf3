"""What a scene computes beside its motion: signals, states and controllers."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program


@dataclass(frozen=True)
class Signal:
    """An expression by its name, in `unit` of SI, "" where the scene does not say it."""

    name: str
    program: Program
    unit: str = ""


@dataclass(frozen=True)
class ScalarState:
    """x' = rate from `start`, in `unit` of SI, "" where the scene does not say it; `scale` is what its absolute
    tolerance is relative to."""

    name: str
    rate: Program
    start: float = 0.0
    scale: float = 1.0
    unit: str = ""

    @property
    def of_element(self) -> tuple[Program, float, float, str]:
        """As `mbproj.elements.State` takes them after the name."""
        return self.rate, self.start, self.scale, self.unit


@dataclass(frozen=True)
class Held:
    """What a controller sets at its instants, in `unit` of SI, "" where the scene does not say it: to what the program
    is then. Until the first it is `start`."""

    name: str
    program: Program
    start: float = 0.0
    unit: str = ""


@dataclass(frozen=True)
class Controller:
    """At the times start + k period, k = 0, 1, ..., it computes what it will `hold`, which stands `delay` later, and
    the next values of its `states`; all of them from what is there before."""

    name: str
    period: float
    hold: tuple[Held, ...]
    states: tuple[Held, ...] = ()
    delay: float = 0.0
    start: float = 0.0
