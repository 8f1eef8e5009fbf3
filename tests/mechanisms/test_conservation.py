"""What mechanics conserves: exactly where every step conserves it, and otherwise with the integrator's order."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.registry import integrators
from mbproj.base.settings import ProjectionSettings, Settings
from tests.crossed import some
from tests.mechanisms.running import Run, angular_momentum, assert_close, run, run_scene
from tests.support import random_body, random_joint, scene_of


def floating_chain(**settings) -> Scene:
    """Four bodies of random mass joined in a row, far from any ground and without gravity."""
    rng = np.random.default_rng(3)
    kinds = ["spherical", "revolute", "universal"]
    bodies = [random_body(rng, f"body{number}") for number in range(4)]
    joints = [random_joint(rng, f"J{n}", kind, (f"body{n}", f"body{n + 1}")) for n, kind in enumerate(kinds)]
    return scene_of(bodies, joints, gravity=(0.0, 0.0, 0.0), settings=Settings(**settings))


def momentum(done: Run) -> np.ndarray:
    """Linear momentum of all bodies (T, 3)."""
    return np.einsum("b,tbi->ti", [body.mass for body in done.scene.bodies], done["bodies/velocity"])


def drift(values: np.ndarray) -> float:
    return float(np.abs(values - values[0]).max())


@pytest.mark.parametrize("method", ["gpopm", "mmopm", "none"])
def test_centre_of_a_floating_chain_moves_on_a_straight_line(method):
    """Forces, and corrections weighted by mass, are internal: momentum is conserved to round-off in every step."""
    penalty = {"alpha": 1e7} if method == "mmopm" else {}
    done = run_scene(floating_chain(duration=0.4, step=0.01, projection=ProjectionSettings(method=method, **penalty)))
    assert_close(momentum(done), momentum(done)[0], 1e-13)
    mass = np.array([body.mass for body in done.scene.bodies])
    centre = np.einsum("b,tbi->ti", mass, done["bodies/position"]) / mass.sum()
    assert_close(centre, centre[0] + momentum(done)[0] / mass.sum() * done["time"][:, None], 1e-13)


def test_a_projection_that_ignores_mass_pushes_the_centre():
    """GOPM corrects light and heavy bodies alike, as if somebody outside moved them."""
    done = run_scene(floating_chain(duration=0.4, step=0.01, projection=ProjectionSettings(method="gopm")))
    assert drift(momentum(done)) > 1e-11


Quantity = Callable[[Run], np.ndarray]


def energy(done: Run) -> np.ndarray:
    return done["diagnostics/total_energy"]


def vertical(done: Run) -> np.ndarray:
    return angular_momentum(done, "origin")[:, 2]


def spin(done: Run) -> np.ndarray:
    return done["bodies/angular_velocity"][:, 0, 2]


def idle_spin(done: Run) -> np.ndarray:
    return done.column("bodies/angular_velocity", "rod")[:, 0]


def observed_order(simulate: Callable[[float], Run], quantity: Quantity, step: float) -> float:
    """log2 of the ratio of the drifts with this step and with half of it."""
    return float(np.log2(drift(quantity(simulate(step))) / drift(quantity(simulate(step / 2)))))


#: The larger step (s), and whether the order is clean there; where it is not, the drift falls faster.
CHAIN_STEPS = {
    "heun2": (0.002, True),
    "bs32": (0.01, True),
    "rk4": (0.01, True),
    "dopri5": (0.02, False),
    "dop853": (0.1, False),
}


@pytest.mark.parametrize("quantity", [angular_momentum, energy], ids=["momentum", "energy"])
@pytest.mark.parametrize("integrator", list(CHAIN_STEPS))
def test_floating_chain_drifts_with_the_order(integrator, quantity):
    """Angular momentum about the centre, and energy."""
    step, clean = CHAIN_STEPS[integrator]

    def simulate(h: float) -> Run:
        return run_scene(floating_chain(duration=0.4, step=h, output_step=step, integrator=integrator))

    order, expected = observed_order(simulate, quantity, step), integrators()[integrator].order
    assert order == pytest.approx(expected, abs=0.15) if clean else order >= expected - 0.15


TOP_STEPS = {"heun2": 0.0002, "bs32": 0.0005, "rk4": 0.001, "dopri5": 0.001, "dop853": 0.01}


@pytest.mark.parametrize("integrator", some(TOP_STEPS, 3))
def test_top_loses_spin_and_momentum_with_the_order_of_a_linear_oscillation(integrator):
    """With Euler parameters even turning is one: |R(iωh)| - 1 is of order p + 1 in a step, p + 2 where p is even."""
    step, p = TOP_STEPS[integrator], integrators()[integrator].order
    results = [
        run("heavy_top", formulation="full", integrator=integrator, step=h, output_step=step, duration=20 * step)
        for h in (step, step / 2)
    ]
    for quantity in (spin, vertical, energy):
        coarse, fine = (drift(quantity(done)) for done in results)
        assert np.log2(coarse / fine) == pytest.approx(p + (p % 2 == 0), abs=0.15)


@pytest.mark.parametrize(
    ("name", "quantity", "integrator", "step", "clean"),
    some(
        [
            ("double_pendulum", energy, "heun2", 0.005, True),
            ("double_pendulum", energy, "bs32", 0.005, True),
            ("double_pendulum", energy, "rk4", 0.005, True),
            ("double_pendulum", energy, "dopri5", 0.02, False),
            ("double_pendulum", energy, "dop853", 0.05, False),
            ("spatial_four_bar", energy, "heun2", 0.001, True),
            ("spatial_four_bar", energy, "bs32", 0.0025, True),
            ("spatial_four_bar", energy, "rk4", 0.005, True),
            ("spatial_four_bar", idle_spin, "heun2", 0.0005, True),
            ("spatial_four_bar", idle_spin, "bs32", 0.0025, True),
            ("spatial_four_bar", idle_spin, "rk4", 0.0025, True),
            ("spatial_four_bar", idle_spin, "dopri5", 0.005, True),
            ("delta_robot", energy, "rk4", 0.02, True),
            ("stewart_platform", energy, "rk4", 0.02, True),
        ],
        3,
    ),
)
def test_drift_falls_with_the_order(name, quantity, integrator, step, clean):
    duration = {"dop853": 2.0}.get(integrator, 0.5) if name == "double_pendulum" else 0.2

    formulation = "auto"
    if (
        quantity is idle_spin
    ):  # in reduced coordinates that of a symmetric rod is a constant of the equations themselves
        formulation, duration = "full", 40 * step

    def simulate(h: float) -> Run:
        return run(name, integrator=integrator, step=h, output_step=step, duration=duration, formulation=formulation)

    order, expected = observed_order(simulate, quantity, step), integrators()[integrator].order
    assert order == pytest.approx(expected, abs=0.15) if clean else order >= expected - 0.15
