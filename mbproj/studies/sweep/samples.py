"""Samples of the unit cube, by the names of their designs: each a function of dimensions, how many, and a seed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from mbproj.arrays import Array

#: (dimensions d, samples n, seed) -> (n, d), or more rows.
Sampler: TypeAlias = "Callable[[int, int, int], Array]"
MONTECARLO, LHS, SOBOL, SALTELLI = "montecarlo", "lhs", "sobol", "saltelli"
#: Designs that are balanced only where there are 2, 4, 8, .. samples.
POWERS_OF_TWO = frozenset({SOBOL, SALTELLI})


def montecarlo(dimensions: int, samples: int, seed: int) -> Array:
    """Independent samples; more of them begin with the same ones."""
    return np.random.default_rng(seed).random((samples, dimensions))


def latin_hypercube(dimensions: int, samples: int, seed: int) -> Array:
    """One sample in each of n slices of every dimension."""
    from scipy.stats import qmc

    found: Array = qmc.LatinHypercube(dimensions, seed=np.random.default_rng(seed)).random(samples)
    return found


def sobol(dimensions: int, samples: int, seed: int) -> Array:
    """Sobol's sequence, scrambled; more of them begin with the same ones."""
    from scipy.stats import qmc

    found: Array = qmc.Sobol(dimensions, seed=np.random.default_rng(seed)).random(samples)
    return found


def saltelli(dimensions: int, samples: int, seed: int) -> Array:
    """Saltelli's design for Sobol' indices, (n (d + 2), d): samples A, other ones B, and A with one column of B each
    (Saltelli et al. 2010, Computer Physics Communications 181, 259-270)."""
    both = sobol(2 * dimensions, samples, seed)
    A, B = both[:, :dimensions], both[:, dimensions:]
    mixed = np.repeat(A[None], dimensions, axis=0)
    for column in range(dimensions):
        mixed[column, :, column] = B[:, column]
    return np.concatenate([A, B, mixed.reshape(-1, dimensions)])


SAMPLERS: Mapping[str, Sampler] = MappingProxyType(
    {LHS: latin_hypercube, SOBOL: sobol, SALTELLI: saltelli, MONTECARLO: montecarlo}
)
