"""`register_integrator`: adds a user's Runge-Kutta method, which runs wherever those of mbproj run.

A tableau is refused where its order is lower than claimed, or where it is implicit and not A-stable. A coefficient with
a wrong digit would give a wrong result without a warning.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache
from math import prod
from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import InputError, Problem
from mbproj.base.registry import IntegratorEntry, integrators
from mbproj.base.thresholds import THRESHOLDS
from mbproj.motion.steppers.tableau import matrix, vector

# --- The order of a method --------------------------------------------------------------------------------------------
# The order of a Runge-Kutta method by its order conditions, one for each rooted tree (Hairer, Nørsett & Wanner 1993,
# sect. II.2): Σ bᵢ Φᵢ(tree) = 1/γ(tree).


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


# --- `register_integrator` --------------------------------------------------------------------------------------------


#: A coefficient: a number, or a text as "5/72".
Coefficient: TypeAlias = "float | Fraction | str"
#: The most stages that the kernel can hold.
MOST_STAGES = 32
#: The points of a step at which an extension is checked by order conditions.
THROUGH = (0.25, 0.6)


def register_integrator(
    name: str,
    *,
    order: int,
    a: Sequence[Sequence[Coefficient]],
    b: Sequence[Coefficient],
    summary: str,
    error: Sequence[Coefficient] | None = None,
    dense: Sequence[Sequence[Coefficient]] | None = None,
    source: str = "",
) -> None:
    """Add the Runge-Kutta method of a tableau to the integrators that a scene may name.

    `a` has a row for each stage, or for each but the first, which is f at the start of the step. Zeros on the right may
    be left out. Where a stage has a coefficient of its own, the method is implicit, for stiff scenes. It is an ESDIRK
    method then: that coefficient is the same γ in all stages but the first, and the last row is `b`.

    `error`, b - b̂ of an embedded pair, lets a tolerance control the steps. It has a weight for each stage; that of an
    explicit method has one more, for f at the end of the step. An implicit method needs it. `dense`: for each weight of
    `error` the coefficients of θ, θ², … in the continuous extension, without which it is the cubic through both ends.

    Raises InputError where the name is taken, the numbers do not fit together, or the order is lower than claimed.
    """
    rows, weights = [_texts(row) for row in a], _texts(b)
    stages = len(weights)
    if len(rows) == stages and not vector(rows[0]).any():
        rows = rows[1:]
    if len(rows) != stages - 1 or any(len(row) > stages for row in rows):
        shape = f"'a' has {len(rows)} rows beside {stages} weights in 'b'"
        raise _unfit(name, shape, "give a row for each stage, or for each but the first")
    if not 1 <= stages <= MOST_STAGES:
        raise _unfit(name, f"it has {stages} stages", f"a method has 1 to {MOST_STAGES}")
    A = matrix([[], *rows], stages)
    implicit = bool(np.triu(A).any())
    data: dict[str, Any] = {"summary": summary, "source": source, "order": order, "a": rows, "b": weights}
    data["c"] = [repr(float(c)) for c in A.sum(axis=1)]
    _check_order(name, A, vector(weights), order)
    if implicit:
        data["gamma"] = rows[-1][-1] if len(rows[-1]) == stages else "0"
        _check_implicit(name, A, vector(weights), error)
    if error is not None:
        data |= _estimate(name, A, weights, _texts(error), order, implicit=implicit)
    if dense is not None or error is not None:
        data["dense"] = _extension(name, A, vector(weights), dense, implicit=implicit)
    entry = IntegratorEntry(order, error is not None, summary, data, implicit)
    integrators().add(name, entry, json.dumps(data), taken=("auto",))


def _texts(numbers: Sequence[Coefficient]) -> list[str]:
    """Return numbers as the files of tableaus have them. Raises InputError for one that is no finite number."""
    texts = []
    for each in numbers:
        real = isinstance(each, Real) and not isinstance(each, Fraction)
        text = repr(float(each)) if real else str(each)
        try:
            finite = text.isascii() and "_" not in text and bool(np.isfinite(vector([text])[0]))
        except (ValueError, ZeroDivisionError):
            finite = False
        if not finite:
            raise InputError(Problem(f"a tableau has '{text}', which is no number", hint="write 0.25 or '1/4'"))
        texts.append(text)
    return texts


def _unfit(name: str, what: str, hint: str | None = None) -> InputError:
    return InputError(Problem(f"integrator '{name}': {what}", hint=hint))


def _check_order(name: str, A: Array, b: Array, order: int) -> None:
    if not 1 <= order <= HIGHEST:
        raise _unfit(name, f"an order of {order} cannot be checked", f"it is 1 to {HIGHEST}")
    holds_to = holds_up_to(A, b)
    if holds_to < order:
        missed = defect(A, b, holds_to + 1)
        what = f"it is of order {holds_to}, not {order}: a condition of order {holds_to + 1} is missed by {missed:.2g}"
        raise _unfit(name, what, "check the coefficients; fractions as texts are exact: '5/72'")


def _check_implicit(name: str, A: Array, b: Array, error: object) -> None:
    """Check the properties that implicit steps assume, here and in the kernel. Raises InputError where one is
    missing."""
    gamma = A[-1, -1]
    if np.triu(A, 1).any():
        raise _unfit(name, "a stage needs a later one", "an implicit method has one stage after another (ESDIRK)")
    if not gamma > 0.0 or (np.diag(A)[1:] != gamma).any() or A[0, 0]:
        raise _unfit(name, "its stages have several γ", "all but the first have one γ > 0, and the first has none")
    if (A[-1] != b).any():
        raise _unfit(name, "its last stage is not the end of the step", "the last row of 'a' is 'b' (stiffly accurate)")
    if error is None:
        raise _unfit(name, "an implicit method needs 'error'", "give b - b̂ of its embedded pair")
    largest = max(_growth(A, 1j * y) for y in np.geomspace(1e-3, 1e8, 2000))
    if largest > 1.0 + 1e-9:
        raise _unfit(name, f"it is not A-stable: an undamped vibration grows {largest:.4g} times in a step")


def _growth(A: Array, z: complex) -> float:
    """Return |R(z)| of a method whose last stage is the end of the step."""
    return float(abs(np.linalg.solve(np.eye(len(A)) - z * A, np.ones(len(A)))[-1]))


def _estimate(
    name: str, A: Array, weights: list[str], error: list[str], order: int, *, implicit: bool
) -> dict[str, Any]:
    """Return the estimate of the error, and the order that follows from it."""
    wanted = len(weights) + (not implicit)
    if len(error) != wanted:
        after = "" if implicit else ", and one for f at the end of the step"
        raise _unfit(name, f"'error' has {len(error)} weights, not {wanted}", f"it has one for each stage{after}")
    estimated = holds_up_to(A if implicit else _with_end(A, vector(weights)), vector(error), exact=False)
    if not 1 <= estimated < order:
        what = f"'error' is an estimate of order {estimated + 1} in the step"
        raise _unfit(name, what, f"b - b̂ of an embedded pair is of order 2 to {order}")
    return {"error": error if implicit else [error], "error_order": estimated}


def _with_end(A: Array, b: Array) -> Array:
    """Return the matrix with f at the end of the step as one more stage."""
    whole = np.zeros((len(A) + 1, len(A) + 1))
    whole[:-1, :-1], whole[-1, :-1] = A, b
    return whole


def _extension(
    name: str, A: Array, b: Array, dense: Sequence[Sequence[Coefficient]] | None, *, implicit: bool
) -> list[list[str]]:
    """Return the continuous extension that is given, or the cubic y₀ + (3θ² - 2θ³)(y₁ - y₀) + h (θ - 2θ² + θ³) y₀' + h
    (θ³ - θ²) y₁'."""
    whole = A if implicit else _with_end(A, b)
    if dense is None:
        weights = np.zeros((len(whole), 3))
        weights[: len(b)] = np.outer(b, (0.0, 3.0, -2.0))
        weights[0] += (1.0, -2.0, 1.0)
        weights[-1] += (0.0, -1.0, 1.0)
        return [_texts(row) for row in weights.tolist()]
    rows = [_texts(row) for row in dense]
    if len(rows) != len(whole) or len({len(row) for row in rows}) != 1:
        raise _unfit(name, f"'dense' needs {len(whole)} rows of one length, one for each weight of 'error'")
    D = np.array([vector(row) for row in rows])
    ends = np.zeros((2, len(whole)))
    ends[0, 0], ends[1, : len(b)] = 1.0, b
    if not np.allclose(D[:, 0], ends[0], atol=1e-12) or not np.allclose(D.sum(axis=1), ends[1], atol=1e-12):
        raise _unfit(name, "'dense' does not join both ends", "it begins with f at the start and sums to 'b'")
    for theta in THROUGH:
        at = D @ theta ** np.arange(1, D.shape[1] + 1)
        if any(defect(whole, at, n, theta=theta) for n in (1, 2)):
            raise _unfit(name, "'dense' is not of order 2 within a step", "check its coefficients")
    return rows
