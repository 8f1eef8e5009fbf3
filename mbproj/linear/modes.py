"""Modes of a mechanism at a reference: eigenvalues with their shapes on the bodies, joint coordinates, states of
elements, and energies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import shortened
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.derivatives import (
    LinearEquations,
    bushing_gradient,
    channel_slopes,
    law_slopes,
    linear_equations,
    row_motion,
    state_slopes,
)
from mbproj.equations.forces import deflection, law_state, state_rates, viscous
from mbproj.equations.kinematics import attached
from mbproj.linear.bordered import Bordered, diagonal, independent_rows
from mbproj.linear.eigenvalues import eigen, shares_of_states
from mbproj.linear.kinks import refuse_kinks
from mbproj.linear.reduction import in_axes, projected, refuse_large_rolling
from mbproj.linear.reference import LinearReference
from mbproj.model.euler_parameters import product
from mbproj.model.forces import Forces
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System
from mbproj.results.linear_files import StoredModes
from mbproj.results.views import Table, Tabled

#: The names of potential energy beside the forces: weight, where there is any, and forces that turn with their bodies.
GRAVITY, PRELOAD = "gravity and preload", "preload"
#: The name of the remaining strain energy where functions name channels: their forces have no potential.
REST = "gravity and what names channels"


@dataclass(frozen=True, eq=False)
class Modes(Tabled):
    """k modes, the slowest first: eigenvalues λ (k,) in 1/s, one of each conjugate pair, 0 for neutral directions.

    `shapes` (k, n, 6): the shift and small turn of each carrier in global axes; the largest is the mechanism's length
    or 1 rad. `coordinates` (k, nc): the changes of the joint coordinates. `states` (k, K): the changes of the states of
    elements; where no body moves the largest is its scale. `state_share` (k, K): the participation of each state.

    `kinetic` (k, b) and `strain` (k, e): parts of the modes' energies, named by `kinetic_names` and `strain_names`.
    `freedom`: the degrees of freedom. `turns`: whether the tangent space turns along the motion."""

    reference: LinearReference
    eigenvalues: Numbers
    shapes: Numbers
    coordinates: Numbers
    states: Numbers
    state_share: Array
    kinetic_names: tuple[str, ...]
    kinetic: Array
    strain_names: tuple[str, ...]
    strain: Array
    freedom: int
    turns: bool

    @property
    def frequencies(self) -> Array:
        """|Im λ| / 2π in Hz, (k,)."""
        return np.abs(self.eigenvalues.imag) / (2.0 * np.pi)

    @property
    def damping_ratios(self) -> Array:
        """-Re λ / |λ|, (k,); 0 for neutral directions."""
        size = np.abs(self.eigenvalues)
        return 0.0 - self.eigenvalues.real / np.where(size > 0.0, size, 1.0)

    def is_of_states(self, mode: int) -> bool:
        """Return whether states of elements have the largest part in a mode."""
        return bool(self.state_share[mode].sum() > 0.5)

    def name(self, mode: int) -> str:
        """Return the name of a mode: the largest parts of kinetic and of strain energy, "wheel 91 %, spring tyre 83 %".

        For a mode of states it is these states. Where no joint coordinate changes, the name of a body has its axis."""
        names, of_states = [f"state {name}" for name in self.reference.system.names.states], self.is_of_states(mode)
        moving = (
            _largest(names, self.state_share[mode]) if of_states else _largest(self._movers(mode), self.kinetic[mode])
        )
        if self.eigenvalues[mode] == 0.0:
            return f"neutral: {moving}"
        gives_way = self.strain[mode].any() and not of_states
        return f"{moving}; {_largest(self.strain_names, self.strain[mode])}" if gives_way else moving

    def _movers(self, mode: int) -> list[str]:
        """Return the names of kinetic energy with an axis: "engine along z", or "engine about y" where it turns
        more."""
        names = list(self.kinetic_names)
        if np.abs(self.coordinates[mode]).max(initial=0.0) > THRESHOLDS.rounding:
            return names
        system, rotation = self.reference.system, self.reference.motion.pose.rotation
        for carrier, shape in enumerate(self.shapes[mode]):
            shift, turn = np.abs(shape[:3]), rotation[carrier].T @ shape[3:]
            turning = float((turn.conj() @ system.inertia[carrier] @ turn).real)
            shifts = system.mass[carrier] * float(shift @ shift) >= turning
            axis = "xyz"[int(np.argmax(shift if shifts else np.abs(shape[3:])))]
            names[carrier] += f" {'along' if shifts else 'about'} {axis}"
        return names

    @property
    def table(self) -> Table:
        """A table with a row for each mode, the slowest first."""
        values = (self.frequencies.tolist(), self.damping_ratios.tolist(), self.eigenvalues.real.tolist())
        names = map(self.name, range(len(self.eigenvalues)))
        headings = ("frequency (Hz)", "damping ratio", "growth rate (1/s)", "moves")
        return Table(("mode", *headings), tuple(zip(range(1, 1 + len(values[0])), *values, names, strict=True)))

    @property
    def line(self) -> str:
        """The degrees of freedom and the reference, in words."""
        return f"{self.freedom} degrees of freedom, {self.reference.words}"

    __repr__ = Tabled.__repr__


def _largest(names: Sequence[str], shares: Array) -> str:
    return ", ".join(f"{names[index]} {100.0 * shares[index]:.0f} %" for index in leading(shares))


def leading(shares: Array) -> list[int]:
    """Return the number of the largest share, and of the next where it is hardly smaller."""
    order = np.argsort(-shares, kind="stable").tolist()
    least = THRESHOLDS.named * shares[order[0]]
    return [index for index in order[:2] if shares[index] >= least and shares[index] > 0.0]


def modes(reference: LinearReference, count: int | None = None) -> Modes:
    """Return all modes, or the `count` slowest. A large mechanism has few by default, and all growing modes where it
    moves.

    Raises InputError where a force has a kink there, or nothing holds a motion without mass. Raises it where a large
    mechanism that moves, or whose elements have states, has too many degrees of freedom."""
    refuse_kinks(reference)
    scale = reference.system.states.scale
    large = reference.system.bodies > THRESHOLDS.large
    refuse_large_rolling(reference.system)
    if large and reference.rests and not len(scale):
        few = sparse_eigen(reference, count or FEW)
        none = np.zeros((len(few.values), 0))
        return described(reference, few.values, few.vectors, none.T, none, few.freedom, turns=False)
    here = projected(reference)
    (reduced, back), freedom = here.solvable(scale), here.space.freedom
    pairs = eigen(reduced).slowest_and_growing(FEW) if large and count is None else eigen(reduced).slowest(count)
    vectors = back @ pairs.vectors
    ξ, x = here.space.N @ vectors[:freedom], scale[:, None] * vectors[freedom:]
    share = shares_of_states(reduced, pairs, len(scale)) if len(scale) else np.zeros((len(pairs.values), 0))
    size = float(np.abs(here.space.N).max(initial=0.0))
    turns = bool(np.abs(here.N_dot).max(initial=0.0) > THRESHOLDS.rounding * size)
    return described(reference, pairs.values, ξ, x, share, here.freedom, turns=turns)


#: The number of modes of a large mechanism, unless more are asked for.
FEW = 10


def described(
    reference: LinearReference, values: Numbers, ξ: Numbers, x: Numbers, share: Array, freedom: int, *, turns: bool
) -> Modes:
    """Return modes from eigenvalues (k,), virtual displacements (6n, k) in global axes and states of elements (K, k),
    of any size, and the states' participation (k, K)."""
    system, motion = reference.system, reference.motion
    shapes = ξ.T.reshape(len(values), system.bodies, 6)
    size = np.abs(shapes / ([system.length] * 3 + [1.0] * 3))
    largest = size.reshape(len(values), 6 * system.bodies).argmax(axis=1)
    scale = np.take_along_axis(shapes.reshape(len(values), 6 * system.bodies), largest[:, None], axis=1)[:, 0]
    length = np.where(largest % 6 < 3, system.length, 1.0)
    factor = length / np.where(scale == 0.0, 1.0, scale)
    alone = _alone(np.abs(scale) / length, x, system.states.scale)
    shapes = shapes * np.where(alone == 0.0, factor, 0.0)[:, None, None]
    in_body = shapes.copy()
    in_body[..., 3:] = np.einsum("bji,kbj->kbi", motion.pose.rotation[:-1], shapes[..., 3:])
    kinetic_names, kinetic = _kinetic(system, reference, in_body)
    strain_names, strain = _strain(system, reference, in_body, values, kinetic)
    return Modes(
        reference,
        values,
        shapes,
        _changes(system.coordinates, reference, in_body),
        x.T * np.where(alone == 0.0, factor, alone)[:, None],
        share,
        kinetic_names,
        _shares(kinetic),
        strain_names,
        _shares(strain),
        freedom,
        turns,
    )


