"""How much each quantity that varies has to do with a measure: rank correlations, Sobol' indices, quantiles."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass

#: Of an interval: the share of what it is to hold, and how many standard deviations of the normal distribution that is.
CONFIDENCE, DEVIATIONS = 0.95, 1.959964
#: Samples of the bootstrap, and its seed.
RESAMPLED, SEED = 500, 0


def rank_correlation(x: Array, y: Array) -> float:
    """Spearman's: the correlation of the ranks of (N,) and (N,), equal values sharing theirs; NaN where one of them
    does not vary."""
    ranks = np.stack([_ranks(x), _ranks(y)])
    apart = ranks - ranks.mean(axis=1, keepdims=True)
    sizes = np.linalg.norm(apart, axis=1)
    return float(apart[0] @ apart[1] / sizes.prod()) if sizes.all() else float("nan")


def rank_interval(correlation: float, count: int) -> tuple[float, float]:
    """Between what the correlation of ranks of so many independent samples lies: Fisher's transformation with the
    variance (1 + ρ²/2) / (N - 3) (Bonett and Wright 2000, Psychometrika 65, 23-28)."""
    if count <= 3 or not np.isfinite(correlation):
        return -1.0, 1.0
    middle = np.arctanh(np.clip(correlation, -1.0 + 1e-12, 1.0 - 1e-12))
    width = DEVIATIONS * np.sqrt((1.0 + correlation**2 / 2.0) / (count - 3))
    return float(np.tanh(middle - width)), float(np.tanh(middle + width))


def _ranks(values: Array) -> Array:
    """From 1 on; what is equal shares the mean of its ranks."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    shared: Array = (last - (counts - 1) / 2.0)[place.reshape(-1)]
    return shared


@dataclass(frozen=True, eq=False)
class Indices:
    """Sobol' indices of d quantities, (d,): shares in a measure's variance, of each alone and with all that it takes
    part in; between what they lie, (2, d); from how many samples of the design they are."""

    first: Array
    total: Array
    first_between: Array
    total_between: Array
    samples: int


def sobol_indices(values: Array, samples: int) -> Indices:
    """From the measure's values (n (d + 2),) in the order of Saltelli's design: A, B, then A with one column of B each.

    First order: Saltelli et al. 2010, total: Jansen 1999 (Computer Physics Communications 181, 259-270, and 117,
    35-43). A sample of which any case has no value is left out in all of them; the intervals are those of a bootstrap
    over the samples."""
    blocks = values.reshape(-1, samples)
    blocks = blocks[:, np.all(np.isfinite(blocks), axis=0)]
    blocks = blocks - (blocks[:2].mean() if blocks.size else 0.0)
    terms = _terms(blocks)
    count = blocks.shape[1]
    draw = np.random.default_rng(SEED)
    # A resample is how often each sample is drawn: a mean over it is a product with these numbers.
    drawn = (draw.multinomial(count, np.full(count, 1.0 / count)) / count for _ in range(RESAMPLED if count else 0))
    spread = np.array([_shares(terms @ weights) for weights in drawn]).reshape(-1, 2, len(blocks) - 2)
    edges = [(1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0]
    between = np.quantile(spread, edges, axis=0) if count else np.full((2, 2, len(blocks) - 2), np.nan)
    first, total = _shares(terms @ np.full(count, 1.0 / max(count, 1)))
    return Indices(first, total, between[:, 0], between[:, 1], count)


def _terms(blocks: Array) -> Array:
    """(2 d + 2, n): what the means are of that make the indices: the products and squares of each quantity, then what
    the variance follows from."""
    A, B, mixed = blocks[0], blocks[1], blocks[2:]
    both = np.stack([(A**2 + B**2) / 2.0, (A + B) / 2.0])
    terms: Array = np.concatenate([B * (mixed - A), (A - mixed) ** 2 / 2.0, both])
    return terms


def _shares(means: Array) -> Array:
    """(2, d): the indices from the means of the terms; NaN where nothing varies."""
    variance = means[-2] - means[-1] ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        shares: Array = means[:-2].reshape(2, -1) / variance
    return np.where(variance > 0.0, shares, np.nan)
