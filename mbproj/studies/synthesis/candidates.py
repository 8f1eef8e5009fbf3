"""Candidates for a synthesis: many designs of one topology are fitted at once by damped least squares, with poses in
closed form."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from scipy.stats import qmc

from mbproj.base.arrays import Array, Flags
from mbproj.base.dataclass import dataclass
from mbproj.studies.synthesis.linkage import (
    FUNCTION,
    PATH,
    POSITIONS,
    TOPOLOGIES,
    Linkage,
    Numbers,
    Points,
    SpatialFourBar,
    bounds,
)
from mbproj.studies.synthesis.spec import Wanted

#: The number of random designs for each one that is optimised, and the steps of its optimisation, with given and with
#: free timing of a path.
LOOKED_AT, STEPS, MORE_STEPS = 128, 100, 300
#: The step of differences as a part of a number's range, the initial damping, and the damping at which a design is
#: given up.
STEP, DAMPING, LOST = 1e-6, 1e-3, 1e8
#: The least damping with which JᵀJ of dependent slopes is regular beyond round-off.
LEAST_DAMPING = 1e-12
#: The number of crank angles of the polyline on which nearest points are sought.
FINE = 60
#: The number of steps that refine the nearest angle, and the longest step in rad.
REFINED, NEAR = 3, 0.1
#: The distance of the second point of a body with wanted positions from the first, as a part of their extent.
ARM = 0.5
#: A design is exact where its error is at most this part of the extent. For positions the search begins again until an
#: exact design is found, at most this many times: for five positions few designs exist, or none.
EXACT, ROUNDS = 1e-9, 12
#: The number of crank angles from one position to the next at which a design must close.
BETWEEN = 24
#: The number of best candidates that are returned.
HANDED_ON = 3
SPATIAL = "spatial_four_bar"
#: Residuals (B, m) of designs (B, d).
Residuals: TypeAlias = "Callable[[Array], Array]"
#: ∂r/∂(x / range) (B, m, d) of designs (B, d) with ranges (d,).
Slopes: TypeAlias = "Callable[[Array, Array], Array]"


@dataclass(frozen=True, eq=False)
class Candidate:
    """A design of a topology: its numbers by name, with the `side`s and the crank's direction `turn`. `rms`: its error
    in m or rad. It `locks` where it does not close at all angles from one position to the next."""

    numbers: Mapping[str, float]
    rms: float
    locks: bool

    def rank(self) -> tuple[bool, float]:
        """Designs that lock come last, then the error decides: a smaller rank is better."""
        return self.locks, self.rms


def names_for(kind: str) -> tuple[str, ...]:
    """The names of the topologies for this kind of task."""
    names = [name for name, ways in TOPOLOGIES.items() if kind in ways]
    return (*names, SPATIAL) if kind == FUNCTION else tuple(names)


def mechanism_of(wanted: Wanted, name: str) -> Linkage | SpatialFourBar:
    """The mechanism of the topology `name` for this task."""
    return SpatialFourBar() if name == SPATIAL else TOPOLOGIES[name][wanted.kind]


def candidates(wanted: Wanted, name: str) -> list[dict[str, float]]:
    """The best designs of a topology, the best first: their numbers, and `rms`. A work item."""
    mechanism = mechanism_of(wanted, name)
    designs: list[Candidate] = []
    signs = [1.0, -1.0]
    directions = signs if wanted.kind == PATH and wanted.times is not None else [1.0]
    assemblies = [*product(*[signs] * len(mechanism.sides), directions)]
    for number in range(len(assemblies) * (ROUNDS if wanted.kind == POSITIONS else 1)):
        *sides, turn = assemblies[number % len(assemblies)]
        fixed = {**dict(zip(mechanism.sides, sides, strict=True)), "turn": turn}
        designs += _of_one_assembly(wanted, mechanism, fixed, wanted.seed + number)
        whole = number % len(assemblies) == len(assemblies) - 1
        if whole and any(not each.locks and each.rms <= EXACT * wanted.size for each in designs):
            break
    best = sorted(designs, key=Candidate.rank)[:HANDED_ON]
    return [{**each.numbers, "rms": each.rms} for each in best]


def _of_one_assembly(
    wanted: Wanted, mechanism: Linkage | SpatialFourBar, fixed: Mapping[str, float], seed: int
) -> list[Candidate]:
    box = bounds_of(wanted, mechanism)
    free = [name for name, (low, high) in box.items() if low < high]
    low, high = (np.array([box[name][side] for name in free]) for side in (0, 1))
    still = {name: ends[0] for name, ends in box.items() if name not in free} | dict(fixed)

    def numbers(x: Array) -> Numbers:
        return {
            **{name: x[:, k, None] for k, name in enumerate(free)},
            **{n: np.array([[v]]) for n, v in still.items()},
        }

    def residuals(x: Array) -> Array:
        return _residuals(wanted, mechanism, numbers(x))

    many = int(np.ceil(np.log2(LOOKED_AT * wanted.starts)))
    x = low + (high - low) * qmc.Sobol(len(free), rng=np.random.default_rng(seed)).random_base2(many)
    value = np.nan_to_num(np.sum(residuals(x) ** 2, axis=1), nan=np.inf)
    x = x[np.argsort(value, kind="stable")[: wanted.starts]]
    by_normals = None
    if wanted.kind == PATH and wanted.times is None:
        assert isinstance(mechanism, Linkage)
        by_normals = partial(_slopes_along_normals, mechanism, numbers, wanted.values[:, 0] + 1j * wanted.values[:, 1])
    x, cost = brought_down(residuals, x[np.isfinite(np.sort(value)[: len(x)])], low, high, by_normals)
    rms = np.sqrt(cost / max(residuals(low[None]).shape[1], 1))
    locks = np.zeros(len(x), dtype=bool)
    if wanted.kind == POSITIONS and isinstance(mechanism, Linkage) and len(x):
        locks = _locks(mechanism, numbers(x), len(wanted.values))
    order = np.lexsort([rms, locks])[:HANDED_ON]
    return [
        Candidate({**dict(zip(free, x[k].tolist(), strict=True)), **still}, float(rms[k]), bool(locks[k]))
        for k in order.tolist()
        if np.isfinite(rms[k])
    ]


def brought_down(
    residuals: Residuals, x: Array, low: Array, high: Array, slopes: Slopes | None = None
) -> tuple[Array, Array]:
    """Return designs (B, d) after Levenberg-Marquardt steps within their bounds, and their sums of squares (B,).
    Without `slopes` of the residuals differences are taken."""
    steps, slopes = (STEPS, partial(_slopes, residuals)) if slopes is None else (MORE_STEPS, slopes)
    if not len(x):
        return x, np.zeros(0)
    r = residuals(x)
    cost, damping, range_ = np.sum(r * r, axis=1), np.full(len(x), DAMPING), high - low
    for _ in range(steps):
        going = np.flatnonzero((damping < LOST) & (cost > 0.0))
        if not len(going):
            break
        J = slopes(x[going], range_)
        square = np.swapaxes(J, 1, 2) @ J
        diagonal = np.einsum("bii->bi", square)
        diagonal += damping[going, None] * (diagonal + 1e-12 * diagonal.max(axis=1, keepdims=True) + 1e-300)
        way = np.linalg.solve(square, np.swapaxes(J, 1, 2) @ r[going][..., None])[..., 0]
        trial = np.clip(x[going] - way * range_, low, high)
        off = residuals(trial)
        value = np.sum(off * off, axis=1)
        better = value < cost[going]
        x[going[better]], r[going[better]], cost[going[better]] = trial[better], off[better], value[better]
        damping[going] = np.where(better, np.maximum(0.2 * damping[going], LEAST_DAMPING), 5.0 * damping[going])
    return x, cost


def _slopes(residuals: Residuals, x: Array, range_: Array) -> Array:
    """∂r/∂(x / range), (B, m, d), by differences of all designs at once; 0 where a neighbour does not close."""
    count, d = x.shape
    beside = x[:, None, None] + STEP * np.array([1.0, -1.0])[:, None, None] * np.diag(range_)
    values = residuals(beside.reshape(-1, d)).reshape(count, 2, d, -1)
    return np.nan_to_num(np.swapaxes((values[:, 0] - values[:, 1]) / (2.0 * STEP), 1, 2))


def _slopes_along_normals(
    mechanism: Linkage, numbers: Callable[[Array], Numbers], points: Any, x: Array, range_: Array
) -> Array:
    """Return ∂r/∂(x / range), (B, 2N, d), for a path of free timing. To first order the nearest point only moves along
    the curve. So the distance changes by the normal part of the change at a fixed crank angle. Nearest points of
    neighbouring designs are not needed."""
    count, d = x.shape
    p = numbers(x)
    angles = _nearest(mechanism, p, points)
    way = _traced(mechanism, p, angles + STEP) - _traced(mechanism, p, angles - STEP)
    along = (way / np.maximum(np.abs(way), 1e-300))[:, None]
    beside = x[:, None, None] + STEP * np.array([1.0, -1.0])[:, None, None] * np.diag(range_)
    moved = _traced(mechanism, numbers(beside.reshape(-1, d)), np.repeat(angles, 2 * d, axis=0))
    ends = moved.reshape(count, 2, d, -1)
    change = (ends[:, 0] - ends[:, 1]) / (2.0 * STEP)
    change = change - along * (change * along.conj()).real
    return np.nan_to_num(np.swapaxes(np.concatenate([change.real, change.imag], axis=2), 1, 2))


def bounds_of(wanted: Wanted, mechanism: Linkage | SpatialFourBar) -> dict[str, tuple[float, float]]:
    """Return the bounds of each number of a topology; a number with equal bounds is fixed."""
    if isinstance(mechanism, SpatialFourBar):
        return mechanism.bounds()
    box = bounds(mechanism, wanted.kind, wanted.centre, wanted.size)
    if wanted.kind == POSITIONS:
        box["lean"] = (-np.pi, np.pi)
        box |= {f"swing_{k}": (-np.pi, np.pi) for k in range(2, len(wanted.values) + 1)}
    elif wanted.kind == PATH and not wanted.turns and wanted.times is not None:
        box["angle"] = (0.1, 2.0 * np.pi)
    return box


def _residuals(wanted: Wanted, mechanism: Linkage | SpatialFourBar, p: Numbers) -> Array:
    """Return the residuals of designs with numbers (B, 1), (B, m), in m or rad."""
    if wanted.kind == FUNCTION:
        angle = output_of(mechanism, p, p["start"] + wanted.values[:, 0] - wanted.values[0, 0])
        return _wrap(angle - angle[:, :1] - (wanted.values[:, 1] - wanted.values[0, 1]))
    assert isinstance(mechanism, Linkage)
    points = wanted.values[:, 0] + 1j * wanted.values[:, 1]
    if wanted.kind == POSITIONS:
        known = mechanism.solved(p, _swung(p, len(points)))
        apart = body_of(mechanism, p, known) - np.exp(1j * wanted.values[:, 2])
        parts = [known["P"] - points, ARM * wanted.size * apart]
        return np.concatenate([part for each in parts for part in (each.real, each.imag)], axis=1)
    if wanted.times is not None:
        off = mechanism.solved(p, crank_of(wanted, p))["P"] - points
    else:
        off = _traced(mechanism, p, _nearest(mechanism, p, points)) - points
    return np.concatenate([off.real, off.imag], axis=1)


def _swung(p: Numbers, count: int) -> Array:
    """Return the crank's angles (B, count) at the positions."""
    swings = [np.zeros_like(p["start"]), *(p[f"swing_{k}"] for k in range(2, count + 1))]
    return np.asarray(p["start"] + np.concatenate(swings, axis=1))


