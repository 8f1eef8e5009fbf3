"""The accuracy of numbers that were fitted to measurements, and the numbers that the data do not determine. Both follow
from the residuals' slopes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.scene.ranges.family import column_of

#: A direction whose singular value is below this part of the largest one has no effect on the data. Slopes by
#: differences of runs are exact to about 1e-8.
UNSEEN = 1e-6
#: Components of an unseen direction below this part of the largest one are round-off. Exponents this near to whole
#: numbers count as whole, if they are at most `LARGEST`.
NOTHING, WHOLE, LARGEST = 1e-3, 1e-2, 6
#: Residuals are no noise where the correlation of neighbours exceeds this number of standard deviations for noise.
WHITE = 3.0


@dataclass(frozen=True, eq=False)
class Knowledge:
    """The accuracy of fitted numbers. `deviation` (d,): their standard deviations from the residuals' scatter, with
    `shift` (d,) included: their change by the error of the run's steps. Both are NaN for numbers that the data do not
    determine. `correlation` (d, d) is that of the numbers. `singular`: singular values of the slopes by shares of the
    ranges, largest first. `unseen`: the undetermined combinations, in words. `scatter`: the residuals' standard
    deviation. `lag`: the correlation of neighbouring residuals, in its standard deviations for noise."""

    deviation: Array
    shift: Array
    correlation: Array
    singular: Array
    unseen: tuple[str, ...]
    scatter: float
    lag: float

    @property
    def is_white(self) -> bool:
        """Whether the residuals look like noise."""
        return abs(self.lag) <= WHITE


def knowledge(paths: Sequence[str], x: Array, width: Array, slopes: Array, residuals: Array, error: Array) -> Knowledge:
    """Return the knowledge from the residuals (m,) at the numbers x (d,) and their slopes (m, d) by shares of the
    ranges `width` (d,). `error` (m,): the differences to the residuals of a run with finer steps."""
    m, d = slopes.shape
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    singular = np.concatenate([singular, np.zeros(d - len(singular))])
    whole = np.linalg.svd(slopes)[2] if m < d else directions
    seen = singular > UNSEEN * max(float(singular[0]), 1e-300)
    freedom = max(m - int(seen.sum()), 1)
    scatter = float(np.sqrt(residuals @ residuals / freedom))
    covariance = (whole[seen].T / singular[seen] ** 2) @ whole[seen] * scatter**2
    deviation = np.sqrt(np.diag(covariance))
    shift = np.abs(whole[seen].T @ (whole[seen] @ (slopes.T @ np.nan_to_num(error)) / singular[seen] ** 2))
    scale = np.where(deviation > 0.0, deviation, 1.0)
    free = np.any(np.abs(whole[~seen]) > NOTHING, axis=0) if (~seen).any() else np.zeros(d, dtype=bool)
    return Knowledge(
        deviation=np.where(free, np.nan, np.hypot(deviation, shift) * width),
        shift=np.where(free, np.nan, shift * width),
        correlation=covariance / np.outer(scale, scale),
        singular=singular,
        unseen=tuple(_in_words(paths, x, width, whole[~seen])),
        scatter=scatter,
        lag=_lag(residuals),
    )


def _lag(residuals: Array) -> float:
    """The correlation of each residual with the next, in its standard deviations for white noise."""
    size = float(residuals @ residuals)
    if len(residuals) < 3 or size == 0.0:
        return 0.0
    return float(residuals[1:] @ residuals[:-1] / size * np.sqrt(len(residuals)))


def _in_words(paths: Sequence[str], x: Array, width: Array, unseen: Array) -> list[str]:
    """Describe the directions (k, d), in shares of the ranges, that the data do not determine. Each is reduced to as
    few numbers as possible: "only mass * length^2 is seen"."""
    names = [column_of(path) for path in paths]
    sentences = []
    for direction in _sparse(unseen):
        own = np.flatnonzero(np.abs(direction) > NOTHING * np.abs(direction).max())
        if len(own) == 1:
            sentences.append(f"'{names[own[0]]}' has no effect on what is matched")
            continue
        exponents = _whole(direction[own] * width[own] / x[own]) if np.all(x[own] != 0.0) else None
        if exponents is not None:
            sentences.append(f"only {_constant_products([names[k] for k in own], exponents)} is seen, not its factors")
            continue
        shares = direction[own] * width[own]
        moved = ", ".join(
            f"{names[k]} {share / np.abs(shares).max():+.3g}" for k, share in zip(own, shares, strict=True)
        )
        sentences.append(f"nothing changes where these move together: {moved}")
    return sentences


def _sparse(unseen: Array) -> Array:
    """Return directions with many zeros that span the same space (k, d): Gauss-Jordan elimination with complete
    pivoting."""
    rows = unseen.copy()
    for k in range(len(rows)):
        row, column = np.unravel_index(np.argmax(np.abs(rows[k:])), rows[k:].shape)
        rows[[k, k + row]] = rows[[k + row, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= rows[others, column][:, None] * rows[k]
    return rows


def _whole(powers: Array) -> list[int] | None:
    """Return small whole numbers in the ratios of the relative changes `powers`; None where there are none."""
    for unit in range(1, LARGEST + 1):
        scaled = powers / np.abs(powers).min() * unit
        near = np.round(scaled)
        if np.abs(scaled - near).max() <= WHOLE * unit and np.abs(near).max() <= LARGEST:
            return [int(value) for value in near]
    return None


def _constant_products(names: Sequence[str], exponents: Sequence[int]) -> str:
    """Return, in words, the products a^q / b^p of neighbouring names that relative changes in the ratio of the
    exponents p, q leave constant."""
    products = []
    for (first, p), (second, q) in pairwise(zip(names, exponents, strict=True)):
        divisor = int(np.gcd(p, q))
        a, b = q // divisor, -p // divisor
        if a < 0:
            a, b = -a, -b
        products.append(f"{_power(first, a)}{' * ' if b > 0 else ' / '}{_power(second, abs(b))}")
    return " and ".join(products)


def _power(name: str, exponent: int) -> str:
    return name if exponent == 1 else f"{name}^{exponent}"
