"""A run that goes on step by step from Python: against matrix exponentials, and what cannot be run so."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import mbproj
from mbproj.base.errors import InputError
from mbproj.kernel import core

pytestmark = pytest.mark.skipif(core() is None, reason="a run step by step is made in the kernel")

CART = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, output_step: 10 ms}
bodies:
  cart: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1, speed: 0.5}
states: {u: {derivative: 0, initial: 0 N}}
signals: {x: rail.displacement, v: rail.displacement_dot}
forces:
  drive: {type: linear_spring_damper, joint: rail, force: u}
"""
STEP = expm(np.array([[0, 1, 0], [0, 0, 0.5], [0, 0, 0.0]]) * 0.02)
METHODS = [
    {"tolerance": 1e-10, "formulation": "planar"},
    {"tolerance": 1e-8, "integrator": "radau5"},
    {"step": 0.005, "integrator": "rk4", "formulation": "reduced"},
]


@pytest.mark.parametrize("options", METHODS, ids=str)
def test_inputs_from_python_move_a_cart_as_the_matrix_exponential_says(options):
    run, x = mbproj.start(CART, period=0.02, **options), np.array([0.1, 0.5, 0.0])
    times = [run.t]
    while not run.is_over:
        seen = run.signals
        assert seen == pytest.approx({"x": x[0], "v": x[1]}, abs=1e-13)
        x[2] = -80.0 * x[0] - 8.0 * x[1]
        times.append(run.advance(inputs={"u": -80.0 * seen["x"] - 8.0 * seen["v"]}))
        x = STEP @ x
    assert np.allclose(times, np.linspace(0.0, 1.0, 51), atol=1e-15)
    assert run.state.x == pytest.approx([x[2]], abs=1e-12)


def test_it_goes_on_to_the_first_instant_that_is_not_before_a_time():
    run = mbproj.start(CART, period=0.02, step=0.005, integrator="rk4")
    assert run.advance(until=0.05, inputs={"u": 4.0}) == pytest.approx(0.06)
    assert run.signals["v"] == pytest.approx(0.5 + 2.0 * 0.06, abs=1e-13)
    assert run.advance(until=9.0) == pytest.approx(1.0)
    with pytest.raises(InputError, match="is over"):
        run.advance()


def test_what_it_cannot_do_is_said():
    run = mbproj.start(CART, period=0.02, tolerance=1e-6)
    with pytest.raises(InputError, match="no state of the scene"):
        run.advance(inputs={"force": 1.0})
    for options, words in (
        ({"period": -1.0}, "must be a time"),
        ({"period": 0.1, "formulation": "full"}, "in the kernel"),
        ({"period": 0.1, "integrator": "auto"}, "integrator auto"),
    ):
        with pytest.raises(InputError, match=words):
            mbproj.start(CART, **{"tolerance": 1e-6, **options})
    with pytest.raises(TypeError, match=r"^start\(\) has no argument 'tolerances'; did you mean 'tolerance'"):
        mbproj.start(CART, period=0.1, tolerances=1e-3)
    with pytest.raises(InputError, match="give way"):
        limited = CART.replace("speed: 0.5", "speed: 0.5, limits: {displacement: {range: [0, 1], rigid: true}}")
        mbproj.start(limited, period=0.1, tolerance=1e-6)


@pytest.mark.parametrize("options", METHODS, ids=str)
def test_a_controller_from_python_acts_as_one_of_the_scene(options):
    """The same law, as a function and in the scene: the same run to the bit, and what the matrix exponential says."""
    asked = []

    def controller(t, seen):
        asked.append(t)
        return {"u": -80.0 * seen["x"] - 8.0 * seen["v"]}

    own = mbproj.run(CART, controller=controller, period=0.02, **options)
    law = "controllers: {pd: {period: 20 ms, hold: {u: -80*rail.displacement - 8*rail.displacement_dot}}}\n"
    of_scene = CART.replace("states: {u: {derivative: 0, initial: 0 N}}\n", law).replace("force: u", "force: pd.u")
    other = mbproj.run(of_scene, **options)
    for path in ("joints/coordinate", "joints/speed", "states/value"):
        np.testing.assert_array_equal(own[path][:-1], other[path][:-1])
    assert np.allclose(asked, np.linspace(0.0, 0.98, 50), atol=1e-15)
    x = np.array([0.1, 0.5, 0.0])
    for _ in range(50):
        x[2] = -80.0 * x[0] - 8.0 * x[1]
        x = STEP @ x
    assert own["joints/coordinate"][-1, 0] == pytest.approx(x[0], abs=1e-13)


def test_a_controller_may_set_nothing_and_its_mistakes_are_told():
    still = mbproj.run(CART, controller=lambda t, seen: None, period=0.1, tolerance=1e-8)
    assert still["joints/coordinate"][-1, 0] == pytest.approx(0.6, abs=1e-12)
    for again in (mbproj.rerun, mbproj.continue_run):
        with pytest.raises(InputError, match="a function in Python acted on the run"):
            again(still)
    for options, words in (
        ({"period": None}, "acts each period"),
        ({"period": 0.1, "certify": True}, "is not certified"),
        ({"period": 0.1, "formulation": "full"}, "in the kernel"),
        ({"period": 0.1, "controller": lambda t, seen: {"v": 1.0}}, "'v' is no state of the scene"),
        ({"period": 0.1, "controller": lambda t, seen: {"u": float("nan")}}, "input 'u' is nan, which is not finite"),
        ({"period": 0.1, "controller": None}, "add controller=f"),
    ):
        with pytest.raises(InputError, match=words):
            mbproj.run(CART, **{"tolerance": 1e-6, "controller": lambda t, seen: {}, **options})