def _alone(moved: Array, x: Numbers, unit: Array) -> Numbers:
    """Return the factors (k,) that scale states (K, k) to their `unit` in modes where bodies move by round-off only; 0
    in other modes."""
    if not len(unit):
        return np.zeros(len(moved))
    relative = x / unit[:, None]
    largest = np.take_along_axis(relative, np.abs(relative).argmax(axis=0)[None], axis=0)[0]
    still = (moved <= THRESHOLDS.rounding * np.abs(largest)) & (largest != 0.0)
    return np.where(still, 1.0 / np.where(still, largest, 1.0), 0.0)


def _changes(bound: PrimitiveSet, reference: LinearReference, in_body: Numbers) -> Numbers:
    """Return the changes of the coordinates of a set in each mode, (k, m)."""
    g = row_motion(bound, reference.motion.carried()).G
    changes = np.zeros((bound.size, len(in_body)), dtype=complex)
    np.add.at(changes, g.row, np.einsum("eu,keu->ek", g.value, in_body[:, g.body]))
    return changes.T


def _kinetic(system: System, reference: LinearReference, in_body: Numbers) -> tuple[tuple[str, ...], Array]:
    """Return twice the mean kinetic energy at unit speed, (k, b), and its names."""
    shift, turn = in_body[..., :3], in_body[..., 3:]
    energy = system.mass * np.sum(np.abs(shift) ** 2, axis=-1)
    energy = energy + np.einsum("kbi,bij,kbj->kb", turn.conj(), system.inertia, turn).real
    added = system.reflected.inertia * np.abs(_changes(system.reflected.rows, reference, in_body)) ** 2
    names = system.names.forces[len(system.names.forces) - len(system.reflected.inertia) :]
    return (*system.names.carriers, *names), np.concatenate([energy, added], axis=1)


