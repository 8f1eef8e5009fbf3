"""The record of a joint type: its rows, its coordinates, its parameters in a scene, and its coupling of coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Literal, NamedTuple, TypeAlias

from mbproj.dataclass import dataclass
from mbproj.functions.program import COORDINATE, Code, Op, Program, apply, number, variable


class Ratio(NamedTuple):
    """A row Σ kᵢ sᵢ - function(s₀) of coordinates: the `weights` kᵢ, the function, and the `period` of the sum. The
    period None follows from turns of the angles."""

    weights: tuple[float, ...]
    period: float | None
    function: Program | None = None


def thread(pitch: float) -> Ratio:
    """s - pitch φ / 2π in m, with the displacement s along z1 and the angle φ about it.

    `pitch` is the advance a turn in m, positive for a right-handed screw.
    """
    return Ratio((1.0, -pitch / (2.0 * math.pi)), abs(pitch))


def mesh(teeth: tuple[float, float], pressure_angle: float | None = None) -> Ratio:
    """(n1 φ1 + n2 φ2) / max(|n1|, |n2|) in rad, with the angles of two joints, for wheels of n1 and n2 `teeth`.

    Opposite signs of n1 and n2 make an internal gear or a belt. The `pressure_angle` counts in its bearings alone.
    """
    larger = max(abs(number) for number in teeth)
    return Ratio((teeth[0] / larger, teeth[1] / larger), 2.0 * math.pi / larger)


def pinion(radius: float) -> Ratio:
    """s - r φ in m, with the angle φ of a pinion of `radius` and the displacement s of its rack."""
    return Ratio((-radius, 1.0), None)


def wrap(radii: tuple[float, float]) -> Ratio:
    """(r1 φ1 - r2 φ2) / max(|r1|, |r2|) in rad, of two pulleys under a belt; a negative radius crosses it."""
    larger = max(abs(radius) for radius in radii)
    return Ratio((radii[0] / larger, -radii[1] / larger), None)


def tread(radius: float) -> Ratio:
    """s - r φ in m, with the angle φ of a wheel of `radius` and the way s on which it rolls."""
    return Ratio((1.0, -radius), 2.0 * math.pi * radius)


def halve() -> Ratio:
    """φ0 - (φ1 + φ2) / 2 in rad, of the carrier and the two shafts of a differential."""
    return Ratio((1.0, -0.5, -0.5), None)


def geneva(slots: float) -> Ratio:
    """φ2 + f(φ1) in rad, of a driver whose pin is on the line of centres at φ1 = 0, and of its wheel.

    In a slot f = atan2(k sin φ1, 1 - k cos φ1). k = sin(π/n), so that the pin enters the slot along it, where cos φ1 =
    k and f' = 0. Outside of slots f stays ±π/n. A turn of the driver is a step of 2π/n.
    """
    k, φ = math.sin(math.pi / slots), variable(COORDINATE)
    sine, cosine = apply(Op.SIN, φ), apply(Op.COS, φ)
    turned = apply(Op.ATAN2, _times(k, sine), apply(Op.SUBTRACT, number(1.0), _times(k, cosine)))
    # φ minus its distance from ±π, which does not jump at a half turn
    back = apply(Op.ATAN2, apply(Op.NEGATE, sine), apply(Op.NEGATE, cosine))
    stays = _times(1.0 / slots, apply(Op.SUBTRACT, φ, back))
    locked = apply(Op.ADD, number(0.5), _times(0.5, apply(Op.SIGN, apply(Op.SUBTRACT, number(k), cosine))))
    turn = apply(Op.ADD, turned, apply(Op.MULTIPLY, locked, apply(Op.SUBTRACT, stays, turned)))
    return Ratio((0.0, 1.0), None, Program(apply(Op.NEGATE, turn)))


def _times(factor: float, code: Code) -> Code:
    return apply(Op.MULTIPLY, number(factor), code)


#: A primitive's name and the points and vectors it takes, e.g. ("perpendicular", "x1", "z2").
Row = tuple[str, ...]


MayBe: TypeAlias = Literal[
    "any", "positive", "nonzero", "teeth", "slots", "curve", "space_curve", "convex", "side", "pressure"
]


class Parameter(NamedTuple):
    """A parameter of a joint: a number in an SI unit ("": none), or the name of a curve or of a side. With `many` it is
    a list of so many, called `words` in messages. `optional`: whether it may be left out."""

    unit: str
    may_be: MayBe = "any"
    many: int | None = None
    words: str = "numbers"
    optional: bool = False


@dataclass(frozen=True)
class JointType:
    """A joint type. `separate`: the scene gives a point in each body, because the rows do not make them coincide.
    `mbproj.joints.table` describes the fields."""

    frame: str
    rows: tuple[Row, ...]
    coordinates: Mapping[str, Row] = field(default_factory=dict)
    aligned: tuple[tuple[str, str], ...] = ()
    separate: bool = False
    kept: Mapping[int, str | None] = field(default_factory=dict)
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    couples: tuple[str, ...] = ()
    coupling: Callable[..., Ratio] | None = None
    merges: bool = False
    x_axis: Literal["none", "optional", "required"] = "none"
    has_axis: bool = False
    dry: bool = False
    slip: Row = ()
    sketch: str = ""

    @property
    def required_parameters(self) -> tuple[str, ...]:
        """The parameters without a default. A parameter that a row keeps has its value at the scene's pose as default,
        except for a joint on a plane."""
        able = {} if self.is_on_plane else {*self.kept.values()}
        return tuple(name for name, each in self.parameters.items() if not (each.optional or name in able))

    @property
    def is_on_plane(self) -> bool:
        """Whether body 2 is on a plane of body 1."""
        return self.frame in ("plane", "line")

    @property
    def turns(self) -> bool:
        """Whether the joint turns about an axis of both bodies."""
        return "angle" in self.coordinates

    @property
    def is_threaded(self) -> bool:
        """Whether a row couples its own coordinates."""
        return bool(self.couples) and self.frame != "joints"

    @property
    def is_rod(self) -> bool:
        """Whether a rod joins its two points, of constant length or not."""
        return any(row[0] == "distance" for row in (*self.rows, *self.coordinates.values()))
