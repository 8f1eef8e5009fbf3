"""Steps of a mechanism without degrees of freedom, for the full formulation.

Joints and motions alone determine the poses. At each stage Newton's method closes the pose that the earlier stages
predict, and velocities and accelerations follow from the equations. Only the work of forces and states of elements are
integrated, by explicit stages. Newton's method may come to another assembly of the mechanism: a step is accepted only
where no stage leaves a doubt about that. A body at rest has velocities of exactly 0, because round-off would do work.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from mbproj.arrays import Array, Flags, Integers, may_overflow
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import tangent_jacobian
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.errors import SimulationError
from mbproj.integrate.steppers.runge_kutta import ExplicitRungeKutta, Extension, RightHandSide, Step
from mbproj.thresholds import THRESHOLDS


def branch_untold(t: float, where: str | None = None) -> SimulationError:
    """Return the error of a motion without degrees of freedom, where Newton's method may come to another branch, or to
    none, however short the step."""
    cause = (
        "what the motions prescribe cannot be followed beyond here: the mechanism is at a dead centre, or branches of "
        "its motion cross"
    )
    return SimulationError(t, cause, where=where, hint="turn back before, drive another joint, or change the lengths")


@dataclass(frozen=True, eq=False)
class KinematicSteps(ExplicitRungeKutta):
    """Kinematic steps with the tableau of an explicit method."""

    def attempt(self, f: RightHandSide, t: float, y: Array, h: float, first: Array) -> Step:
        """Return a step of size h; `first` is f(t, y). Raises SimulationError where the branch of the motion is not
        certain."""
        tableau, stages = self.tableau, np.empty((self.tableau.stages, len(y)))
        k = np.empty_like(stages)
        stages[0], k[0] = y, first
        with may_overflow():
            for s in range(1, tableau.stages):
                span = tableau.c[s] * h
                stages[s] = _closed_stage(f, t, span, y, y + h * (tableau.a[s, :s] @ k[:s]))
                k[s] = f(t + span, stages[s])
            y_new = _closed_stage(f, t, h, y, y + h * (tableau.b @ k))
            if _changes_sign(_formulation(f), y, y_new):
                raise branch_untold(t + h)
        return Step(t, h, y, y_new, k, stages=stages)

    def error(self, f: RightHandSide, t: float, step: Step) -> tuple[Step, Array]:
        """Return the step to t with f at its end, and the estimates of its local error (e, s) in states and works, as
        parts of their sizes.

        The size of a work is that of the bodies' inertial forces, weights and its own power. Round-off of the work
        before, or of a fall by the mechanism's length, counts as no error."""
        step, errors = super().error(f, t, step)
        formulation = _formulation(f)
        layout, stages = formulation.layout, step.stages
        assert stages is not None
        states, works = layout["states"], layout["quadratures"]
        size = layout.scale[states] + np.maximum(np.abs(step.y[states]), np.abs(step.y_new[states]))
        exchanged = [_exchanged(formulation, y, k) for y, k in zip(stages, step.k, strict=True)]
        work = step.h * float(np.abs(self.tableau.b) @ exchanged)
        system, tolerance = formulation.system, formulation.settings.tolerance or 1.0
        eps = float(np.finfo(float).eps)
        fall = float(system.mass.sum() * np.linalg.norm(system.gravity)) * system.length
        least = eps * (fall + np.abs(step.y_new[works])) / tolerance
        if _watches_sign(formulation):
            # Near a singular pose the error of works is the joints' violation over the squared distance.
            work *= max(1.0, THRESHOLDS.closed_to / (max(formulation.policy.nearest**2, eps) * tolerance))
        sizes = np.maximum(work, least)
        parts = np.hstack([errors[:, states] / size, errors[:, works] / np.where(sizes > 0.0, sizes, 1.0)])
        return step, parts if parts.shape[1] else np.zeros((1, 1))

    def extend(self, f: RightHandSide, step: Step) -> Extension:
        """Return the continuous extension of a step whose error was estimated."""
        tableau = self.tableau
        assert step.last is not None
        k = np.concatenate([step.k, step.last[None]])
        for row, c in zip(tableau.extra_a, tableau.extra_c, strict=True):
            closed = _closed_stage(f, step.t, c * step.h, step.y, step.y + step.h * (row[: len(k)] @ k))
            k = np.concatenate([k, f(step.t + c * step.h, closed)[None]])
        return Extension(step, tableau.dense.T @ k)

    def quadrature(self, step: Step) -> Iterator[tuple[float, Array]]:
        """The stages of a step, with the weights of its quadrature."""
        assert step.stages is not None
        for weight, y in zip(self.tableau.b, step.stages, strict=True):
            if weight:
                yield float(weight), y


def _formulation(f: Any) -> Any:
    """Return the full formulation of a right-hand side."""
    return f.formulation