def _strain(
    system: System, reference: LinearReference, in_body: Numbers, values: Numbers, kinetic: Array
) -> tuple[tuple[str, ...], Array]:
    """Return twice the mean strain energy of forces along coordinates, (k, e), and its names; the last is the rest, of
    gravity and preload.

    In a mode that oscillates both energies have one mean, ½ |λ|² of the kinetic energy at unit speed. In one that does
    not, they differ by the dampers' loss: φᵀKφ = -λ² φᵀMφ - λ φᵀDφ."""
    rest_of = REST if system.forces_name_channels else GRAVITY if system.gravity.any() else PRELOAD
    mass = kinetic.sum(axis=1)
    total = np.abs(values) ** 2 * mass
    if not system.forces.size:
        return (rest_of,), total[:, None]
    forces, bushings = system.forces, system.forces.bushings
    stiffness, damping = law_slopes_at(reference)
    change = np.abs(_changes(forces.laws.coordinates, reference, in_body)) ** 2
    strain = np.concatenate([-stiffness * change, _of_bushings(forces, bushings.stiffness, reference, in_body)], axis=1)
    taken = (-damping * change).sum(axis=1)
    if bushings.size:
        along = viscous(bushings, deflection(bushings, reference.motion.pose))
        taken = taken + _of_bushings(forces, along, reference, in_body).sum(axis=1)
    total = np.where(values.imag == 0.0, -values.real * (values.real * mass + taken), total)
    rest = total - strain.sum(axis=1)
    rest = np.where(np.abs(rest) <= 1e3 * THRESHOLDS.rounding * np.abs(strain).sum(axis=1), 0.0, rest)
    names = (*forces.law_owners, *forces.bushing_names, rest_of)
    return names, np.concatenate([strain, rest[:, None]], axis=1)


