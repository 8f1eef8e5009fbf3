"""An element: the channels that it reads, states of its own, forces along coordinates, rows between them.

A coordinate is that of a joint, "pin.angle"; the place of a marker along an axis of the ground, "tip.x"; a
distance, "rope.left", where `lengths` of the element "rope" has "left"; or of the points that a force of the
scene acts between, "spring.length". A channel is a coordinate; its rate, "pin.angle_dot"; the state of an element,
"motor.current"; or the force of a law, "spring.force", which is positive where it drives its coordinate up.

Programs of an element see the time, and what it reads: variable CHANNELS + i is `reads[i]`. A force's program also sees
the coordinate that it acts along and its rate, as COORDINATE and RATE; a row's function sees its first coordinate
alone, as COORDINATE. Instructions whose branch changes with what they see are switches: events of a run.

An expression may stand for a program. It calls the first three t, s and s_dot, and a channel as `called` has it:
"motor_current".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import Place as InFile
from mbproj.functions.program import Program


@dataclass(frozen=True)
class Place:
    """A point of a body by its name, from the centre of mass in the body's axes, in m."""

    body: str
    location: tuple[float, float, float]


#: Of a length: a marker's name, a point of the ground in m, or one of a body.
End = str | tuple[float, float, float] | Place


def called(channel: str) -> str:
    """How expressions call a channel: with _ for each dot and hyphen."""
    return channel.replace(".", "_").replace("-", "_")


@dataclass(frozen=True)
class State:
    """x' = rate(t, channels) from `start`, in `unit`; the absolute tolerance is relative to `scale`. One that `counts`,
    as heat, goes on where all else rests, and nothing but what is lost goes by it."""

    name: str
    rate: Program | str
    start: float = 0.0
    scale: float = 1.0
    unit: str = "1"
    counts: bool = False


@dataclass(frozen=True)
class Force:
    """A generalised force `push` (N or N m), positive where it drives the coordinate up. `loses`: what it takes is
    lost, as a damper's, and else what it gives is work done. Results call it by the names of its element and of the
    coordinate, or by a `name` of its own."""

    along: str
    push: Program | str
    loses: bool = False
    name: str = ""


@dataclass(frozen=True)
class Row:
    """Σ kᵢ sᵢ - function(s₀) = constant, with the coordinates sᵢ and their weights kᵢ `of` the row, s₀ the first.
    A turn of an angle s₀ changes `function` by nothing, or by whole periods. Its slope does not jump; where a higher
    derivative does, at a knot of a table or the 0 of x in max(x, 0)**3, a step ends.

    Of one angle with a weight, a turn of it is the row's period; `period` gives that of several, and 0 is none.

    Of one coordinate, with the weight 1 and a function of the time, it is a motion: s = constant + function(t)."""

    name: str
    of: Mapping[str, float]
    function: Program | str | None = None
    period: float | None = None
    constant: float = 0.0
    place: InFile | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class Kind:
    """What makes an element of a force, in place of its law: its type, a name in `ELEMENTS` of
    `mbproj.scene.blocks.elements`, and the values of the type's own keys in SI units."""

    type: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Element:
    """Data of one element; names of states, rows and lengths begin with its own. `lengths`: from one end to another.

    `inertias`: I in kg, or kg m², of what moves with a coordinate s behind a gear and has the energy ½ I s'²: a
    flywheel on a shaft, an inerter between two points.

    `stores`: the energy that it keeps, and `lost`: what it has lost since it began, a state of its own say, both in J.
    What its forces do comes out of these, and only the rest is work done on the mechanism from outside. Where all its
    forces lose, what they take and it does not store is lost."""

    name: str
    reads: tuple[str, ...] = ()
    states: tuple[State, ...] = ()
    forces: tuple[Force, ...] = ()
    rows: tuple[Row, ...] = ()
    lengths: Mapping[str, tuple[End, End]] = field(default_factory=dict)
    inertias: Mapping[str, float] = field(default_factory=dict)
    stores: Program | str | None = None
    lost: Program | str | None = None