def swung_between(p: Numbers, count: int, t: Array) -> Array:
    """Return the crank's angles (B, T) at times t on the way through `count` positions: the polynomial of the scene,
    with position k at t = k."""
    powers = np.linalg.solve(np.vander(np.arange(float(count)), increasing=True), _swung(p, count).T)
    return np.asarray((np.vander(t, count, increasing=True) @ powers).T)


def _locks(mechanism: Linkage, p: Numbers, count: int) -> Flags:
    """Return whether each design (B,) fails to close somewhere on the way through `count` positions."""
    t = np.linspace(0.0, count - 1.0, BETWEEN * (count - 1) + 1)
    known = mechanism.solved(p, swung_between(p, count, t))
    return np.any([np.isnan(point).any(axis=1) for point in known.values()], axis=0)


def body_of(mechanism: Linkage, p: Numbers, known: Mapping[str, Points]) -> Points:
    """Return the direction of the carried body, as a complex number of size 1, from the mechanism's points."""
    link = mechanism.link(mechanism.traced)
    return np.asarray((known[link.toward] - known[link.origin]) / p[link.length] * np.exp(1j * p["lean"]))


def crank_of(wanted: Wanted, p: Numbers) -> Array:
    """The crank's angles (B, N) at the times of a path."""
    assert wanted.times is not None
    span = 2.0 * np.pi / period(wanted) if wanted.turns else p["angle"] / wanted.times[-1]
    return np.asarray(p["start"] + p["turn"] * span * wanted.times)