def _of_bushings(forces: Forces, matrices: Array, reference: LinearReference, in_body: Numbers) -> Array:
    """Return the quadratic form of each bushing, (k, B), with these matrices (B, 6, 6)."""
    bushings = forces.bushings
    g = bushing_gradient(bushings, reference.motion.pose)
    all_bodies = np.concatenate([in_body, np.zeros((len(in_body), 1, 6))], axis=1)  # the ground does not move
    both = all_bodies[:, bushings.body].reshape(len(in_body), len(g), 12)
    change = (g @ both[..., None])[..., 0]
    return np.asarray(np.einsum("kbi,bij,kbj->kb", change.conj(), matrices, change).real)


def law_slopes_at(reference: LinearReference) -> tuple[Array, Array]:
    """Return ∂F/∂s and ∂F/∂s' of each law, (E,)."""
    instant = reference.motion.instant(reference.system)
    return law_slopes(instant, law_state(instant))


def _shares(parts: Array) -> Array:
    """Return sizes as parts of their sum, row by row."""
    size = np.abs(parts)
    return np.asarray(size / np.maximum(size.sum(axis=1, keepdims=True), np.finfo(float).tiny), dtype=float)


# --- The slowest modes of large mechanisms ----------------------------------------------------------------------------
# Shift-invert Arnoldi on the bordered matrices (Bai et al. 2000). The bordered pencil has the eigenvalues of the
# tangent space, and infinite ones, which an inverse iteration does not reach: (K + σD + σ²M) ξ + Gᵀμ = b, G ξ = 0 is
# factored once. The shift σ is real, and not 0, because neutral directions are.


#: The seed of the start of Arnoldi's iteration.
SEED = 22


@dataclass(frozen=True, eq=False)
class SparseEigen:
    """Eigenvalues (k,) in 1/s, virtual displacements (6n, k) in global axes, and the degrees of freedom."""

    values: Numbers
    vectors: Numbers
    freedom: int


def sparse_eigen(reference: LinearReference, count: int) -> SparseEigen:
    """Return the `count` slowest modes of a mechanism at rest whose elements have no states."""
    system, motion = reference.system, reference.motion
    equations = in_axes(linear_equations(system, motion, reference.multipliers), motion, reference.turning)
    pencil = _Pencil(reference, equations, independent_rows(system, motion.pose, equations.rows.G))
    count = min(count, pencil.freedom)
    values, vectors = pencil.symmetric(count) if pencil.is_symmetric() else pencil.general(count)
    order = np.argsort(np.abs(values), kind="stable")
    return SparseEigen(values[order], vectors[:, order], pencil.freedom)


