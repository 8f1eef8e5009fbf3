"""Long runs with the energy balance as a row of the velocity projection: the crank-rocker for 10,000 s.

    python scripts/long_energy.py [SECONDS]     errors of the crank's angle beside evaluations, at fixed steps

The reference is exact: with one degree of freedom, E = ½ I(φ) φ'² + V(φ) gives the time of a turn as an integral of a
periodic function, for which the trapezoid rule converges exponentially; it is summed in extended precision. Beside
mbproj's methods with and without the row stand the Gauss methods of order 4, 6 and 8 (Hairer, Lubich & Wanner,
Geometric Numerical Integration, II.1.3) on Hamilton's equations of the one coordinate, which need no constraints: their
evaluations are those of all iterations, and cost less than one of the mechanism's.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import mbproj

SCENE = Path(__file__).parents[1] / "mechanisms" / "planar_four_bar.yaml"
A, B, C, D = 0.1, 0.3, 0.25, 0.3
#: Mass and moment about the centre of crank, coupler and rocker; the marker has no mass.
CRANK, COUPLER, ROCKER = (2.0, 0.01), (0.3, 2.4e-3), (0.25, 1.3e-3)
GRAVITY, START, SPEED = 9.81, math.radians(60.0), 12.0
#: Integrators and steps, s.
STEPS = (0.04, 0.02, 0.01, 0.005)
POINTS = 2048


def inertia_and_potential(φ: Any, xp: Any = math) -> tuple[Any, Any, Any, Any]:
    """I, I', V and V' at the crank's angle from the line of the pivots."""
    x, z = D - A * xp.cos(φ), -A * xp.sin(φ)
    span2 = x * x + z * z
    span = xp.sqrt(span2)
    atan2 = xp.atan2 if xp is math else xp.arctan2
    acos = xp.acos if xp is math else xp.arccos
    ψ = atan2(z, x) + acos((B * B + span2 - C * C) / (2 * B * span))
    ex, ez = A * xp.cos(φ) + B * xp.cos(ψ) - D, A * xp.sin(φ) + B * xp.sin(ψ)
    χ = atan2(ez, ex)
    # a cos φ + b cos ψ = d + c cos χ and the same with sines, differentiated by φ once and twice.
    s = xp.sin(ψ - χ)
    ψ1, χ1 = A * xp.sin(χ - φ) / (B * s), A * xp.sin(ψ - φ) / (C * s)
    ψ2 = (A * xp.cos(χ - φ) * (χ1 - 1) - B * ψ1 * xp.cos(ψ - χ) * (ψ1 - χ1)) / (B * s)
    χ2 = (A * xp.cos(ψ - φ) * (ψ1 - 1) - C * χ1 * xp.cos(ψ - χ) * (ψ1 - χ1)) / (C * s)
    (m1, J1), (m2, J2), (m3, J3) = CRANK, COUPLER, ROCKER
    cross = A * B * xp.cos(φ - ψ)
    inertia = J1 + m1 * A * A / 4 + (J2 + m2 * B * B / 4) * ψ1 * ψ1 + m2 * (A * A + cross * ψ1)
    inertia = inertia + (J3 + m3 * C * C / 4) * χ1 * χ1
    slope = 2 * (J2 + m2 * B * B / 4) * ψ1 * ψ2 + m2 * (cross * ψ2 - A * B * xp.sin(φ - ψ) * (1 - ψ1) * ψ1)
    slope = slope + 2 * (J3 + m3 * C * C / 4) * χ1 * χ2
    potential = GRAVITY * (m1 * A / 2 * xp.sin(φ) + m2 * (A * xp.sin(φ) + B / 2 * xp.sin(ψ)) + m3 * C / 2 * xp.sin(χ))
    pull = m1 * A / 2 * xp.cos(φ) + m2 * (A * xp.cos(φ) + B / 2 * xp.cos(ψ) * ψ1) + m3 * C / 2 * xp.cos(χ) * χ1
    return inertia, slope, potential, GRAVITY * pull


