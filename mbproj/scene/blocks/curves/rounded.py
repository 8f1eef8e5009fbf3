"""Rounded points of a curve: the error that rounding causes in the accelerations of a follower."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbproj.functions.curves.piece import Form
from mbproj.functions.curves.track import SpaceTrack, Track

#: Numbers are rounded to a digit where they differ from it by less than ROUGHLY of its unit; DIGITS are tried.
ROUGHLY, DIGITS = 1e-6, 12
#: Curves with fewer points are drawn by a designer; they are no table of a cam, and give no note.
FEWEST = 24
#: The least uncertainty that is reported, relative to half the lift: the acceleration per ω² of a harmonic motion.
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
    """The unit in m to which the N points of a closed curve were rounded, and the error of a follower's acceleration,
    in m per (rad/s)². The error is 12 r (N/2π)² with r half the unit. None where it is small, or the rounding is not
    known."""
    if isinstance(track, SpaceTrack):
        return None
    polar = track.line.pieces[0].form is Form.POLAR
    rows = track.rows[:-1] if polar else track.rows
    if not track.line.closed or len(rows) < FEWEST:
        return None
    lengths = [row[1] for row in rows] if polar else [each for row in rows for each in row]
    radii = [row[1] if polar else math.hypot(*row) for row in rows]
    half = grain(lengths)
    error = 12.0 * half * (len(rows) / (2.0 * math.pi)) ** 2
    return (2.0 * half, error) if error > FELT * 0.5 * (max(radii) - min(radii)) else None
