"""The paper's projection methods: the correction of each, in the order of its equations.

A method keeps C = 0 and C' = 0 while an ordinary integrator runs. A new one is a class here and an entry of
`mbproj.base.registry.PROJECTIONS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, ClassVar, final

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.plugins import blamed
from mbproj.base.registry import PROJECTIONS, ProjectionEntry
from mbproj.base.settings import ProjectionSettings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.constraints import constraint, jacobian, position_grain, time_derivative
from mbproj.equations.kinematics import Pose, pose_of
from mbproj.equations.motions import NO_DRIVE, Drive
from mbproj.equations.of_motion import mass_matrix
from mbproj.equations.rank.row_policy import RowSet
from mbproj.model.system import System


class Method(ABC):
    """A way to suppress the violation of the constraints. Its options are the fields of the final classes."""

    #: Whether the accelerations need C and C', as in Baumgarte's method.
    stabilises: ClassVar[bool] = False

    @abstractmethod
    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        """Return γ (m,) with this method's terms in the violations C and C' (m,): unchanged unless the method
        `stabilises`."""


class Projection(Method):
    """A method that moves a violating state back to the constraints after a step: Eqs. 39-74."""

    #: Whether the velocity correction removes the violation only in the limit (a penalty), so that it is iterated.
    iterates_velocity: ClassVar[bool] = False

    @final
    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        return gamma

    @abstractmethod
    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return Δ (7n,) with C_q Δ = -violation, the smallest in this method's metric, from M (7n, 7n), C_q (m, 7n).

        The same formula corrects q (violation C) and q' (violation C'). Raises LinAlgError where it does not exist.
        """

    def refusal(self, M: Array) -> str | None:
        """Return why this method cannot be used with the mass matrix M, and which can; None where it can."""
        return None


def weighted_correction(A: Array, C_q: Array, violation: Array) -> Array:
    """Return -A⁻¹C_qᵀ (C_q A⁻¹ C_qᵀ)⁻¹ violation, Eq. 28: the smallest Δ in the norm of A with C_q Δ = -violation."""
    X = np.linalg.solve(A, C_q.T)
    return -X @ np.linalg.solve(C_q @ X, violation)


@final
@dataclass(frozen=True)
class Unprojected(Method):
    """Direct integration of Eq. 14, in which the constraints drift. It is there to show the drift."""

    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        return gamma


@final
@dataclass(frozen=True)
class Baumgarte(Method):
    """Baumgarte's stabilisation (ref. 9): C'' + 2αC' + β²C = 0 in place of C'' = 0. `gains` (α, β) in 1/s; the paper
    takes 25 for both. Critically damped where α = β."""

    gains: tuple[float, float]

    stabilises = True

    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        alpha, beta = self.gains
        return gamma - 2.0 * alpha * C_dot - beta**2 * C


@final
@dataclass(frozen=True)
class Gopm(Projection):
    """GOPM, the geometrical orthogonal projection (Eqs. 37-41): the smallest correction of the coordinates, A = I.
    Metres and Euler parameters are summed as they stand: the result depends on the unit of length."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 39 and 41."""
        return -C_q.T @ np.linalg.solve(C_q @ C_q.T, violation)


@final
@dataclass(frozen=True)
class Popm(Projection):
    """POPM, the physical orthogonal projection (Eqs. 42-45): weighted by M, which must be positive definite."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 44 and 45."""
        return weighted_correction(M, C_q, violation)

    def refusal(self, M: Array) -> str | None:
        eigenvalues = np.linalg.eigvalsh(M)
        if eigenvalues[0] > len(M) * np.finfo(float).eps * eigenvalues[-1]:
            return None
        return (
            "'popm' needs a positive definite mass matrix, and with Euler parameters M is singular (Eq. 12); "
            "use 'gpopm': it is the physical correction for singular M, and equals 'popm' where M is definite (Eq. 75)"
        )


@final
@dataclass(frozen=True)
class MassOrthogonal(Projection):
    """The mass-orthogonal projection of Bayo and Ledesma as Blajer writes it (Eqs. 48-55). Penalty factor `alpha`, 1e7
    in ref. 28. A pass leaves of order 1/α of the violation, so both levels iterate."""

    alpha: float

    iterates_velocity: ClassVar[bool] = True

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 52 and 55, with A_α of Eq. 53."""
        A_alpha = M + self.alpha * (C_q.T @ C_q)
        return np.linalg.solve(A_alpha, -self.alpha * (C_q.T @ violation))


@final
@dataclass(frozen=True)
class Mmopm(Projection):
    """MMOPM, the modified mass-orthogonal projection (Eqs. 56-61): weighted by M + α C_qᵀC_q. Penalty factor `alpha`,
    1e7 in the paper. By Eq. 78 the result does not depend on it; the round-off does."""

    alpha: float

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 60 and 61, with A_α of Eq. 53."""
        return weighted_correction(M + self.alpha * (C_q.T @ C_q), C_q, violation)