def _closed_stage(f: RightHandSide, start: float, span: float, y: Array, predicted: Array) -> Array:
    """Return a stage on the constraints, `span` after the start of a step from y. Raises SimulationError where it is
    not certain to be on the branch of the motion on which the step began."""
    formulation, t = _formulation(f), start + span
    predicted = formulation.lead(t, predicted)
    stage, projected = formulation.project_copy(t, predicted)
    open_by, _ = formulation.violations(t, *formulation.split(stage))
    closed = not projected.failures and bool(np.all(open_by <= THRESHOLDS.lost_limit * formulation.system.row_scale))
    if not (np.isfinite(stage).all() and closed and _is_told(formulation, projected, span, y, predicted, stage)):
        raise branch_untold(t)
    if not drive_at(formulation.system, t).rate.any():
        stage[formulation.layout["velocities"]] = 0.0
    return stage


def _watches_sign(formulation: Any) -> bool:
    """Return whether signs of determinants are checked. Works alone, which jump between branches, keep steps so short
    that no other branch is in reach. Steps for states, by the scene's integrator, may be longer."""
    return bool(formulation.layout.size_of("states"))


def _changes_sign(formulation: Any, y: Array, y_new: Array) -> bool:
    """Return whether the determinant of a block of the joints' and motions' rows changes its sign in a step: Newton's
    method may have come to another branch.

    Along a branch it changes only where branches cross; where two branches meet, their signs differ (Allgower & Georg,
    Numerical Continuation Methods, 1990, sect. 8.1). Two blocks that change at once leave the determinant of the whole
    as it is."""
    if not _watches_sign(formulation) or _way(formulation, y, y_new) <= THRESHOLDS.crossed_way:
        return False
    system = formulation.system
    both = [tangent_jacobian(system.rows, pose_of(formulation.split(each)[0]))[:, :-1, :6] for each in (y, y_new)]
    G, G_new = (each.reshape(len(each), -1) for each in both)
    return any(
        np.linalg.slogdet(G[np.ix_(*block)])[0] * np.linalg.slogdet(G_new[np.ix_(*block)])[0] < 0.0
        for block in _irreducible_blocks(G, (both[0] != 0.0).any(axis=2))
    )


def _irreducible_blocks(G: Array, sees: Flags) -> list[tuple[Integers, Integers]]:
    """Return rows and columns of the irreducible blocks of G (m, 6n), with as many rows as are independent. `sees` (m,
    n): whether each row acts on a body. Each block is closed at once: a crank with its motion, then groups of Assur."""
    from scipy.linalg import qr
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

    rows = np.sort(qr(G.T, mode="r", pivoting=True)[1][: G.shape[1]])
    pattern = csr_matrix(np.repeat(sees[rows], 6, axis=1))
    column = maximum_bipartite_matching(pattern, perm_type="column")
    if len(rows) < G.shape[1] or (column < 0).any():
        return []
    count, label = connected_components(pattern[:, column], directed=True, connection="strong")
    return [(rows[label == block], column[label == block]) for block in range(count)]


def _is_told(formulation: Any, projected: Any, span: float, y: Array, predicted: Array, stage: Array) -> bool:
    """Return whether a stage is certain to be on its branch. The correction must be a small part of the way, and of the
    velocity, or so short that no other branch is in reach. Branches cross at an angle: where two are near, their
    velocities differ."""
    corrected, made = (_way(formulation, each, stage) for each in (predicted, y))
    before, after = (formulation.split(each)[1] for each in (predicted, stage))
    part, least = THRESHOLDS.told_part, THRESHOLDS.told_way
    if corrected <= part * made and formulation.change(before, after) <= part:
        return True
    moved = span * float(np.linalg.norm(_lengths(formulation, after - before)))
    return max(corrected - part * made, moved) <= least and projected.nearest >= THRESHOLDS.near_singular


def _way(formulation: Any, x: Array, y: Array) -> float:
    """Return the distance of all bodies between two states, in the mechanism's length."""
    return float(np.linalg.norm(_lengths(formulation, formulation.split(x)[0] - formulation.split(y)[0])))


def _lengths(formulation: Any, change: Array) -> Array:
    """Return a change of q or of q' (7n,), with lengths in units of the mechanism's, and turns in rad."""
    each = change.reshape(-1, 7)
    return np.hstack([each[:, :3] / formulation.system.length, 2.0 * each[:, 3:]])


def _exchanged(formulation: Any, y: Array, slope: Array) -> float:
    """Return the power that the bodies' inertial forces and weights exchange with forces at a stage, in W, with all
    terms taken as positive."""
    system, layout = formulation.system, formulation.layout
    q, v, _ = formulation.split(y)
    L, rate = pose_of(q).L[: system.bodies], slope[layout["velocities"]].reshape(-1, 7)
    speed = v.reshape(-1, 7)
    omega, alpha = (2.0 * np.einsum("bij,bj->bi", L, each[:, 3:]) for each in (speed, rate))
    sizes = [np.linalg.norm(each, axis=1) for each in (speed[:, :3], rate[:, :3], omega)]
    turned = [np.linalg.norm(np.einsum("bij,bj->bi", system.inertia, each), axis=1) for each in (alpha, omega)]
    weight = float(np.linalg.norm(system.gravity))
    inertial = system.mass * sizes[0] * (sizes[1] + weight) + sizes[2] * (turned[0] + sizes[2] * turned[1])
    return float(np.abs(slope[layout["quadratures"]][:2]).sum() + inertial.sum())