def exact(t: float) -> float:
    """The crank's angle after t, rad."""
    φ = np.longdouble(2.0) * np.arccos(np.longdouble(-1.0)) * np.arange(POINTS) / POINTS
    inertia, _, potential, _ = inertia_and_potential(φ, np)
    I0, _, V0, _ = inertia_and_potential(np.longdouble(60.0) * np.arccos(np.longdouble(-1.0)) / 180, np)
    energy = I0 * SPEED * np.longdouble(SPEED) / 2 + V0
    speed = np.sqrt(2 * (energy - potential) / inertia)
    spectrum = np.fft.rfft(np.asarray(1 / speed)) / POINTS  # in double: of the part of a turn alone
    mean = np.sum(1 / speed) / POINTS
    k = np.arange(1, 200)

    def elapsed(angle: np.longdouble) -> np.longdouble:
        """Since the angle 0."""
        waves = (spectrum[1:200] * (np.exp(1j * k * float(angle % (2 * np.pi))) - 1) / (1j * k)).real
        return mean * angle + np.longdouble(2 * np.sum(waves))

    start = np.longdouble(60.0) * np.arccos(np.longdouble(-1.0)) / 180
    wanted = elapsed(start) + np.longdouble(t)
    angle = start + np.longdouble(t) / mean
    for _ in range(60):
        inertia, _, potential, _ = inertia_and_potential(angle, np)
        angle = angle - (elapsed(angle) - wanted) * np.sqrt(2 * (energy - potential) / inertia)
    return float(angle)


def gauss(order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, b and c by collocation in Gauss's points."""
    points, weights = np.polynomial.legendre.leggauss(order // 2)
    c, b = 0.5 * (points + 1.0), 0.5 * weights
    powers = np.vander(c, increasing=True)
    k = np.arange(1, len(c) + 1)
    return (c[:, None] ** k / k) @ np.linalg.inv(powers), b, c


def by_gauss(order: int, h: float, t: float) -> tuple[float, int]:
    """The crank's angle after t, and evaluations."""
    a, b, _ = gauss(order)
    inertia, _, _, _ = inertia_and_potential(START)
    φ, p, evaluations = START, inertia * SPEED, 0
    stages = range(len(b))
    f, g = [SPEED] * len(b), [0.0] * len(b)
    for _ in range(round(t / h)):
        for _ in range(50):
            change = 0.0
            new_f, new_g = [], []
            for i in stages:
                x = φ + h * sum(a[i][j] * f[j] for j in stages)
                y = p + h * sum(a[i][j] * g[j] for j in stages)
                inertia, slope, _, pull = inertia_and_potential(x)
                rate = y / inertia
                new_f.append(rate)
                new_g.append(0.5 * slope * rate * rate - pull)
            evaluations += len(b)
            change = max(abs(u - v) for u, v in zip(new_f, f, strict=True))
            f, g = new_f, new_g
            if change < 1e-13 * SPEED:
                break
        φ += h * sum(b[i] * f[i] for i in stages)
        p += h * sum(b[i] * g[i] for i in stages)
    return φ, evaluations


def by_mbproj(integrator: str, h: float, t: float, *, row: bool) -> tuple[float, int, float]:
    """The same of the mechanism in absolute coordinates, and what the row gave, J."""
    found = mbproj.run(SCENE, integrator=integrator, step=h, duration=t, output_step=t / 10, energy_row=row)
    angle, attributes = found["joints/coordinate"][-1], found.attributes
    first = list(found.joint_coordinates).index("A") if hasattr(found, "joint_coordinates") else 0
    return START + float(angle[first]), int(attributes["evaluations"]), float(attributes.get("energy_row_given", 0.0))


def main(seconds: float) -> None:
    """Prints the table."""
    angle = exact(seconds)
    print(f"the crank turns {(angle - START) / (2 * np.pi):.1f} times in {seconds:g} s")
    print("| method | step, ms | error, rad | evaluations | the row gave, J |\n|---|---|---|---|---|")
    for integrator in ("rk4", "dop853"):
        for h in STEPS:
            for row in (False, True):
                found, evaluations, given = by_mbproj(integrator, h, seconds, row=row)
                name = f"{integrator}{', energy row' * row}"
                print(f"| {name} | {1e3 * h:g} | {found - angle:+.1e} | {evaluations} | {given:.1e} |", flush=True)
    for order in (4, 6, 8):
        for h in STEPS[:3]:
            found, evaluations = by_gauss(order, h, seconds)
            print(f"| Gauss {order} | {1e3 * h:g} | {found - angle:+.1e} | {evaluations} | |", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 10_000.0)