@final
@dataclass(frozen=True)
class GpopmPinv(Projection):
    """GPOPM by the Moore-Penrose inverse of the bordered matrix (Eqs. 62-66).

    Eq. 63 as printed, (DᵀD)⁻¹Dᵀ, does not exist because D = EME is singular. Its Moore-Penrose inverse is computed here
    from its eigenvalues; those of the admissible motions, 7n - m of them, differ from zero."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 65 and 66, -(C_q⁺ - P M C_q⁺) violation with P = D⁺. Raises LinAlgError where
        the rank of D is too small."""
        C_plus = np.linalg.solve(C_q @ C_q.T, C_q).T
        E = np.eye(len(M)) - C_plus @ C_q
        geometric = C_plus @ violation
        return _pseudo_inverse(E @ M @ E, len(M) - len(C_q)) @ (M @ geometric) - geometric


def _pseudo_inverse(D: Array, rank: int) -> Array:
    """Return D⁺ of a symmetric semi-definite D of known `rank`, which is checked against the eigenvalues."""
    eigenvalues, vectors = np.linalg.eigh(0.5 * (D + D.T))
    nonzero, V = eigenvalues[len(D) - rank :], vectors[:, len(D) - rank :]
    if rank and nonzero[0] <= len(D) * np.finfo(float).eps * nonzero[-1]:
        raise np.linalg.LinAlgError("D = EME has a smaller rank than the degrees of freedom (Eq. 20 does not hold)")
    return (V / nonzero) @ V.T


@final
@dataclass(frozen=True)
class Gpopm(Projection):
    """GPOPM, the generalised physical orthogonal projection (Eqs. 67-74): the smallest correction in the energy norm
    ΔᵀMΔ, though M is singular. It exists where Eq. 20 holds and C_q has full rank."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 73 and 74, with A1 of Eq. 72."""
        return weighted_correction(M + C_q.T @ C_q, C_q, violation)


# --- The projection of a state, Eqs. 37-74 ----------------------------------------------------------------------------
# When it is due, and the iteration to C = 0 with any method's correction.
# Where the full correction does not reduce the violation, or turns a body too far for its linearised rows, smaller
# ones are tried in turn. A metric by masses turns bodies of small inertia by large angles to avoid motions of heavy
# bodies. The smallest correction that turns no body by more than ϑ is that of a metric with moments of inertia added
# to such bodies: min ½ΔᵀMΔ subject to C_q Δ = -C and |δθ_b| <= ϑ has the conditions (M + Σ μ_b E_b) Δ + C_qᵀλ = 0,
# with μ_b >= 0 where the bound holds (a trust region: Conn, Gould & Toint 2000, sect. 7). It closes the rows to first
# order, with an error of order ϑ², so that some ϑ reduces the violation wherever C_q has full rank.


@dataclass(frozen=True, eq=False)
class ProjectedState:
    """The state (q, v) after a projection, and counts: whether it was projected, passes at both levels, positions that
    did not meet their test, and uses of the fallback.

    `left_open`: the violation of rows that were not held, near a singular pose, in units of the mechanism's length.
    `nearest`: the smallest distance of the poses from a singular one, as a part of the largest of the run."""

    q: Array
    v: Array
    projections: int = 0
    position_iterations: int = 0
    velocity_iterations: int = 0
    failures: int = 0
    fallbacks: int = 0
    left_open: float = 0.0
    nearest: float = 1.0


@dataclass(frozen=True, eq=False)
class Position:
    """q after a projection, the passes taken, whether the stop test was met, and whether the fallback was needed.
    `left_open` and `nearest` are those of `ProjectedState`."""

    q: Array
    passes: int
    met: bool
    fell_back: bool = False
    left_open: float = 0.0
    nearest: float = 1.0


