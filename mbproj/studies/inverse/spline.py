"""Splines of degree 5 through measured samples, whose second derivatives are smooth. Only noise is smoothed, and the
change is reported.

A least-squares spline of FITPACK (Dierckx 1993) has the fewest knots for which the root mean square change is at most
σ. Where σ is not given, it is estimated from divided differences of order 6, which vanish for polynomials of degree 5.
Differences of noise do not become smaller with their order. Those of a smooth motion do, and such a motion is
interpolated.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem

DEGREE = 5
#: The orders of differences that tell noise from a smooth motion. In a smooth motion the differences of the higher
#: order are smaller by at least this factor; in noise both are alike.
ORDERS, SMOOTH = (6, 8), 0.3
#: Noise below this part of the largest value is round-off, and is interpolated.
ROUND_OFF = 1e-13


@dataclass(frozen=True, eq=False)
class Smoothed:
    """A spline. `at` returns its value, first and second derivative at times (T,), (3, T). `noise` is σ, the largest
    root mean square change. `change` (T,) is the difference of the spline from each sample."""

    at: Callable[[Array], Array]
    noise: float
    change: Array


def smoothed(time: Array, values: Array, noise: float | None) -> Smoothed:
    """Fit a spline to samples (T,) with noise of this root mean square. None estimates the noise, 0 interpolates.
    Raises InputError where FITPACK finds no spline."""
    σ = _estimated(time, values) if noise is None else noise
    from scipy.interpolate import BSpline, make_interp_spline, splrep

    if σ == 0.0:
        spline = make_interp_spline(time, values, k=DEGREE)
    else:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            knots, coefficients, degree = splrep(time, values, k=DEGREE, s=len(time) * σ**2)
        spline = BSpline(knots, coefficients, degree)
        if said and not np.sqrt(np.mean((spline(time) - values) ** 2)) <= 1.01 * σ:
            problem = Problem(f"no spline is as near as {σ:.3g} to the samples", Place("--smooth"), "give a larger one")
            raise InputError(problem)
    derivatives = [spline, spline.derivative(1), spline.derivative(2)]
    return Smoothed(lambda t: np.array([each(t) for each in derivatives]), σ, spline(time) - values)


def _estimated(time: Array, values: Array) -> float:
    """Estimate σ of the noise; 0 for samples of a smooth motion, or too few samples."""
    if len(time) <= 2 * ORDERS[1]:
        return 0.0
    lower, higher = (_difference_rms(time, values, order) for order in ORDERS)
    is_smooth = higher < SMOOTH * lower or lower <= ROUND_OFF * float(np.abs(values).max(initial=0.0))
    return 0.0 if is_smooth else lower


def _difference_rms(time: Array, values: Array, order: int) -> float:
    """The root mean square of divided differences of an order, weighted so that white noise of σ gives σ."""
    rows = np.lib.stride_tricks.sliding_window_view
    nodes, node_values = rows(time, order + 1), rows(values, order + 1)
    apart = nodes[:, :, None] - nodes[:, None, :]
    apart[:, np.arange(order + 1), np.arange(order + 1)] = 1.0
    span = (nodes[:, -1] - nodes[:, 0])[:, None, None]
    weights = 1.0 / np.prod(apart / span, axis=2)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    return float(np.sqrt(np.mean(np.sum(weights * node_values, axis=1) ** 2)))
