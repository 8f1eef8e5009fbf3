"""Limits of parameters beyond which small motions grow: sampled controllers and springs, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from mbproj import InputError, compile_system, read_scene_text
from mbproj.linear.equilibrium.start import start_state
from mbproj.linear.instants import round_of
from mbproj.linear.reference import reference_at
from mbproj.studies.stability import stability

CART = """
mbproj: 1
gravity: [0, 0, 0]
parameters: {T: 50 ms, none: 0, d: 8}
simulation: {duration: 0.2 s, step: 10 ms}
bodies:
  cart: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1}
controllers:
  pd: {period: T, hold: {u: -80*rail.displacement - d*rail.displacement_dot}}
forces:
  drive: {type: linear_spring_damper, joint: rail, force: pd.u}
"""
PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {k: 30}
simulation: {duration: 0.1 s, step: 10 ms}
bodies:
  rod: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  spring: {type: torsion_spring_damper, joint: pin, stiffness: k, damping: 0.1}
"""


def small_motions(text, vary, **options):
    """The track of them, in a map with a method's own."""
    found = stability(read_scene_text(text), vary, projections=["gpopm"], points=3, processes=1, **options)
    small, method = found.tracks
    assert (small.method, method.method) == ("small motions", "gpopm")
    assert [point.state for point in method.points] == ["holds"] * 3
    return found, small


@pytest.mark.full
def test_the_limit_of_a_period_is_that_of_the_discrete_equations():
    """A mass m with u = -k x - d x' held over T: the eigenvalues of its matrix are below 1 up to T = 2 d/k."""
    found, small = small_motions(CART, "parameters.T", low=0.15, high=0.3)
    (change,) = small.changes
    assert change.value == pytest.approx(2 * 8 / 80, rel=1e-7)
    assert (found.unit, change.below.state, change.above.state) == ("s", "holds", "fails")
    assert "small motions 0.2000000" in found.line
    assert small.points[-1].cause.startswith("a small motion grows by 0.")


def test_the_limit_of_a_spring_that_holds_a_pendulum_upright():
    (change,) = small_motions(PENDULUM, "parameters.k", low=5.0, high=20.0)[1].changes
    assert change.value == pytest.approx(2 * 9.81 * 0.5, rel=1e-7)
    assert (change.below.state, change.above.state) == ("fails", "holds")


def rounds(text):
    scene = read_scene_text(text)
    system = compile_system(scene)
    return round_of(reference_at(system, start_state(scene, system), "start"))


def test_a_round_of_two_controllers_is_the_product_of_what_they_do():
    """Periods of 20 and 30 ms, and what the second computes stands 5 ms later: a round is 60 ms."""
    second = "  slow: {period: 30 ms, delay: 5 ms, hold: {w: -3*pd.u - 2*rail.displacement}}\n"
    text = (
        CART.replace("T: 50 ms", "T: 20 ms").replace("forces:", f"{second}forces:").replace(" pd.u}", " pd.u + slow.w}")
    )
    found = rounds(text)
    A = np.zeros((5, 5))  # place, speed, u, w, and w as computed
    A[0, 1], A[1, 2], A[1, 3] = 1.0, 0.5, 0.5
    pd, slow, stands = np.eye(5), np.eye(5), np.eye(5)
    pd[2] = [-80, -8, 0, 0, 0]
    slow[4] = [-2, 0, -3, 0, 0]
    stands[3] = [0, 0, 0, 0, 1]
    order = [(0.005, [stands]), (0.02, [pd]), (0.03, [slow]), (0.035, [stands]), (0.04, [pd]), (0.06, [pd, slow])]
    expected, at = np.eye(5), 0.0
    for time, actions in order:
        expected = expm(A * (time - at)) @ expected
        for action in actions:
            expected = action @ expected
        at = time
    assert found.time == pytest.approx(0.06, rel=1e-15)
    of = np.sort_complex(np.linalg.eigvals(expected))
    np.testing.assert_allclose(np.sort_complex(found.multipliers), of, atol=1e-7)
    np.testing.assert_allclose(found.multipliers[:2], of[np.argsort(-np.abs(of))][:2], rtol=1e-12)


WRONG = {
    "no": (CART, "parameters.Q", "the scene has no parameter 'Q'; parameters are: T, none, d"),
    "zero": (CART, "parameters.none", "parameter 'none' is 0, and values are varied by their logarithms"),
    "path": (CART, "parametrs.T", "did you mean 'parameters.NAME'"),
}


@pytest.mark.parametrize("case", WRONG)
def test_mistakes_are_told(case):
    text, vary, message = WRONG[case]
    with pytest.raises(InputError, match=message):
        stability(read_scene_text(text), vary, points=2, processes=1)


def test_what_has_no_round_is_told():
    with pytest.raises(InputError, match="the scene has no controller"):
        rounds(PENDULUM)
    other = "  odd: {period: 0.0314159 s, hold: {w: 0}}\n"
    with pytest.raises(InputError, match="no short common multiple"):
        rounds(CART.replace("forces:", f"{other}forces:"))
    with pytest.raises(InputError, match=r"what sets 'pd\.u' has a kink"):
        rounds(CART.replace("u: -80*rail", "u: abs(rail.displacement - 0.1) - 80*rail"))