def project_after(
    step: int,
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    q: Array,
    v: Array,
    drive: Drive = NO_DRIVE,
    rows: RowSet | None = None,
) -> ProjectedState:
    """Return the state (q, v) after step number `step` (from 1), projected if it is due. It is due at every k-th step;
    with a threshold only for levels whose violation exceeds it, and for velocities always after a moved position.

    `drive` holds the motions' values at the time of the state, where the system has any. `rows` decides which rows are
    held; all of them without it."""
    rows = rows or RowSet.regular(system)
    if step % settings.every:
        return ProjectedState(q, v)
    position, velocity = settings.position, settings.velocity
    if settings.threshold is not None:
        pose = pose_of(q)
        position = position and float(np.abs(constraint(system, pose, drive)).max()) > settings.threshold
        excess = float(np.abs(jacobian(system, pose) @ v + time_derivative(system, drive)).max()) > settings.threshold
        velocity = velocity and (position or excess)
    if not (position or velocity):
        return ProjectedState(q, v)
    closed = correct_position(system, method, settings, rows, q, drive) if position else Position(q, 0, met=True)
    passes, nearest = 0, closed.nearest
    if velocity:
        v, passes, nearness = correct_velocity(system, method, settings, rows, pose_of(closed.q), v, drive)
        nearest = min(nearest, nearness)
    counts = 1, closed.passes, passes, int(not closed.met), int(closed.fell_back)
    return ProjectedState(closed.q, v, *counts, closed.left_open, nearest)


def correct_velocity(
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    rows: RowSet,
    pose: Pose,
    v: Array,
    drive: Drive = NO_DRIVE,
) -> tuple[Array, int, float]:
    """Return v with C_q v + C_t = 0 at this pose, the number of passes, and the pose's distance from a singular one.
    One pass is enough (Eq. 46), except for a penalty method."""
    M, held, C_t = mass_matrix(system, pose), rows.to_move(pose, drive), time_derivative(system, drive)
    C_t = held.combined(C_t)
    C_dot = held.C_q @ v + C_t
    for passes in range(settings.max_iterations):
        v = v + method.correction(M, held.C_q, C_dot)
        previous, C_dot = C_dot, held.C_q @ v + C_t
        if not method.iterates_velocity or not np.abs(C_dot).max() < 0.5 * np.abs(previous).max():
            return v, passes + 1, held.nearness
    return v, settings.max_iterations, held.nearness


def correct_position(
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    rows: RowSet,
    q: Array,
    drive: Drive = NO_DRIVE,
) -> Position:
    """Return q with C(q) = 0 by the chosen test. Where the method does not converge, GOPM's metric is used if
    allowed."""
    correct = _by_violation if settings.test == "violation" else _by_paper
    corrected = correct(system, method, settings, rows, q, drive)
    if corrected.met or settings.fallback == "none":
        return corrected
    again = _by_violation(system, Gopm(), settings, rows, q, drive)
    nearest = min(corrected.nearest, again.nearest)
    return replace(again, passes=corrected.passes + again.passes, fell_back=True, nearest=nearest)


def _by_violation(
    system: System, method: Projection, settings: ProjectionSettings, rows: RowSet, q: Array, drive: Drive
) -> Position:
    """Iterate until |C| <= tolerance in every row.

    Of the corrections to try, the first is taken that reduces the violation by half of the reduction that Newton's
    method promises. Where none does, round-off is reached, or the iteration does not converge."""
    pose = pose_of(q)
    C, left_open, nearest = constraint(system, pose, drive), 0.0, 1.0
    tolerances = row_tolerances(system, settings, pose)
    for passes in range(settings.max_iterations):
        if np.all(np.abs(C) <= tolerances):
            return Position(q, passes, met=True, nearest=nearest)
        held = rows.to_close(pose, C)
        nearest = min(nearest, held.nearness)
        left_open = held.open(C)
        if left_open and np.all(np.abs(held.closes(C)) <= tolerances):
            return Position(q, passes, met=True, left_open=left_open, nearest=nearest)
        grains = THRESHOLDS.round_off_grains * position_grain(system, pose)
        last = bool(np.all(np.abs(C) <= np.maximum(grains, tolerances)))
        left = _scaled(system, pose, held.closes(C))
        for change, part in damped(method, mass_matrix(system, pose), held.C_q, held.combined(C), q):
            pose = pose_of(q + change)
            C = constraint(system, pose, drive)
            if _scaled(system, pose, held.closes(C)) < (1.0 - 0.5 * part) * left:
                break
            if last:
                return Position(q, passes + 1, met=True, left_open=left_open, nearest=nearest)
        else:
            return Position(q, passes + 1, met=False, left_open=left_open, nearest=nearest)
        q = q + change
    met = bool(np.all(np.abs(C) <= tolerances))
    return Position(q, settings.max_iterations, met=met, left_open=left_open, nearest=nearest)


