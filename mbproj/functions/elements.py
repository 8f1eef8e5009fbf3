"""An element: the channels that it reads, states of its own, forces along coordinates, rows between them.

A coordinate is that of a joint, "pin.angle"; the place of a marker along an axis of the ground, "tip.x"; or a distance.
Examples of distances are "rope.left", where `lengths` of the element "rope" has "left", and "spring.length", between
the points of a force of the scene. A channel is a coordinate; its rate, "pin.angle_dot"; the state of an element,
"motor.current"; or the force of a law, "spring.force", which is positive where it drives its coordinate up.

Programs of an element depend on the time, and on what it reads: variable CHANNELS + i is `reads[i]`. A force's program
also depends on the coordinate that it acts along and its rate, as COORDINATE and RATE. A row's function depends on its
first coordinate alone, as COORDINATE. Instructions whose branch changes with these variables are switches: events of a
run.

An expression may replace a program. It names the first three variables t, s and s_dot, and a channel as `called` does:
"motor_current".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place as InFile
from mbproj.functions.program import Program


@dataclass(frozen=True)
class Place:
    """A point of a body, by the body's name, from its centre of mass in the body's axes, in m."""

    body: str
    location: tuple[float, float, float]


#: The end of a length: a marker's name, a point of the ground in m, or a point of a body.
End = str | tuple[float, float, float] | Place


def called(channel: str) -> str:
    """Return the name of a channel in expressions: _ replaces each dot and hyphen."""
    return channel.replace(".", "_").replace("-", "_")


@dataclass(frozen=True)
class State:
    """A state x' = rate(t, channels) from `start`, in `unit`; the absolute tolerance is relative to `scale`. A state
    that `counts`, as heat does, changes also while the mechanism rests. Only lost energies depend on it."""

    name: str
    rate: Program | str
    start: float = 0.0
    scale: float = 1.0
    unit: str = "1"
    counts: bool = False


@dataclass(frozen=True)
class Force:
    """A generalised force `push` (N or N m), positive where it drives the coordinate up. `loses`: whether the energy
    that it takes is lost, as in a damper; else it does work. Its name in results is that of its element and the
    coordinate, or its own `name`."""

    along: str
    push: Program | str
    loses: bool = False
    name: str = ""


@dataclass(frozen=True)
class Row:
    """A constraint Σ kᵢ sᵢ - function(s₀) = constant, with coordinates sᵢ and their weights kᵢ in `of`, s₀ the first. A
    turn of an angle s₀ must change `function` by 0 or by whole periods. Its slope must not jump. Where a higher
    derivative does, at a knot of a table or the 0 of x in max(x, 0)**3, a step ends.

    With one angle, the row's period is a turn times the angle's weight. `period` gives that of several angles; 0 is
    none.

    With one coordinate of weight 1 and a function of the time, the row is a motion: s = constant + function(t)."""

    name: str
    of: Mapping[str, float]
    function: Program | str | None = None
    period: float | None = None
    constant: float = 0.0
    place: InFile | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class Element:
    """The data of one element; names of states, rows and lengths begin with its own. `lengths` have two ends each.

    `inertias`: I in kg, or kg m², of a body behind a gear that moves with a coordinate s and has the energy ½ I s'².
    Examples are a flywheel on a shaft, and an inerter between two points.

    `stores`: the energy that it stores; `lost`: the energy that it has lost since the start, as a state of its own;
    both in J. The work of its forces is taken from these two, and only the difference is work from outside. Where all
    its forces lose energy, the energy that they take is lost, except what the element stores."""

    name: str
    reads: tuple[str, ...] = ()
    states: tuple[State, ...] = ()
    forces: tuple[Force, ...] = ()
    rows: tuple[Row, ...] = ()
    lengths: Mapping[str, tuple[End, End]] = field(default_factory=dict)
    inertias: Mapping[str, float] = field(default_factory=dict)
    stores: Program | str | None = None
    lost: Program | str | None = None


# --- Quantities that a scene computes beside its motion ---------------------------------------------------------------
# Signals, states and controllers.


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
        """The fields that `mbproj.functions.elements.State` takes after the name."""
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
