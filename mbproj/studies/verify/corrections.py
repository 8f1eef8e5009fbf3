"""Checks of the projections: POPM = GPOPM (Eq. 75), no influence of α (Eq. 78), idempotent, orthogonal, and the
kernel's correction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.constraints import constraint, jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import drive_at
from mbproj.equations.of_motion import mass_matrix, tangent_mass_matrix
from mbproj.model.euler_parameters import matrix_L
from mbproj.motion.projection import Projection, make_method
from mbproj.studies.verify.case import Case, Finding, Found, difference, worse
from mbproj.studies.verify.equations import Rounded, correction, penalised

#: Penalties α of Eq. 78: from weak ones to that of ref. 28.
ALPHAS = (1e-3, 1e3, 1e7)
#: Size of the displacement that opens the joints for the kernel's correction, in the mechanism's length and rad.
OPENED = 1e-3
#: The weight A of each method, in whose norm its corrections are smallest: the identity, or M.
METRICS: Mapping[str, str] = MappingProxyType({"gopm": "I", "gpopm": "M"})


def popm_is_gpopm(case: Case) -> Found:
    """Compare POPM's correction with GPOPM's in (δr, δθ), where M is diag(m I, J) (Eq. 75)."""
    if case.indefinite:
        return case.indefinite
    M, G, violation = _tangent(case)
    if not len(G.value):
        return "no joints: nothing to correct"
    popm, gpopm = (_method(name).correction(M.value, G.value, violation) for name in ("popm", "gpopm"))
    bound = (
        correction(M, G, Rounded.exact(violation)).error
        + correction(penalised(M, G, 1.0), G, Rounded.exact(violation)).error
    )
    return difference(popm, gpopm, bound, np.tile([case.system.length] * 3 + [1.0] * 3, case.system.bodies))


def no_alpha(case: Case) -> Found:
    """Compare MMOPM's correction for several α with GPOPM's (Eq. 78), each to the round-off that its α brings."""
    M, C_q, violation = _with_violation(case)
    known = _method("gpopm").correction(M.value, C_q.value, violation.value)
    rounding = correction(penalised(M, C_q, 1.0), C_q, violation).error
    differences, departures = [], []
    for alpha in ALPHAS:
        other = _method("mmopm", alpha=alpha).correction(M.value, C_q.value, violation.value)
        bound = correction(penalised(M, C_q, alpha), C_q, violation).error + rounding
        differences.append(difference(other, known, bound, _scale(case)))
        departures.append(f"{np.abs((other - known) / _scale(case)).max():.0e} at α = {alpha:.0e}")
    return _remarked(worse(differences), f"departs by {', '.join(departures)}")


def idempotent(case: Case) -> Found:
    """Check that v -> v + correction(C_q v) is a projector: a second correction changes nothing but round-off."""
    equations, v = case.equations, case.displacement
    M, C_q = Rounded.exact(equations.M.value), Rounded.exact(equations.C_q.value)
    differences = []
    for name, A in _weights(M, C_q):
        first = _method(name).correction(M.value, C_q.value, C_q.value @ v)
        left = C_q @ Rounded.exact(v + first)
        # In exact arithmetic nothing is left to correct. The second correction acts on the round-off of the first.
        error = correction(A, C_q, C_q @ Rounded.exact(v)).error
        missed = left.error + np.abs(C_q.value) @ error
        second = _method(name).correction(M.value, C_q.value, left.value)
        gain = correction(A, C_q, Rounded(np.zeros(len(left.value)), missed)).error
        whole = float(np.abs(first / _scale(case)).max())
        differences.append(difference(second, np.zeros_like(second), gain, _scale(case), whole))
    return worse(differences)


def orthogonal(case: Case) -> Found:
    """Check that A Δ is orthogonal to the motions that C_q allows (Eqs. 38 and 43), with A = I for GOPM and M for
    GPOPM."""
    M, C_q, violation = _with_violation(case)
    rows, columns = C_q.value.shape
    if rows == columns:
        return "no degree of freedom: there are no motions to be orthogonal to"
    Z = np.linalg.svd(C_q.value)[2][rows:].T
    # The residual C_q Z, mapped back onto the null space, is the error of Z itself.
    left = Rounded.exact(C_q.value) @ Rounded.exact(Z)
    off = np.abs(np.linalg.pinv(C_q.value)) @ (left.error + np.abs(left.value))
    differences = []
    for name, weight in METRICS.items():
        A = Rounded.exact(np.eye(columns) if weight == "I" else M.value)
        change = _method(name).correction(M.value, C_q.value, violation.value)
        bounded = Rounded(change, correction(_weight(name, M, C_q), C_q, violation).error)
        parts = Rounded(Z.T, off.T) @ (A @ bounded)
        whole = float((np.abs(Z.T) @ np.abs(A.value @ change)).max())
        differences.append(difference(parts.value, np.zeros_like(parts.value), parts.error, 1.0, whole))
    return worse(differences)


def kernel_correction(case: Case) -> Found:
    """Compare one exact correction of an open pose by GPOPM: the kernel's block Cholesky with Eq. 73."""
    if isinstance(case.reduced, str):
        return case.reduced
    if case.redundant:
        return "redundant joints: once they are open, no correction closes them all"
    system, q = case.system, case.state.q + OPENED * case.displacement
    q = q.reshape(-1, 7)
    q[:, 3:] /= np.linalg.norm(q[:, 3:], axis=1, keepdims=True)
    q = q.ravel()
    pose, drive = pose_of(q), drive_at(system, case.state.t)
    M, C_q = (
        Rounded(value, 8.0 * np.finfo(float).eps * np.abs(value))
        for value in (mass_matrix(system, pose), jacobian(system, pose))
    )
    C = constraint(system, pose, drive)
    if not len(C) > system.bodies:
        return "no joints: nothing to correct"
    reach = max(system.length, float(np.abs(q.reshape(-1, 7)[:, :3]).max()))
    violation = Rounded(C, 8.0 * np.finfo(float).eps * np.where(system.row_scale == 1.0, 1.0 + reach, reach))
    bounded = correction(penalised(M, C_q, 1.0), C_q, violation)
    expected = q + _method("gpopm").correction(M.value, C_q.value, C)
    expected.reshape(-1, 7)[:, 3:] /= np.linalg.norm(expected.reshape(-1, 7)[:, 3:], axis=1, keepdims=True)
    moved = case.reduced.equations(ProjectionSettings(method="gpopm")).newton(
        case.reduced.state(q, case.state.v), case.state.t
    )
    corrected = np.asarray(moved)[:, :7].ravel()
    largest = np.tile([reach] * 3 + [1.0] * 4, system.bodies)
    bound = 2.0 * bounded.error + 8.0 * np.finfo(float).eps * largest
    return difference(corrected, expected, bound, _scale(case), float(np.abs(bounded.value / _scale(case)).max()))