def _scaled(system: System, pose: Pose, C: Array) -> float:
    """Return the largest |C| of the rows that are open by more than round-off, in units of the mechanism's length. Rows
    at the end of a long chain close only to round-off, which must not decide on a correction at its beginning."""
    beyond = ~(np.abs(C) <= THRESHOLDS.closed_grains * position_grain(system, pose))
    return float(np.max(np.abs(C / system.row_scale), where=beyond, initial=0.0))


def _by_paper(
    system: System, method: Projection, settings: ProjectionSettings, rows: RowSet, q: Array, drive: Drive
) -> Position:
    """Iterate until ΔqᵀMΔq + CᵀC <= tolerance: the paper's test (sect. 5) in the metric of Eq. 72. M alone is singular
    along Λ, so that its length would not count."""
    tolerance = THRESHOLDS.paper_tolerance if settings.tolerance is None else settings.tolerance
    nearest = 1.0
    for passes in range(settings.max_iterations):
        pose = pose_of(q)
        M, C = mass_matrix(system, pose), constraint(system, pose, drive)
        held = rows.to_close(pose, C)
        nearest = min(nearest, held.nearness)
        change = method.correction(M, held.C_q, held.combined(C))
        q = q + change
        if change @ M @ change + C @ C <= tolerance:
            return Position(q, passes + 1, met=True, left_open=held.open(C), nearest=nearest)
    return Position(q, settings.max_iterations, met=False, nearest=nearest)


def row_tolerances(system: System, settings: ProjectionSettings, pose: Pose) -> Array:
    """Return the tolerance of each row of C, (m,): that of the settings, or max(1e-13, 4 ε × the largest coordinate in
    the row)."""
    if settings.tolerance is not None and settings.test == "violation":
        return np.full(system.constraints, settings.tolerance)
    return np.maximum(
        THRESHOLDS.closed_to * np.minimum(1.0, system.row_scale),
        THRESHOLDS.closed_grains * position_grain(system, pose),
    )


def damped(method: Projection, M: Array, C_q: Array, violation: Array, q: Array) -> Iterator[tuple[Array, float]]:
    """Yield corrections Δ (7n,) of q (7n,) for a violation (m,), each with the part of it that Δ closes to first order.

    The first is the method's correction, unless it turns a body too far. The next are the smallest in its metric with
    ever tighter limits on turns. After these, or where the metric cannot limit turns, the method's correction is
    shortened."""
    whole = method.correction(M, C_q, violation)
    widest = _widest(whole, q)
    limit = THRESHOLDS.widest_turn
    if widest <= limit:
        yield whole, 1.0
        limit = THRESHOLDS.tighter * widest
    for _ in range(THRESHOLDS.most_halvings):
        change = _turning_less(method, M, C_q, violation, q, limit)
        if change is None:
            break
        yield change, 1.0
        limit = THRESHOLDS.tighter * min(limit, _widest(change, q))
    part = min(0.5, THRESHOLDS.widest_turn / widest) if widest > 0.0 else 0.5
    while part >= 0.5**THRESHOLDS.most_halvings:
        yield part * whole, part
        part *= 0.5


def _turning_less(method: Projection, M: Array, C_q: Array, violation: Array, q: Array, limit: float) -> Array | None:
    """Return a correction, nearly the smallest in energy, that turns no body by more than `limit` (rad). Return None
    where moments of inertia do not limit turns: in GOPM's metric, or where the rows prescribe the turn."""
    if not limit > 0.0:
        return None
    Λ = q.reshape(-1, 7)[:, 3:]
    index = np.arange(len(Λ))
    across = 4.0 * (np.eye(4) - Λ[:, :, None] * Λ[:, None, :] / np.sum(Λ * Λ, axis=-1)[:, None, None])
    blocks = M.reshape(len(Λ), 7, len(Λ), 7)
    moment = np.einsum("bibi->b", blocks[:, 3:, :, 3:]) / 12.0
    moment = np.maximum(moment, THRESHOLDS.lent_part * moment.mean())
    added, before = np.zeros(len(Λ)), None
    for _ in range(THRESHOLDS.most_passes):
        stiff = blocks.copy()
        stiff[index, 3:, index, 3:] += added[:, None, None] * across
        try:
            change = method.correction(stiff.reshape(M.shape), C_q, violation)
        except np.linalg.LinAlgError:
            return None
        turns = _turns(change, q)
        if np.all(turns <= limit):
            return change
        if before is not None and np.array_equal(change, before):
            return None
        added = np.where(turns > limit, added + THRESHOLDS.stiffer * (moment + added) * turns / limit, added)
        before = change
    return None


