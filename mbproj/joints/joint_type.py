"""What a joint type is: its rows, its coordinates, and what the scene may say of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Literal, NamedTuple, TypeAlias

from mbproj.dataclass import dataclass
from mbproj.joints.ratios import Ratio

#: A primitive's name and the points and vectors it takes, e.g. ("perpendicular", "x1", "z2").
Row = tuple[str, ...]


MayBe: TypeAlias = Literal[
    "any", "positive", "nonzero", "teeth", "slots", "curve", "space_curve", "convex", "side", "pressure"
]


class Parameter(NamedTuple):
    """Numbers that a joint takes, in an SI unit ("": none): one, or so `many`, which messages call by `words`; or a
    name, of a curve or of a side. `optional`: whether it may be left out."""

    unit: str
    may_be: MayBe = "any"
    many: int | None = None
    words: str = "numbers"
    optional: bool = False


@dataclass(frozen=True)
class JointType:
    """One kind of joint; `separate` points in the two bodies are given where it does not bring them together."""

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
        """The parameters that have no value of their own at the scene's pose, or that count for more."""
        able = {} if self.is_on_plane else {*self.kept.values()}
        return tuple(name for name, each in self.parameters.items() if not (each.optional or name in able))

    @property
    def is_on_plane(self) -> bool:
        """Whether body 2 is on a plane of body 1."""
        return self.frame in ("plane", "line")

    @property
    def turns(self) -> bool:
        """Whether it turns about an axis of both bodies."""
        return "angle" in self.coordinates

    @property
    def is_threaded(self) -> bool:
        """Whether a row couples its own coordinates."""
        return bool(self.couples) and self.frame != "joints"

    @property
    def is_rod(self) -> bool:
        """Whether a rod joins its two points, of constant length or not."""
        return any(row[0] == "distance" for row in (*self.rows, *self.coordinates.values()))
