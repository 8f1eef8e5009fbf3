"""Couplings of joint coordinates as sums: Σ kᵢ (sᵢ - sᵢ⁰) = f(s₀) - f(s₀⁰), counted from the start, where they hold."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.polynomial import Polynomial

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.export.start import Start
from mbproj.joints.joint_type import thread
from mbproj.scene.records import Joint

#: A function counts as a polynomial of the fourth degree where it differs from one by less than about this part of its
#: size.
SAME = 1e-12


@dataclass(frozen=True, eq=False)
class CouplingSum:
    """A coupling as a sum: `weights` kᵢ of coordinates by name. `curve` is f(s₀⁰ + d) - f(s₀⁰) as a polynomial of d of
    at most the fourth degree, None where there is no function; `first` is the name of s₀."""

    name: str
    weights: Mapping[str, float]
    first: str = ""
    curve: Polynomial | None = None


def sum_of(joint: Joint, start: Start) -> CouplingSum | None:
    """The sum of a coupling, or of a screw; None where its function is no such polynomial."""
    if joint.type == "screw":
        names = [f"{joint.name}.displacement", f"{joint.name}.angle"]
        return CouplingSum(joint.name, dict(zip(names, thread(joint.parameters["pitch"]).weights, strict=True)))
    assert joint.couples is not None
    of = dict(joint.couples.of)
    first = next(iter(of))
    if joint.couples.function is None:
        return CouplingSum(joint.name, of)
    curve = _polynomial(joint, start.values[first])
    weights = {name: weight for name, weight in of.items() if weight}
    return None if curve is None else CouplingSum(joint.name, weights, first, curve)


def _polynomial(joint: Joint, at: float) -> Polynomial | None:
    """The polynomial f(at + d) - f(at) through five points. None where f leaves it at one of ten others, which span
    more than a turn to both sides: a function with a dwell is no polynomial."""
    from mbproj.functions.curve import Curve

    assert joint.couples is not None and joint.couples.function is not None
    curve = Curve(joint.couples.function)

    def f(d: np.ndarray) -> np.ndarray:
        return np.asarray(curve(at + d)[0].real)

    d, others = np.array([-1.0, -0.5, 0.0, 0.5, 1.0]), np.array([-6.9, -4.1, -2.0, -0.8, -0.3, 0.2, 0.7, 2.0, 3.3, 7.1])
    with np.errstate(all="ignore"):
        values, wanted = f(d) - f(np.zeros(1)), f(others) - f(np.zeros(1))
    if not (np.isfinite(values).all() and np.isfinite(wanted).all()):
        return None
    polynomial = Polynomial.fit(d, values, 4).convert()
    scale = max(1.0, float(np.abs(wanted).max()))
    polynomial = Polynomial(np.where(np.abs(polynomial.coef) < SAME * scale, 0.0, polynomial.coef))
    return polynomial if np.abs(polynomial(others) - wanted).max() <= 100 * SAME * scale else None


def five(curve: Polynomial) -> Array:
    """The coefficients of a polynomial of the fourth degree at most, the constant first, (5,)."""
    coefficients = np.zeros(5)
    coefficients[: len(curve.coef)] = curve.coef
    return coefficients