def period(wanted: Wanted) -> float:
    """Return the period of a closed path in s: the time of the last point, and a mean step back to the first."""
    assert wanted.times is not None
    return float(wanted.times[-1] * len(wanted.times) / (len(wanted.times) - 1))


def output_of(mechanism: Linkage | SpatialFourBar, p: Numbers, crank: Array) -> Array:
    """The angle of the output (B, N)."""
    if isinstance(mechanism, SpatialFourBar):
        return mechanism.angle(p, crank)
    link, known = mechanism.link(mechanism.output), mechanism.solved(p, crank)
    return np.angle(known[link.toward] - known[link.origin])


def _wrap(angle: Array) -> Array:
    """Angles within [-π, π]."""
    return np.asarray(angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)))


def _traced(mechanism: Linkage, p: Numbers, crank: Array) -> Any:
    return mechanism.solved(p, crank)["P"]


def _nearest(mechanism: Linkage, p: Numbers, points: Any) -> Array:
    """Return the crank's angles (B, N) at which the curve is nearest to given points (N,). The search is on a polyline,
    then by Gauss-Newton steps."""
    angles = np.linspace(0.0, 2.0 * np.pi, FINE + 1)
    curve = _traced(mechanism, p, p["start"] + angles)
    start, way = curve[:, None, :-1], np.diff(curve)[:, None]
    size = np.maximum(np.abs(way) ** 2, 1e-300)
    share = np.clip(((points[None, :, None] - start) * way.conj()).real / size, 0.0, 1.0)
    best = np.argmin(np.abs(start + share * way - points[None, :, None]), axis=2)
    angle = p["start"] + angles[best] + np.take_along_axis(share, best[..., None], axis=2)[..., 0] * angles[1]
    for _ in range(REFINED):
        off = _traced(mechanism, p, angle) - points
        rate = (_traced(mechanism, p, angle + STEP) - _traced(mechanism, p, angle - STEP)) / (2.0 * STEP)
        angle = angle - np.clip((off * rate.conj()).real / np.maximum(np.abs(rate) ** 2, 1e-300), -NEAR, NEAR)
    return np.asarray(angle)
