"""The four-cylinder inline engine against the closed formulas of slider-cranks and of engine balancing."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest
from scipy.special import binom

from mbproj.registry import PROJECTIONS
from mbproj.scene import read_scene_text
from tests.mechanisms.closed_forms import time_to_reach
from tests.mechanisms.running import Run, assert_close, run, run_scene
from tests.support import ROOT

PISTONS, RODS = [[f"{part}{k}" for k in (1, 2, 3, 4)] for part in ("piston", "rod")]
#: Throws 2 and 3 are opposite to 1 and 4.
THROWS = np.array([0.0, np.pi, np.pi, 0.0])
GRAVITY = 9.81
FREE = (
    (ROOT / "mechanisms" / "inline_four.yaml")
    .read_text(encoding="utf-8")
    .replace("motions:\n  drive: {joint: main, angle: {constant_speed: speed}}\n", "")
)


@pytest.fixture(scope="module")
def driven() -> Run:
    """One turn at constant speed, in 120 steps."""
    return run("inline_four", step="(1/3) ms", duration="40 ms")


def angle(done: Run) -> np.ndarray:
    return done.parameters["start"] + done.parameters["speed"] * done["time"]


def piston(done: Run, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """z = r cos θ + sqrt(l² - r² sin² θ) and its first two derivatives with respect to θ."""
    r, l = done.parameters["crank"], done.parameters["rod"]
    sine, cosine = np.sin(theta), np.cos(theta)
    root = np.sqrt(l**2 - r**2 * sine**2)
    slope = -(r**2) * sine * cosine / root
    bend = -(r**2) * (cosine**2 - sine**2) / root - slope**2 / root
    return r * cosine + root, -r * sine + slope, -r * cosine + bend


def points(done: Run) -> tuple[float, float]:
    """What a rod puts on the crank pin and on the piston pin, by its centre of mass."""
    p = done.parameters
    at_piston = p["rod_mass"] * p["rod_centre"] / p["rod"]
    return p["rod_mass"] - at_piston, at_piston


def reciprocating(done: Run) -> float:
    """m: a piston and its part of the rod."""
    return done.parameters["piston_mass"] + points(done)[1]


def ground_force(done: Run) -> np.ndarray:
    """The force on the ground (T, 3), from the reactions of all joints that bear on it."""
    joints = ["main", *(f"bore{k}" for k in (1, 2, 3, 4))]
    return -sum(done.column("joints/reaction_force", joint) for joint in joints)


def weight(done: Run) -> float:
    return GRAVITY * sum(body.mass for body in done.scene.bodies)


def series(ratio: float, order: int) -> float:
    """The coefficient a of cos(order θ) in -z'' / (r ω²), for an even order: from the binomial series of
    sqrt(1 - λ² sin² θ), in which sin^2k θ has cos 2jθ with 2 (-1)^j C(2k, k - j) / 4^k."""
    j = order // 2
    terms = (binom(0.5, k) * (-(ratio**2)) ** k * 2 * (-1) ** j * comb(2 * k, k - j) / 4**k for k in range(j, 40))
    return order**2 * sum(terms) / ratio


def harmonics(done: Run, values: np.ndarray) -> np.ndarray:
    """The coefficients a_k of Σ a_k cos kθ + b_k sin kθ as a_k - i b_k, from one turn in equal steps."""
    turned = 2.0 / (len(values) - 1) * np.fft.rfft(values[:-1])
    return turned * np.exp(-1j * np.arange(len(turned)) * done.parameters["start"])


def test_pistons_move_as_the_closed_formula_has_it(driven):
    speed = driven.parameters["speed"]
    for name, throw in zip(PISTONS, THROWS, strict=True):
        z, slope, bend = piston(driven, angle(driven) + throw)
        assert_close(driven.column("bodies/position", name)[:, 2], z, 1e-13)
        assert_close(driven.column("bodies/velocity", name)[:, 2], speed * slope, 1e-11)
        assert_close(driven.column("bodies/acceleration", name)[:, 2], speed**2 * bend, 1e-8)
        assert_close(driven.column("bodies/position", name)[:, 1], 0.0, 1e-13)
    assert driven.report.degrees_of_freedom == 0


def test_the_ground_feels_the_exact_inertia_forces(driven):
    """Weight and Σ -m z''; nothing across and nothing along the engine, and the rotating masses are balanced."""
    inertia = (
        -reciprocating(driven)
        * driven.parameters["speed"] ** 2
        * sum(piston(driven, angle(driven) + throw)[2] for throw in THROWS)
    )
    force = ground_force(driven)
    assert_close(force[:, 2] + weight(driven), inertia, 1e-7)
    assert_close(force[:, :2], 0.0, 1e-7)


def test_orders_of_balancing(driven):
    """The first order cancels; the second is 4 m r ω² (λ + λ³/4 + ..), the fourth follows; there are no odd ones."""
    p = driven.parameters
    ratio, scale = p["crank"] / p["rod"], 4.0 * reciprocating(driven) * p["crank"] * p["speed"] ** 2
    found = harmonics(driven, ground_force(driven)[:, 2]) / scale
    assert_close(np.abs(found[1:9:2]), 0.0, 1e-10)
    for order in (2, 4, 6):
        assert_close(found[order], series(ratio, order), 1e-10)
    assert found[2].real == pytest.approx(ratio + ratio**3 / 4 + 15 * ratio**5 / 128, rel=1e-4)
    assert found[4].real == pytest.approx(-(ratio**3) / 4 - 3 * ratio**5 / 16, rel=2e-2)
    single = harmonics(driven, driven.column("bodies/acceleration", "piston1")[:, 2]) / (p["crank"] * p["speed"] ** 2)
    assert_close(single[1], -1.0, 1e-10)


def test_the_driving_torque(driven):
    """Inertia and weight of the reciprocating masses at their lever dz/dθ; mostly -z'' z' of the second order."""
    p, m = driven.parameters, reciprocating(driven)
    torque = sum(
        m * (p["speed"] ** 2 * bend + GRAVITY) * slope
        for _, slope, bend in (piston(driven, angle(driven) + throw) for throw in THROWS)
    )
    assert_close(driven["motions/force"][:, 0], torque, 1e-7)
    second = harmonics(driven, driven["motions/force"][:, 0])[2] / (2.0 * m * p["crank"] ** 2 * p["speed"] ** 2)
    assert second.imag == pytest.approx(-1.0, rel=0.03)