def _turns(change: Array, q: Array) -> Array:
    """Return the turn of each body by a change of q, (n,), to first order: 2 |ΔΛ| across Λ."""
    Λ, ΔΛ = q.reshape(-1, 7)[:, 3:], change.reshape(-1, 7)[:, 3:]
    across = ΔΛ - np.sum(ΔΛ * Λ, axis=-1, keepdims=True) * Λ
    return np.asarray(2.0 * np.linalg.norm(across, axis=-1))


def _widest(change: Array, q: Array) -> float:
    return float(_turns(change, q).max())


# --- `register_projection` --------------------------------------------------------------------------------------------
# Adds a user's projection method, which runs in the full formulation and in all studies.


#: The options that a scene may give to a method.
OPTIONS = ("alpha", "gains")


def register_projection(
    name: str, method: type[Method], *, summary: str, equations: str = "", options: Sequence[str] = ()
) -> None:
    """Add a projection method to those that a scene may name.

    `method` is a class derived from `Projection`, made with its `options` as arguments, which are among "alpha" and
    "gains". `summary` is the line that describes it, `equations` its source. Raises InputError where the name is taken
    or not a valid one, and TypeError where `method` is no such class.
    """
    if not (isinstance(method, type) and issubclass(method, Method)):
        raise TypeError(f"a projection method is a class derived from mbproj.Projection, found {method!r}")
    missing = sorted(getattr(method, "__abstractmethods__", ()))
    if missing:
        raise TypeError(f"{method.__name__} has no method '{missing[0]}'")
    for option in options:
        if option not in OPTIONS:
            raise InputError(Problem(f"a method has no option '{option}'", hint=f"options are: {', '.join(OPTIONS)}"))
    factory = _blamed(name, method)
    entry = ProjectionEntry("", equations, summary, tuple(options), not method.stabilises, factory=factory)
    PROJECTIONS.add(name, entry, method)


#: The symbols of what the formulas of a method return.
SYMBOLS = {"correction": "Δ", "stabilised": "γ"}


def _real(symbol: str, value: object, shape: tuple[int, ...]) -> Array:
    """Return the numbers that a formula returned as an array. Raises TypeError or ValueError where they are not real
    numbers in this shape: a cast would drop imaginary parts."""
    numbers = np.asarray(value)
    if numbers.shape != shape:
        raise ValueError(f"{symbol} has the shape {numbers.shape}, not {shape}")
    if numbers.dtype.kind not in "fiu":
        raise TypeError(f"{symbol} has numbers of the type {numbers.dtype}, which are not real")
    return numbers.astype(float, copy=False)


def _blamed(name: str, method: type[Method]) -> Callable[..., Method]:
    """Return a factory of the method; errors of the method name it. LinAlgError means that a correction does not
    exist."""

    def guarded(formula: str) -> Callable[..., Any]:
        def call(self: Any, *arguments: Array) -> Any:
            with blamed(f"'{formula}' of projection method '{name}'", np.linalg.LinAlgError):
                value = getattr(method, formula)(self, *arguments)
                if formula in SYMBOLS:
                    like = arguments[1][0] if formula == "correction" else arguments[0]
                    numbers = _real(SYMBOLS[formula], value, like.shape)
                    if not np.isfinite(numbers).all() and all(np.isfinite(each).all() for each in arguments):
                        raise ValueError("it returns numbers that are not finite")
                    return numbers
                if not (value is None or isinstance(value, str)):
                    raise TypeError(f"it returns {value!r}, which is no text and not None")
                return value

        return call

    formulas = ("correction", "refusal") if issubclass(method, Projection) else ("stabilised",)
    subclass: type[Method] = type(method.__name__, (method,), {formula: guarded(formula) for formula in formulas})

    def make(**options: Any) -> Method:
        with blamed(f"projection method '{name}'"):
            return subclass(**options)

    return make


# --- Projection -------------------------------------------------------------------------------------------------------
# The methods, and the iteration to C = 0. `make_method` finds one by its name.


#: The methods above by the names of their classes, which `PROJECTIONS` has.
METHODS = {name: kind for name, kind in [*vars().items()] if isinstance(kind, type) and issubclass(kind, Method)}


def make_method(settings: ProjectionSettings) -> Method:
    """Return the method that the settings name, made with its options from them (`ProjectionEntry.options`)."""
    entry = PROJECTIONS[settings.method]
    make = entry.factory or METHODS[entry.name]
    method: Method = make(**{option: getattr(settings, option) for option in entry.options})
    return method