class _Pencil:
    """K, D, M and G of one mechanism, for one search of its modes."""

    def __init__(self, reference: LinearReference, equations: LinearEquations, rows: Integers) -> None:
        self.system, self.G, self.rows = reference.system, equations.rows.G, rows
        self.M, self.D, self.K = (part.sparse() for part in (equations.M, equations.D, equations.K))
        self.freedom = self.M.shape[0] - len(rows)
        self.start = np.random.default_rng(SEED).normal(size=self.M.shape[0])

    def is_symmetric(self) -> bool:
        """Return whether there is no damping, and K is symmetric on the tangent space up to round-off. In free turns of
        a body K is not symmetric, because of torques that constraints balance."""
        if self.D.nnz and np.abs(self.D.data).max() > 0.0:
            return False
        bordered = self.factor(self.shift())
        x, y = (bordered.solve(self.M @ part)[0] for part in (self.start, self.start[::-1].copy()))
        forth, back = float(x @ (self.K @ y)), float(y @ (self.K @ x))
        size = float(np.abs(x) @ (np.abs(self.K) @ np.abs(y)))
        return abs(forth - back) <= 1e3 * THRESHOLDS.rounding * size

    def factor(self, σ: float) -> Bordered:
        """Return the factor of K + σD + σ²M."""
        return Bordered(self.system, self.K + σ * self.D + σ**2 * self.M, self.G, self.rows)

    def shift(self) -> float:
        """Return a shift of about the slowest mode, by inverse iteration from a very small shift."""
        fastest = np.sqrt(np.abs(diagonal(self.K)).max(initial=0.0) / max(diagonal(self.M).max(), 1e-300))
        σ = max(THRESHOLDS.no_motion * float(fastest), THRESHOLDS.half_digits)
        bordered, x = self.factor(σ), self.start
        for _ in range(3):
            x = bordered.solve(self.M @ x)[0]
            x = x / np.linalg.norm(x)
        return max(σ, float(np.sqrt(abs(x @ (self.K @ x)) / (x @ (self.M @ x)))))

    def symmetric(self, count: int) -> tuple[Numbers, Numbers]:
        """Return λ from κ = -λ² of K ξ = κ M ξ by Lanczos, with Rayleigh's quotients of the vectors as values."""
        from scipy.sparse.linalg import LinearOperator, eigsh

        σ = self.shift()
        bordered = self.factor(σ)
        inverse = LinearOperator(self.M.shape, matvec=lambda b: bordered.solve(np.ravel(b))[0], dtype=float)
        start = bordered.solve(self.M @ self.start)[0]
        count = min(count, self.M.shape[0] - 1)
        wide = min(self.M.shape[0], max(2 * count + 10, 30))
        vectors = eigsh(self.K, count, M=self.M, sigma=-(σ**2), OPinv=inverse, v0=start, ncv=wide)[1]
        strain = np.einsum("ik,ik->k", vectors, self.K @ vectors)
        κ = strain / np.einsum("ik,ik->k", vectors, self.M @ vectors)
        size = np.einsum("ik,ik->k", np.abs(vectors), np.abs(self.K) @ np.abs(vectors))
        κ = np.where(np.abs(strain) <= THRESHOLDS.rounding * size, 0.0, κ)
        grows = κ < 0.0
        values = np.concatenate([np.where(grows, -1.0, 1j) * np.sqrt(np.abs(κ)), np.sqrt(-κ[grows])])
        return values.astype(complex), np.concatenate([vectors, vectors[:, grows]], axis=1).astype(complex)

    def general(self, count: int) -> tuple[Numbers, Numbers]:
        """Return λ by Arnoldi on (x, v) -> (x, v)' inverted at σ, without conjugates."""
        from scipy.sparse.linalg import LinearOperator, eigs

        σ, n = self.shift(), self.M.shape[0]
        bordered = self.factor(σ)

        def inverted(both: Array) -> Array:
            x, v = np.ravel(both)[:n], np.ravel(both)[n:]
            moved = bordered.solve(-(self.M @ (v + σ * x) + self.D @ x))[0]
            return np.concatenate([moved, x + σ * moved])

        operator = LinearOperator((2 * n, 2 * n), matvec=inverted, dtype=float)
        start = inverted(inverted(np.concatenate([self.start, self.start])))
        wanted = min(2 * count + 2, 2 * n - 2)
        μ, vectors = eigs(operator, wanted, v0=start, ncv=min(2 * n, max(2 * wanted + 10, 40)))
        values = σ + 1.0 / μ
        grain = np.sqrt(THRESHOLDS.rounding) * σ
        values = np.where(np.abs(values) <= grain, 0.0, values)
        upper = np.flatnonzero(values.imag >= -THRESHOLDS.rounding * np.abs(values))
        upper = upper[np.argsort(np.abs(values[upper]), kind="stable")][:count]
        return values[upper], vectors[:n, upper]


