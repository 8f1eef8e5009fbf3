"""Points of a curve that were rounded: how far the accelerations of a follower may be off because of that."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbproj.functions.curves.piece import Form
from mbproj.functions.curves.track import SpaceTrack, Track

#: What numbers are looked at for a last digit to this part of it, and with so many digits at most.
ROUGHLY, DIGITS = 1e-6, 12
#: Fewer points are those of a designer, not of a table of a cam.
FEWEST = 24
#: An uncertainty below this part of half the lift, which a harmonic motion has as its acceleration per ω², is let be.
FELT = 0.05


def grain(numbers: Sequence[float]) -> float:
    """Half of the last decimal digit that numbers are rounded to; 0 where they have more than 12."""
    largest = max(abs(each) for each in numbers)
    for digits in range(DIGITS):
        unit = 10.0 ** (math.ceil(math.log10(largest)) - digits)
        if all(abs(each / unit - round(each / unit)) < ROUGHLY for each in numbers):
            return 0.5 * unit
    return 0.0


def uncertainty(track: Track | SpaceTrack) -> tuple[float, float] | None:
    """The unit in m to which the points of a closed curve were rounded, and what that does to the acceleration of a
    follower, in m per (rad/s)²: 12 r (N/2π)². None where that is not felt, or not known."""
    if isinstance(track, SpaceTrack):
        return None
    polar = track.line.pieces[0].form is Form.POLAR
    rows = track.rows[:-1] if polar else track.rows
    if not track.line.closed or len(rows) < FEWEST:
        return None
    lengths = [row[1] for row in rows] if polar else [each for row in rows for each in row]
    radii = [row[1] if polar else math.hypot(*row) for row in rows]
    half = grain(lengths)
    found = 12.0 * half * (len(rows) / (2.0 * math.pi)) ** 2
    return (2.0 * half, found) if found > FELT * 0.5 * (max(radii) - min(radii)) else None
