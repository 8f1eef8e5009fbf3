"""Velocity ratio, mechanical advantage and transmission angle from recorded motion (Uicker, Pennock and Shigley, Theory
of Machines and Mechanisms, ch. 3)."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array

#: Speeds below this part of the largest of the run count as rest. A ratio to an input at rest has no value.
REST = 1e-10


def velocity_ratio(output: Array, input_: Array) -> Array:
    """The rate of an output over that of an input, (T,): dsₒ/dsᵢ. NaN where the input rests."""
    moves = np.abs(input_) > REST * np.abs(input_).max(initial=0.0)
    return np.asarray(np.where(moves, output / np.where(moves, input_, 1.0), np.nan))


def mechanical_advantage(output: Array, input_: Array) -> Array:
    """The ratio of the force at an output to the force at an input that balances it, (T,): dsᵢ/dsₒ by virtual power,
    without inertia, friction and other forces. It is infinite, with the sign of the input, where only the output
    rests."""
    rests = np.abs(output) <= REST * np.abs(output).max(initial=0.0)
    moves = np.abs(input_) > REST * np.abs(input_).max(initial=0.0)
    advantage = np.where(rests, np.copysign(np.inf, input_), input_ / np.where(rests, 1.0, output))
    return np.asarray(np.where(moves, advantage, np.nan))


def transmission_angle(first: Array, corner: Array, second: Array) -> Array:
    """The angle at a `corner` between the lines to two other points, (T, 3) each, folded into 0 to π/2. At the joint of
    coupler and output it is best at π/2; at 0 nothing is transmitted."""
    one, other = first - corner, second - corner
    sine = np.linalg.norm(np.cross(one, other), axis=-1)
    return np.asarray(np.arctan2(sine, np.abs(np.sum(one * other, axis=-1))))