# --- Words on modes ---------------------------------------------------------------------------------------------------
# The states that take part, and notes on the reference.


#: The most dry frictions that are named.
MOST_HELD = 8
#: The coordinates in which frequencies hold away from balance, in words.
COORDINATES = "shifts and turns of the bodies on the tangent space, which turns along the motion as little as it can"


def states_in(modes: Modes, mode: int) -> str:
    """Return the states of elements with the largest part in a mode: "state 'current'"."""
    names, share = modes.reference.system.names.states, modes.state_share[mode]
    return " and ".join(f"state '{names[index]}'" for index in leading(share))


def notes_on(modes: Modes) -> list[str]:
    """Return the notes that a reader of the frequencies needs."""
    return list(_notes(modes))


def _notes(modes: Modes) -> Iterator[str]:
    reference = modes.reference
    if not is_balanced(reference):
        off = reference.imbalance
        yield (
            f"forces do not balance here: up to {off.force:.3g} N and {off.torque:.3g} N m are left "
            f"({off.relative:.2g} of the largest); frequencies then depend on the coordinates: {COORDINATES}"
        )
    if unsteady := unsteady_states(reference):
        yield unsteady
    if reference.held:
        names = shortened([f"'{name}'" for name in reference.held], MOST_HELD)
        yield f"dry friction holds its coordinates as they are: {names}"
    if modes.turns:
        yield "the mechanism moves: these are the modes of this instant, and hold for as long as it hardly moves"


def unsteady_states(reference: LinearReference) -> str:
    """Return the note that states of elements change at a reference, with their rates; "" where they do not."""
    system = reference.system
    if not system.states.size:
        return ""
    instant = reference.motion.instant(system)
    rates, terms = state_rates(instant), np.abs(channel_slopes(instant)[1]) @ np.abs(instant.channels)
    size = terms + np.abs(state_slopes(instant)) @ system.states.scale
    changing = np.flatnonzero(np.abs(rates) > THRESHOLDS.dependent * size)
    named = zip(system.names.states, rates.tolist(), system.names.state_units, strict=True)
    told = [f"'{name}' by {rate:.3g} {unit}/s" for name, rate, unit in named]
    return f"states change here: {', '.join(told[k] for k in changing[:MOST_HELD])}" if len(changing) else ""


def is_balanced(reference: LinearReference) -> bool:
    """Return whether the forces balance to round-off."""
    return reference.imbalance.relative <= THRESHOLDS.dependent


# --- Modes traced over a parameter ------------------------------------------------------------------------------------
# Root loci and Campbell diagrams. Each mode is followed from value to value.


@dataclass(frozen=True, eq=False)
class RootLocus:
    """Eigenvalues (p, j) at the p `values` of the parameter `name`, one column a mode; NaN where the mode does not
    exist."""

    name: str
    values: Array
    eigenvalues: Numbers


def trace(name: str, values: Sequence[float], at: Callable[[float], Modes]) -> tuple[RootLocus, Modes]:
    """Return the trace of the modes at each value, computed by `at`, and the modes at the last value."""
    columns: list[list[complex]] = []
    place: list[int] = []
    before: Modes | None = None
    for number, value in enumerate(values):
        here = at(value)
        place = _places(before, here, place, len(columns))
        columns += [[np.nan] * number for _ in range(max(place, default=-1) + 1 - len(columns))]
        by_column = dict(zip(place, here.eigenvalues.tolist(), strict=True))
        for column, entries in enumerate(columns):
            entries.append(by_column.get(column, complex(np.nan, np.nan)))
        before = here
    assert before is not None
    eigenvalues = np.array(columns, dtype=complex).reshape(len(columns), len(values)).T
    return RootLocus(name, np.array(values, dtype=float), eigenvalues), before


