"""The order of a Runge-Kutta method by its order conditions, one for each rooted tree (Hairer, Nørsett & Wanner 1993,
sect. II.2): Σ bᵢ Φᵢ(tree) = 1/γ(tree)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from math import prod
from typing import TypeAlias

import numpy as np

from mbproj.arrays import Array
from mbproj.thresholds import THRESHOLDS

#: A rooted tree, as the sorted subtrees at its root.
Tree: TypeAlias = tuple["Tree", ...]
#: The highest order that is checked: it has 719 conditions.
HIGHEST = 10


@cache
def trees(vertices: int) -> tuple[Tree, ...]:
    """Return all rooted trees with this number of vertices."""
    if vertices == 1:
        return ((),)
    return tuple(sorted({grown for tree in trees(vertices - 1) for grown in _with_one_more(tree)}))


def _with_one_more(tree: Tree) -> Iterator[Tree]:
    """The trees with one more leaf."""
    yield tuple(sorted((*tree, ())))
    for at, branch in enumerate(tree):
        for grown in _with_one_more(branch):
            yield tuple(sorted((*tree[:at], grown, *tree[at + 1 :])))


@cache
def density(tree: Tree) -> int:
    """Return γ: the number of vertices, times γ of the branches."""
    return _vertices(tree) * prod(map(density, tree))


def _vertices(tree: Tree) -> int:
    return 1 + sum(map(_vertices, tree))


def defect(a: Array, weights: Array, vertices: int, *, theta: float = 1.0, exact: bool = True) -> float:
    """Return the largest |Σ wᵢ Φᵢ - θⁿ/γ| over the trees with n `vertices`, beyond round-off; `a` is (s, s), `weights`
    (s,). Without `exact` the sums should be 0, as in an estimate of the error."""
    worst, known = 0.0, dict[Tree, Array]()
    for tree in trees(vertices):
        terms = weights * _elementary(tree, a, known)
        wanted = theta**vertices / density(tree) if exact else 0.0
        missed = abs(float(terms.sum()) - wanted)
        if missed > THRESHOLDS.no_digits * (1.0 + float(np.abs(terms).sum())) * len(a):
            worst = max(worst, missed)
    return worst


def _elementary(tree: Tree, a: Array, known: dict[Tree, Array]) -> Array:
    """Return Φ (s,): the product over the branches of A Φ."""
    if tree not in known:
        parts = [a @ _elementary(branch, a, known) for branch in tree]
        known[tree] = np.prod(parts, axis=0) if parts else np.ones(len(a))
    return known[tree]


def holds_up_to(a: Array, weights: Array, *, exact: bool = True) -> int:
    """Return the largest number of vertices up to which all conditions hold."""
    order = 0
    while order < HIGHEST and not defect(a, weights, order + 1, exact=exact):
        order += 1
    return order
