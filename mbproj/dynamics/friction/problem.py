"""All contacts and frictions that hold at an instant, as one problem on the Delassus operator B of their rows.

Forces y along the rows change accelerations b to b + B y. Each foot is a spring, and all have one stiffness; the cone
of the foot limits the force: y = P(u), with P the projection onto the cones, and -u what the springs give way by. For
rigid feet u is in the range of B, and the rows that are held do not accelerate. No row is preferred, and rows may
depend on each other. Where all stick y is the least-norm share within the cones. Where all slide it is the limit of
(B + ε I) y + b = 0 for ε -> 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

#: Passes of Newton's method at most.
MOST_PASSES = 100
#: Passes that need not be better than those before, and how often they are tried.
MOST_LEAPS, MOST_TRIES = 1, 20


@dataclass(frozen=True)
class Cone:
    """What the forces of one contact may be. `push`: the row that pushes, -1 for the friction of a joint. `tangents`:
    the rows of its friction. It sticks with a force up to `most`, a coefficient of the push or a force; or it `slides`,
    with this part of the push along each tangent."""

    push: int
    tangents: tuple[int, ...] = ()
    most: float = 0.0
    slides: tuple[float, ...] = ()


def contact_problem(B: Array, b: Array, cones: Sequence[Cone], give: float = 0.0) -> Array | None:
    """y (n,) of all rows, with which none that is held accelerates: pushes, and tangents that stick. None where no
    forces within the cones do that. B (n, n) is symmetric. Springs that `give`, in 1/kg, have an answer always."""
    held = np.array([row for cone in cones for row in _held(cone)], dtype=np.intp)
    wanted, scale = held if give else independent(B, held), float(np.abs(b[held]).max(initial=0.0))
    if scale == 0.0:
        return np.zeros(len(b))
    spread, more = (np.eye(len(b))[:, held], give * np.eye(len(held))) if give else (B[:, wanted], 0.0)
    own = B[np.ix_(wanted, wanted)] + more
    w, damping = np.linalg.solve(B[wanted] @ spread + more, -b[wanted]), 0.0  # as if all were within
    y, slope = _projected(spread @ w, cones)
    off = b[wanted] + B[wanted] @ y + give * w
    leaps, tries = 0, MOST_TRIES
    for _ in range(MOST_PASSES):
        size = float(np.abs(off).max())
        if size <= THRESHOLDS.no_push * scale:
            held_off = (b + B @ y)[held]
            return y if give or np.abs(held_off).max() <= np.sqrt(THRESHOLDS.no_push) * scale else None
        left = B[wanted] @ slope @ spread + more
        while True:
            step = np.linalg.lstsq(left + damping * own, -off, rcond=1e-14)[0]
            trial, trial_slope = _projected(spread @ (w + step), cones)
            trial_off = b[wanted] + B[wanted] @ trial + give * (w + step)
            if np.linalg.norm(trial_off) < np.linalg.norm(off) or leaps:
                break
            damping = max(10.0 * damping, THRESHOLDS.damped_from)
            if damping > THRESHOLDS.damped_to:  # no short step is better: some long ones leave the place
                damping, leaps, tries = np.sqrt(THRESHOLDS.damped_from), MOST_LEAPS, tries - 1
                if not tries:
                    return None
        leaps = max(leaps - 1, 0)
        w, y, slope, off = w + step, trial, trial_slope, trial_off
        damping = 0.1 * damping if damping > THRESHOLDS.damped_from else 0.0
    return None


def independent(B: Array, rows: Integers) -> Integers:
    """Of some rows of B as many as do not depend on each other, the most independent first, in ascending order."""
    left = B[np.ix_(rows, rows)].copy()
    size, found = np.diagonal(left).copy(), list[int]()
    while True:
        part = np.diagonal(left) / np.where(size > 0.0, size, 1.0)
        best = int(np.argmax(part)) if len(part) else 0
        if not len(part) or part[best] <= THRESHOLDS.no_push:
            return np.sort(rows[found])
        found.append(best)
        left -= np.outer(left[:, best], left[best]) / left[best, best]


def _held(cone: Cone) -> tuple[int, ...]:
    """The rows along which a contact does not accelerate."""
    push = () if cone.push < 0 else (cone.push,)
    return push if cone.slides else (*push, *cone.tangents)


def _projected(u: Array, cones: Sequence[Cone]) -> tuple[Array, Array]:
    """P(u) and its derivative, (n,) and (n, n)."""
    y, slope = np.zeros(len(u)), np.zeros((len(u), len(u)))
    for cone in cones:
        rows, push = list(cone.tangents), cone.push
        if push < 0:
            _limit(u, rows, cone.most, y, slope)
        elif cone.slides or not rows:
            if u[push] > 0.0:
                parts = [1.0, *cone.slides]
                y[[push, *rows]], slope[[push, *rows], push] = u[push] * np.array(parts), parts
        else:
            _within(u, push, rows, cone.most, y, slope)
    return y, slope


def _limit(u: Array, rows: list[int], most: float, y: Array, slope: Array) -> None:
    """A force of a given size at most."""
    size = float(np.linalg.norm(u[rows]))
    if size <= most:
        y[rows], slope[rows, rows] = u[rows], 1.0
        return
    way = u[rows] / size
    y[rows] = most * way
    slope[np.ix_(rows, rows)] = most / size * (np.eye(len(rows)) - np.outer(way, way))


def _within(u: Array, push: int, rows: list[int], most: float, y: Array, slope: Array) -> None:
    """The cone of Coulomb, |y_t| <= most y_n."""
    pushed, size = float(u[push]), float(np.linalg.norm(u[rows]))
    if size <= most * pushed:
        y[[push, *rows]] = u[[push, *rows]]
        slope[[push, *rows], [push, *rows]] = 1.0
    elif pushed + most * size > 0.0:
        way, edge = u[rows] / size, (pushed + most * size) / (1.0 + most**2)
        along = np.array([1.0, *(most * way)])
        y[[push, *rows]] = edge * along
        slope[np.ix_([push, *rows], [push, *rows])] = np.outer(along, along) / (1.0 + most**2)
        slope[np.ix_(rows, rows)] += most * edge / size * (np.eye(len(rows)) - np.outer(way, way))
