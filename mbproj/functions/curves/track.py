"""Named curves of a scene, with the follower for which each was made."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.functions.curves.plane_curve import PlaneCurve
from mbproj.functions.curves.space_curve import SpaceCurve


@dataclass(frozen=True)
class Track:
    """A curve in a plane. `line` is the curve that is followed. For a curve that was made for a `roller` of this radius
    in m, it is the path of the roller's centre; the profile then lies inside, at this distance to the left. `rows` are
    the points, or angles and radii, from which it was drawn. `flat`: whether it was made for a flat face."""

    name: str
    line: PlaneCurve
    roller: float = 0.0
    rows: tuple[tuple[float, float], ...] = ()
    flat: bool = False

    def scaled(self, k: float) -> Track:
        """The track k times as large."""
        return Track(self.name, self.line.scaled(k), k * self.roller, flat=self.flat)

    def is_left(self, side: str | None) -> bool:
        """Whether a follower on this `side`, by default the outside, is on the left of the curve."""
        if side in ("left", "right"):
            return side == "left"
        return (side == "inside") == self.line.turns_left

    def distance(self, side: str | None, radius: float) -> float:
        """The distance in m to the left of the line of the centre of a roller that touches the profile."""
        return (radius if self.is_left(side) else -radius) + self.roller


@dataclass(frozen=True)
class SpaceTrack:
    """A curve in space."""

    name: str
    line: SpaceCurve

    def scaled(self, k: float) -> SpaceTrack:
        """The track k times as large."""
        return SpaceTrack(self.name, self.line.scaled(k))
