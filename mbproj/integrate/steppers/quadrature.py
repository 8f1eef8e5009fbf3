"""The quadrature of a kinematic run: quantities along the motion are integrated over a step from seven values.

The nodes are those of Kronrod's extension, of order 10, of Lobatto's rule with four points (Gander & Gautschi 2000).
That rule, of order 6, gives the error estimate. Stages, extension and predictions are integrals of the polynomials
through the values.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from mbproj.arrays import Array
from mbproj.integrate.steppers.tableau import QUADRATURE, Tableau

#: The nodes on [-1, 1]; every second one is a node of Lobatto's rule.
NODES = np.array([-1.0, -np.sqrt(2.0 / 3.0), -np.sqrt(0.2), 0.0, np.sqrt(0.2), np.sqrt(2.0 / 3.0), 1.0])
LOBATTO = (0, 2, 4, 6)
ORDER, ERROR_ORDER = 10, 6


@cache
def quadrature() -> Tableau:
    """Return the quadrature as an explicit method: each stage is predicted from those before it, and none depends on
    its own value."""
    c = 0.5 * (1.0 + NODES)
    stages = len(c)
    a = np.zeros((stages, stages))
    for stage in range(1, stages):
        a[stage, :stage] = integrals(c[:stage], c[stage])
    b, dense = integrals(c, 1.0), np.zeros((stages + 1, stages))
    dense[:-1] = lagrange(c) / np.arange(1, stages + 1)
    error = np.zeros((1, stages + 1))
    error[0, :-1] = b
    error[0, list(LOBATTO)] -= integrals(c[list(LOBATTO)], 1.0)
    nothing = np.zeros((0, stages + 1))
    return Tableau(QUADRATURE, ORDER, ERROR_ORDER, a, b, c, error, nothing, np.zeros(0), dense)


def lagrange(nodes: Array) -> Array:
    """Return the coefficients (s, s) of 1, x, x², … in the polynomials that are 1 at a node (s,) and 0 at the
    others."""
    return np.asarray(np.linalg.inv(np.vander(nodes, increasing=True)).T)


def integrals(nodes: Array, end: float) -> Array:
    """Return the weights (s,) of values at the nodes in the integral of the polynomial through them from 0 to `end`."""
    powers = np.arange(1, len(nodes) + 1)
    return np.asarray(lagrange(nodes) @ (end**powers / powers))
