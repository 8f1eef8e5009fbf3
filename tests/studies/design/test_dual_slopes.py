"""Slopes of measures by dual numbers along one run: closed forms, and what moves a parameter into the run."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import mbproj
from mbproj.base.mechanisms_folder import mechanism
from tests.kernel.scenes import needs_kernel
from tests.studies.design.scenes import SPRING

pytestmark = needs_kernel

PENDULUM = """\
mbproj: 1
gravity: [0, 0, -g]
parameters: {length: 0.8 m, g: 9.81 m/s^2, mass: 2 kg, release: 2 rad}
bodies:
  bob: {mass: mass, inertia: [1.0e-6, 1.0e-6, 1.0e-6], position: [length*sin(release), 0, -length*cos(release)],
        orientation: {axis: [0, -1, 0], angle: release}}
joints: {pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, -1, 0]}}
simulation: {duration: 3 s, tolerance: 1.0e-9, integrator: dop853, output_step: 0.05 s}
expect:
  swing: {joint: pin, quantity: angle, at: end, below: 100 rad, source: cd}
  turn: {joint: pin, quantity: angle_speed, at: end, below: 100 rad/s, source: cd}
  middle: {joint: pin, quantity: angle, at: 1.35 s, below: 100 rad, source: cd}
  pull: {joint: pin, quantity: reaction_force, component: norm, at: 2 s, below: 1000 N, source: mass and motion}
"""


def swung(t, length, g, release):
    """A pendulum's angle, let go at `release`: 2 arcsin(k cd(ω t, k)) (Whittaker, Analytical Dynamics, § 44)."""
    k, omega = np.sin(release / 2.0), np.sqrt(g / (length + 5e-7 / length))
    _, cn, dn, _ = ellipj(omega * t, k * k)
    return 2.0 * np.arcsin(k * cn / dn)


def derivative(of, at, h=1e-3):
    """Of fourth order, of a closed form."""
    return (8.0 * (of(at + h) - of(at - h)) - (of(at + 2 * h) - of(at - 2 * h))) / (12.0 * h)


def test_pendulum_of_any_swing():
    """By length, gravity and release, at the end and between samples that are ends of steps; a mass changes the load of
    the pin alone, and is a factor of that."""
    found = mbproj.sensitivity(PENDULUM)
    assert not any(map(any, found.why))
    length, g, release = 0.8, 9.81, 2.0
    by = {
        "length": lambda x, t: swung(t, x, g, release),
        "g": lambda x, t: swung(t, length, x, release),
        "release": lambda x, t: swung(t, length, g, x) - x,
    }
    measures, paths = [each.name for each in found.measures], list(found.paths)
    for name, value in (("length", length), ("g", g), ("release", release)):
        column = paths.index(name)
        for measure, t in (("swing", 3.0), ("middle", 1.35)):
            expected = derivative(lambda x, t=t, name=name: by[name](x, t), value)
            assert found.slopes[measures.index(measure), column] == pytest.approx(expected, rel=2e-8)
    mass = paths.index("mass")
    assert np.abs(found.slopes[:3, mass]).max() < 1e-5  # inertia beside mass: 1e-6 kg m²
    assert found.elasticity[3, mass] == pytest.approx(1.0, abs=1e-5)


def test_period_by_length():
    """T = 4 K(k)/ω. Where the angle passes 0 the second time, dt/dl is -∂φ/∂l over the speed."""
    text = PENDULUM.replace("duration: 3 s", "duration: T").replace("release: 2 rad}", "release: 2 rad, T: 1 s}")
    period = 4.0 * ellipk(np.sin(1.0) ** 2) * np.sqrt((0.8 + 5e-7 / 0.8) / 9.81)
    text = text.partition("  middle")[0].replace("T: 1 s", f"T: {float(0.75 * period)!r} s")
    found = mbproj.sensitivity(text, of="swing,turn", to="length")
    assert found.values[0] == pytest.approx(-2.0, abs=1e-9)  # it counts from where the bob is let go
    by_length, speed = -found.slopes[0, 0] / found.values[1], found.values[1]
    assert abs(speed) == pytest.approx(2.0 * np.sin(1.0) * np.sqrt(9.81 / 0.8), rel=1e-5)
    assert by_length == pytest.approx(0.75 * period / 2.0 / 0.8, rel=1e-5)


def test_spring_and_mass():
    """x = cos(√(k/m) t), at the end and where it is largest in size among its samples."""
    expect = """\
expect:
  end: {joint: rail, quantity: displacement, at: end, below: 9 m, source: cos}
"""
    found = mbproj.sensitivity(SPRING.replace("step: 0.01 s,", "tolerance: 1.0e-9, integrator: dop853,") + expect)
    assert not any(map(any, found.why))
    ω, t = 5.0, 2.0
    by_stiffness = -t * np.sin(ω * t) * ω / 2.0 / 50.0
    assert found.slopes[0] == pytest.approx([-by_stiffness * 50.0 / 2.0, by_stiffness], rel=1e-8)
    coarse = mbproj.sensitivity(SPRING + expect)
    assert np.all(np.abs(coarse.slopes[0] - found.slopes[0]) < coarse.uncertainty[0])
    assert np.all(coarse.uncertainty[0] < 100.0 * np.abs(coarse.slopes[0] - found.slopes[0]))


@pytest.mark.parametrize(("name", "to"), [("five_bar", "length,width"), ("planar_four_bar", "crank,speed,down")])
def test_steps_and_what_they_are_off_by(name, to):
    """The scene's fixed steps are off from precise ones by no more than is said."""
    scene = mbproj.read_scene(mechanism(name))
    exact = mbproj.sensitivity(scene.with_({}), to=to)
    text = scene.text
    if scene.settings.step is None:
        text = text.replace("tolerance: 1.0e-8", "step: 2.5 ms").replace("integrator: dop853", "integrator: rk4")
        coarse = mbproj.sensitivity(mbproj.read_scene_text(text), to=to)
    else:
        coarse, text = exact, text.replace("step: 10 ms", "tolerance: 1.0e-11\n  output_step: 10 ms")
        exact = mbproj.sensitivity(mbproj.read_scene_text(text.replace("rk4", "dop853")), to=to)
    apart = np.abs(coarse.slopes - exact.slopes)
    assert np.all(apart <= 1.5 * coarse.uncertainty + 1e-9)
    assert apart.max() > 1e-9