def test_a_rod_of_another_moment_takes_another_torque_and_the_same_force(driven):
    """ΔJ ψ'' dψ/dθ for each rod, which leans by sin ψ = -λ sin θ."""
    p, extra = driven.parameters, 5.0e-4
    done = run("inline_four", {"rod_moment": p["rod_moment"] + extra}, step="(1/3) ms", duration="40 ms")
    assert_close(ground_force(done)[:, 2], ground_force(driven)[:, 2], 1e-7)
    theta, ratio = angle(done)[:, None] + THROWS, p["crank"] / p["rod"]
    root = np.sqrt(1.0 - ratio**2 * np.sin(theta) ** 2)
    slope = -ratio * np.cos(theta) / root
    bend = ratio * np.sin(theta) * (1.0 - ratio**2) / root**3
    torque = extra * p["speed"] ** 2 * np.sum(slope * bend, axis=1)
    assert_close(done["motions/force"][:, 0] - driven["motions/force"][:, 0], torque, 1e-7)
    assert np.abs(torque).max() > 1.0


@pytest.mark.parametrize("method", [name for name in PROJECTIONS if name not in ("popm", "gpopm")])
def test_every_method_drives_the_engine(method):
    done = run("inline_four", projection=method, duration="4 ms")
    z = piston(done, angle(done))[0]
    assert_close(done.column("bodies/position", "piston1")[:, 2], z, 4e-13 if PROJECTIONS[method].corrects else 1e-8)


def effective(done: Run, theta: float) -> tuple[float, float]:
    """Of the whole engine at θ: moment of inertia about the crank axis, and potential energy."""
    states = [piston(done, np.array(theta + throw)) for throw in THROWS]
    m, at_crank = reciprocating(done), points(done)[0]
    moment = done.parameters["flywheel"] + 4.0 * at_crank * done.parameters["crank"] ** 2
    moment += m * sum(float(slope) ** 2 for _, slope, _ in states)
    return moment, GRAVITY * m * sum(float(z) for z, _, _ in states)


def test_the_free_engine_turns_as_its_energy_says():
    """½ I(θ) θ'² + V(θ) stays; the time to an angle is a quadrature of that; the flywheel keeps it even."""
    options = {"integrator": "dop853", "tolerance": "1e-11", "duration": "50 ms", "output_step": "1 ms"}
    done = run_scene(read_scene_text(FREE, "free.yaml", {}, options))
    start, begin = done.parameters["start"], done.parameters["speed"]
    theta = start + done.column("joints/coordinate", "main.angle")
    speed = done.column("joints/speed", "main.angle")
    assert done.report.degrees_of_freedom == 1
    assert done.report.energy_drift_relative < 1e-10
    states = [effective(done, float(each)) for each in theta]
    energy = np.array([0.5 * moment * w**2 + v for (moment, v), w in zip(states, speed, strict=True)])
    assert_close(energy / energy[0], 1.0, 1e-10)
    moment, potential = (lambda at, k=k: effective(done, at)[k] for k in (0, 1))
    for row in (10, 50):
        assert time_to_reach(theta[row], start, begin, moment, potential) == pytest.approx(done["time"][row], abs=1e-10)
    assert 0.005 < np.ptp(speed) / begin < 0.05