def _method(name: str, alpha: float | None = None) -> Projection:
    """The projection method of this name, which must be one that corrects."""
    method = make_method(ProjectionSettings(method=name, alpha=alpha))
    assert isinstance(method, Projection)
    return method


def _weight(name: str, M: Rounded, C_q: Rounded) -> Rounded:
    """The matrix A of Eq. 28 that a method solves with."""
    return Rounded.exact(np.eye(len(M.value))) if name == "gopm" else penalised(M, C_q, 1.0)


def _weights(M: Rounded, C_q: Rounded) -> Iterator[tuple[str, Rounded]]:
    for name in METRICS:
        yield name, _weight(name, M, C_q)


def _with_violation(case: Case) -> tuple[Rounded, Rounded, Rounded]:
    """M and C_q, taken as exact, and the violation that `displacement` makes."""
    M, C_q = Rounded.exact(case.equations.M.value), Rounded.exact(case.equations.C_q.value)
    return M, C_q, Rounded.exact(C_q.value @ case.displacement)


def _tangent(case: Case) -> tuple[Rounded, Rounded, Array]:
    """M and the rows in (δr, δθ in body axes), (m, 6n), without the norm rows, and a violation."""
    system, n = case.system, case.system.bodies
    C_q = case.equations.C_q.value[case.equations.rows >= n].reshape(-1, n, 7)
    L = matrix_L(case.state.q.reshape(-1, 7)[:, 3:])
    G = np.concatenate([C_q[..., :3], 0.5 * np.einsum("mnp,nip->mni", C_q[..., 3:], L)], axis=-1).reshape(-1, 6 * n)
    M = tangent_mass_matrix(system, pose_of(case.state.q))
    shift = np.random.default_rng(1).normal(size=6 * n) * np.tile([system.length] * 3 + [1.0] * 3, n)
    return Rounded.exact(M), Rounded.exact(G), G @ shift


def _scale(case: Case) -> Array:
    """The unit of each coordinate, (7n,): the mechanism's length for positions, 1 for Euler parameters."""
    return np.tile([case.system.length] * 3 + [1.0] * 4, case.system.bodies)


def _remarked(finding: Found, remark: str) -> Found:
    return Finding(finding.measured, finding.allowed, remark) if isinstance(finding, Finding) else finding