def _places(before: Modes | None, here: Modes, place: list[int], columns: int) -> list[int]:
    """Return the column of each mode: that of the previous mode most like it in eigenvalue and shape."""
    if before is None:
        return list(range(len(here.eigenvalues)))
    from scipy.optimize import linear_sum_assignment

    speed = np.abs(before.eigenvalues[:, None]) + np.abs(here.eigenvalues) + np.finfo(float).tiny
    unlike = np.abs(before.eigenvalues[:, None] - here.eigenvalues) / speed + 1.0 - _likeness(before, here)
    rows, chosen = linear_sum_assignment(unlike)
    place_of = dict(zip(chosen.tolist(), (place[row] for row in rows), strict=True))
    fresh = iter(range(columns, columns + len(here.eigenvalues)))
    return [place_of[mode] if mode in place_of else next(fresh) for mode in range(len(here.eigenvalues))]


def _likeness(before: Modes, here: Modes) -> Array:
    """Return the modal assurance criterion of all pairs, 1 where shapes are alike (Allemang 2003)."""
    length = here.reference.system.length
    shapes = [each.shapes.reshape(len(each.shapes), -1, 6) / ([length] * 3 + [1.0] * 3) for each in (before, here)]
    old, new = (shape.reshape(len(shape), -1) for shape in shapes)
    sizes = np.sum(np.abs(old) ** 2, axis=1)[:, None] * np.sum(np.abs(new) ** 2, axis=1)
    return np.asarray(np.abs(old.conj() @ new.T) ** 2 / np.maximum(sizes, np.finfo(float).tiny), dtype=float)


# --- Modes as their file stores them ----------------------------------------------------------------------------------
# For the bodies of the scene, where the computation has carriers.


def stored(modes: Modes, title: str, trace: RootLocus | None = None) -> StoredModes:
    """Return the content of `modes.h5`."""
    system, motion, names = modes.reference.system, modes.reference.motion, modes.reference.system.names
    pose = motion.pose
    return StoredModes(
        bodies=names.bodies,
        position=attached(pose, system.body_carrier, system.body_offset, np.ones(len(names.bodies))),
        orientation=product(pose.orientation[system.body_carrier], system.body_turn),
        coordinates=names.coordinates,
        coordinate_units=names.coordinate_units,
        coordinate=motion.expected,
        names=[modes.name(mode) for mode in range(len(modes.eigenvalues))],
        eigenvalue=modes.eigenvalues,
        frequency=modes.frequencies,
        damping_ratio=modes.damping_ratios,
        displacement=_of_bodies(modes),
        coordinate_shape=modes.coordinates,
        states=names.states,
        state_units=names.state_units,
        state_shape=modes.states,
        state_share=modes.state_share,
        kinetic_names=modes.kinetic_names,
        kinetic_share=modes.kinetic,
        strain_names=modes.strain_names,
        strain_share=modes.strain,
        varied=() if trace is None else (trace.name,),
        trace_value=np.zeros(0) if trace is None else trace.values,
        trace=np.zeros((0, 0), dtype=complex) if trace is None else trace.eigenvalues,
        where=modes.reference.where,
        time=motion.t,
        title=title,
        notes="\n".join(notes_on(modes)),
    )


def _of_bodies(modes: Modes) -> Numbers:
    """Shifts and turns of the scene's bodies, (k, N, 6)."""
    system, pose = modes.reference.system, modes.reference.motion.pose
    carried = modes.shapes[:, system.body_carrier]
    arm: Array = (pose.rotation[system.body_carrier] @ system.body_offset[..., None])[..., 0]
    shift = carried[..., :3] + np.cross(carried[..., 3:], arm)
    return np.concatenate([shift, carried[..., 3:]], axis=-1)
