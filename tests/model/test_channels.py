"""Functions that name channels: what a motor with a controller does beside the solution of its own equations, and what
is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj.equations.derivatives import channel_slopes
from mbproj.kernel import core
from mbproj.motion.simulate import simulate
from tests.crossed import full
from tests.model.element_scenes import RATES, driven
from tests.support import Recorder

FORMULATIONS = ["full", *(["reduced", "planar"] if core() is not None else [])]
#: Where the full one takes a second or more in NumPy.
SELDOM_FULL = [full("full"), *FORMULATIONS[1:]]


def run(**own):
    system, start, settings = driven(**own)
    recorder = Recorder()
    report = simulate(system, start, settings, recorder)
    return report, recorder


#: θ, ω, current, ∫(1 - θ) and filtered ω at 0.1 s and 0.5 s, by SciPy's Radau at 1e-12 of the five equations
#: 0.18 ω' = 2 i - 0.4 g sin θ, and so on.
KNOWN = {
    0.1: (0.390446312562, 3.71859447161, -0.820625575034, 0.0821595329135, 3.91356371414),
    0.5: (1.0657936148, 0.489880111067, 1.42845067067, 0.149617715063, 0.523372517667),
}


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_motor_with_a_controller_moves_as_its_own_equations_say(formulation):
    """Torque by a state, rates of states by the angle and its rate."""
    known = [0.1] if formulation == "full" else [*KNOWN]  # in NumPy: seconds
    report, found = run(formulation=formulation, duration=str(known[-1]))
    for time, (angle, speed, *x) in [(time, KNOWN[time]) for time in known]:
        at = int(np.argmin(np.abs(found["time"] - time)))
        np.testing.assert_allclose(found["joints/coordinate"][at, 0], angle, rtol=5e-9)
        np.testing.assert_allclose(found["joints/speed"][at, 0], speed, rtol=5e-9)
        np.testing.assert_allclose(found["states/value"][at], x, rtol=5e-9)
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-9
    assert report.formulation == formulation


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_forces_name_coordinates_of_other_joints_and_the_work_is_counted(formulation):
    """A spring between two angles, F = -∂V/∂s of V = ½ k (s - 0.3 θ)²: with it energy is kept."""
    spring = {"motor": "15*0.3*(turn - 0.3*angle)", "spring": "-15*(turn - 0.3*angle)", "rates": ("0*t",) * 3}
    _, found = run(formulation=formulation, duration="1" if formulation == "full" else "3", **spring)
    angle, turn = found["joints/coordinate"].T
    stored = 0.5 * 15 * (turn - 0.3 * angle) ** 2
    energy = found["diagnostics/total_energy"] + stored
    assert np.ptp(found["diagnostics/total_energy"]) > 1e-3
    np.testing.assert_allclose(energy, energy[0], atol=1e-9)
    np.testing.assert_allclose(found["forces/force"][:, 0], 4.5 * (turn - 0.3 * angle), atol=1e-12)


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_edges_in_channels_are_located(formulation):
    """A current that is cut off at 1 A, and a rate that begins at an angle: with both located, a run by error has the
    motion of a finer one in the kernel."""
    rates = (RATES[0], "max(0, angle - 0.4)", RATES[2])
    cut = {"motor": "2*min(1, max(-1, current))", "rates": rates}
    report, coarse = run(tolerance="1e-10", formulation=formulation, **cut)
    _, fine = run(tolerance="1e-12", formulation=FORMULATIONS[-1], **cut)
    np.testing.assert_allclose(coarse["states/value"], fine["states/value"], atol=1e-6)
    assert report.events >= 3


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_angles_in_functions_count_their_turns(formulation):
    """x' = θ of a pin that a constant torque turns five times: θ and x in closed form."""
    own = {"motor": "40", "rates": ("angle", "0*t", "speed"), "formulation": formulation, "duration": "0.45"}
    system, start, settings = driven(**own)
    system, found = replace(system, gravity=np.zeros(3)), Recorder()
    simulate(system, start, settings, found)
    t, acceleration = found["time"], 40 / 0.18
    np.testing.assert_allclose(found["states/value"][:, 0], acceleration * t**3 / 6, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found["states/value"][:, 2], acceleration * t**2 / 2, rtol=1e-9, atol=1e-12)
    assert found["joints/coordinate"][-1, 0] > 6 * np.pi


def test_slopes_by_channels_are_those_of_calculus():
    system, start, _ = driven(motor="2*current*angle + turn**2", spring="speed*integral")
    start = start.changed(states=np.array([3.0, 0.5, -1.0]))
    of_laws, of_states = channel_slopes(start.instant(system))
    angle, speed, turn = 0.0, 0.0, 0.02
    np.testing.assert_allclose(of_laws, [[2 * angle, 0, 0, 6, 0, 2 * turn], [0, speed, 0, 0, 0.5, 0]], atol=1e-15)
    np.testing.assert_allclose(of_states[0], [-400, 15e3, -1e3, -1e4, -1e3, 0])
    np.testing.assert_allclose(of_states[1:], [[0, 0, 0, -1, 0, 0], [0, 0, -100, 0, 100, 0]])
