"""The influence of varied quantities on a measure: rank correlations, Sobol' indices, and their confidence
intervals."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass

#: The confidence level of an interval, and the standard deviations of the normal distribution that belong to it.
CONFIDENCE, DEVIATIONS = 0.95, 1.959964
#: The number of bootstrap samples, and the seed.
RESAMPLED, SEED = 500, 0


def rank_correlation(x: Array, y: Array) -> float:
    """Spearman's rank correlation of (N,) and (N,). Equal values share their mean rank. NaN where one of them does not
    vary."""
    ranks = np.stack([_ranks(x), _ranks(y)])
    apart = ranks - ranks.mean(axis=1, keepdims=True)
    sizes = np.linalg.norm(apart, axis=1)
    return float(apart[0] @ apart[1] / sizes.prod()) if sizes.all() else float("nan")


def rank_interval(correlation: float, count: int) -> tuple[float, float]:
    """The confidence interval of a rank correlation of `count` independent samples. It is Fisher's transformation with
    the variance (1 + ρ²/2) / (N - 3) (Bonett and Wright 2000, Psychometrika 65, 23-28)."""
    if count <= 3 or not np.isfinite(correlation):
        return -1.0, 1.0
    middle = np.arctanh(np.clip(correlation, -1.0 + 1e-12, 1.0 - 1e-12))
    width = DEVIATIONS * np.sqrt((1.0 + correlation**2 / 2.0) / (count - 3))
    return float(np.tanh(middle - width)), float(np.tanh(middle + width))


def _ranks(values: Array) -> Array:
    """The ranks of values from 1 on; equal values share their mean rank."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    shared: Array = (last - (counts - 1) / 2.0)[place.reshape(-1)]
    return shared


@dataclass(frozen=True, eq=False)
class Indices:
    """Sobol' indices of d quantities, (d,): the parts of a measure's variance, by each alone and with all its
    interactions. Their confidence intervals are (2, d). `samples` is the number of samples of the design that were
    used."""

    first: Array
    total: Array
    first_between: Array
    total_between: Array
    samples: int


def sobol_indices(values: Array, samples: int) -> Indices:
    """Compute the indices from the measure's values (n (d + 2),) in the order of Saltelli's design: A, B, then A with
    one column of B each.

    First order: Saltelli et al. 2010, total: Jansen 1999 (Computer Physics Communications 181, 259-270, and 117,
    35-43). A sample with a case without value is left out in all cases. The intervals come from a bootstrap over the
    samples."""
    blocks = values.reshape(-1, samples)
    blocks = blocks[:, np.all(np.isfinite(blocks), axis=0)]
    blocks = blocks - (blocks[:2].mean() if blocks.size else 0.0)
    terms = _terms(blocks)
    count = blocks.shape[1]
    draw = np.random.default_rng(SEED)
    # A resample is given by how often it draws each sample: a mean over it is a product with these numbers.
    drawn = (draw.multinomial(count, np.full(count, 1.0 / count)) / count for _ in range(RESAMPLED if count else 0))
    spread = np.array([_shares(terms @ weights) for weights in drawn]).reshape(-1, 2, len(blocks) - 2)
    edges = [(1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0]
    between = np.quantile(spread, edges, axis=0) if count else np.full((2, 2, len(blocks) - 2), np.nan)
    first, total = _shares(terms @ np.full(count, 1.0 / max(count, 1)))
    return Indices(first, total, between[:, 0], between[:, 1], count)


def _terms(blocks: Array) -> Array:
    """The terms (2 d + 2, n) whose means give the indices: products and squares for each quantity, then two for the
    variance."""
    A, B, mixed = blocks[0], blocks[1], blocks[2:]
    both = np.stack([(A**2 + B**2) / 2.0, (A + B) / 2.0])
    terms: Array = np.concatenate([B * (mixed - A), (A - mixed) ** 2 / 2.0, both])
    return terms


def _shares(means: Array) -> Array:
    """The indices (2, d) from the means of the terms; NaN where nothing varies."""
    variance = means[-2] - means[-1] ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        shares: Array = means[:-2].reshape(2, -1) / variance
    return np.where(variance > 0.0, shares, np.nan)
