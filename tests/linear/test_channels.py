"""Linear models of mechanisms whose functions name channels: a motor with a controller, and forces that go by the
motion of something else, against the equations of their own and against differences of what a run integrates."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.dynamics import pose_of, tangent_velocities, velocities
from mbproj.dynamics.derivatives.tangent import moved
from mbproj.integrate import FullFormulation
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.mode_notes import notes_on
from mbproj.linear.modes import modes
from mbproj.linear.reduction.projected import projected
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space.model import linear_model
from tests.model.element_scenes import RATES, driven

#: Of the current, where the angle is held at 1 rad, and of the integral: 2 i = m g l sin 1, and 30 ∫e = 0.8 i.
CURRENT, INTEGRAL = 1.65096607219, 0.0440257619251
#: Of the inductance, beside what it moves, elements.md.
FASTEST = -381.98753488


def own_matrix():
    """A of (θ, θ', i, ∫e, filtered) at 1 rad, as the equations are written."""
    J, weight = 0.1 + 2.0 * 0.2**2, 2.0 * 9.81 * 0.2
    A = np.zeros((5, 5))
    A[0, 1] = 1.0
    A[1, [0, 2]] = -weight * np.cos(1.0) / J, 2.0 / J
    A[2] = np.array([-20.0, -2.0, -0.8, 30.0, -2.0]) / 2e-3
    A[3, 0] = -1.0
    A[4, [1, 4]] = 100.0, -100.0
    return A


def test_a_controlled_pendulum_rests_where_its_integrator_does():
    system, start, _ = driven()
    found = equilibrium(system, start)
    np.testing.assert_allclose(found.state.x, [CURRENT, INTEGRAL, 0.0], rtol=1e-11, atol=1e-12)
    assert found.reference.motion.expected[0] == pytest.approx(1.0, abs=1e-12)
    assert found.stable is True
    assert found.neutral == ("of axle.angle",)


def test_its_modes_are_those_of_its_own_equations():
    system, start, _ = driven()
    reference = equilibrium(system, start).reference
    found = modes(reference)
    exact = np.linalg.eigvals(own_matrix())
    exact = exact[exact.imag >= 0.0]
    np.testing.assert_allclose(found.eigenvalues, [0.0, *exact[np.argsort(np.abs(exact))]], rtol=1e-9, atol=1e-12)
    assert found.eigenvalues[-1] == pytest.approx(FASTEST)
    assert found.name(3) == "state x.current 91 %"
    assert found.name(1).startswith("state x.integral")
    model = linear_model(reference, ["pin.angle"], ["pin.angle"])
    assert model.states[-3:] == ("x.current", "x.integral", "x.filtered")
    ordered = np.sort_complex(np.linalg.eigvals(model.A))
    np.testing.assert_allclose(ordered[:5], np.sort_complex(np.linalg.eigvals(own_matrix())), rtol=1e-9)


def test_a_cylinder_rings_as_its_oil_is_stiff():
    """F = A p, p' = (β/V)(Q - A s'): J ω² = A² β/V; at a standstill p is whatever holds."""
    system, start, _ = driven(motor="2*current", rates=("5e4*(0*t - speed)", "0*t", "-filtered"))
    found = modes(reference_at(system, start, "start"))
    stiff = found.eigenvalues[np.abs(found.eigenvalues) > 100.0]
    np.testing.assert_allclose(stiff, [1j * np.sqrt((2.0 * 5e4 + 2.0 * 9.81 * 0.2) / 0.18)], rtol=1e-10)


def test_an_integrator_without_rest_is_named():
    """A controller that integrates 1 rad - angle, and whose motor is off, never gets there."""
    system, start, _ = driven(motor="0*t")
    with pytest.raises(NoEquilibrium, match=r"state 'x\.integral' drifts by 1 s/s, and nothing"):
        equilibrium(system, start)


def test_rates_that_channels_make_are_noted():
    system, start, _ = driven()
    assert "states change here: 'x.current' by 1e+04 A/s, 'x.integral' by 1 s/s" in notes_on(
        modes(reference_at(system, start, "start"))
    )


@pytest.mark.parametrize("speed", [0.0, 2.0])
def test_matrices_are_those_of_differences_of_the_derivative(speed):
    """Forces on each coordinate that name the other one, its rate and states: D and K are not symmetric."""
    motor, spring = "2*current*cos(turn) - 3*turn*angle + 0.2*speed**2", "filtered*angle - 4*sin(angle) - 0.3*speed"
    system, start, settings = driven(motor=motor, spring=spring, rates=(RATES[0], "1 - angle*turn", RATES[2]))
    start = start.changed(states=np.array([1.5, 0.2, -0.3]), velocities=speed * _turn_of_the_wheel(system, start))
    reference = reference_at(system, start, "start")
    here = projected(reference)
    f, K = here.space.freedom, 3
    whole = here.with_states(np.ones(K))
    rows = -np.hstack([whole.K[:, :f], whole.D[:, :f], whole.K[:, f:]])
    exact = np.vstack([np.linalg.solve(whole.M[:f, :f], rows[:f]), rows[f:] / np.abs(whole.M).max()])
    found = differences(system, start, settings, _in_body(reference, here.space.N))
    np.testing.assert_allclose(found, exact, rtol=1e-6, atol=1e-5)
    if speed == 0.0:
        model = linear_model(reference, ["pin.angle"], ["pin.angle"])
        np.testing.assert_allclose(model.A[f : 2 * f], exact[:f], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(model.A[2 * f :], exact[f:], rtol=1e-9, atol=1e-9)


def _turn_of_the_wheel(system, start):
    u = np.zeros(12)
    u[10] = 1.0
    return velocities(pose_of(start.q), u)


def _in_body(reference, N):
    turned = N.reshape(2, 6, -1).copy()
    turned[:, 3:] = np.swapaxes(reference.motion.pose.rotation[:-1], -1, -2) @ turned[:, 3:]
    return turned.reshape(N.shape)


def differences(system, start, settings, N, step=1e-6):
    """∂(η'', x')/∂(η, η', x) of what a run integrates, by central differences; ξ = N η in body axes."""
    formulation = FullFormulation.of(system, start, settings)
    layout, f = formulation.layout, N.shape[1]
    back = np.linalg.pinv(N)
    u = tangent_velocities(pose_of(start.q), start.v)

    def rates(z):
        η, η_dot, x = np.split(z, [f, 2 * f])
        q = moved(start.q, N @ η)
        pose = pose_of(q)
        v = velocities(pose, u + _carried(N, η_dot, η, u))
        expected = start.instant(system).expected + _coordinates(system, N @ η)
        y = layout.vector_of({"positions": q, "velocities": v, "states": start.x + x, "followed": expected})
        slope = formulation.derivative(start.t, y)
        acceleration = tangent_velocities(pose, slope[layout["velocities"]])
        return np.concatenate([back @ acceleration, slope[layout["states"]]])

    columns = []
    for z in step * np.eye(2 * f + len(start.x)):
        columns.append((rates(z) - rates(-z)) / (2.0 * step))
    return np.array(columns).T


def _carried(N, η_dot, η, u):
    """u of (η, η'): all hinges turn about y here, so that N keeps its turns, and a shift follows its body's turn."""
    found = (N @ η_dot).reshape(2, 6)
    spin, turn = u.reshape(2, 6)[:, 4] + found[:, 4], (N @ η).reshape(2, 6)[:, 4]
    arm = np.array([[0.0, 0.0, -0.2], [0.0, 0.0, 0.0]])
    for body in range(2):
        c, s = np.cos(turn[body]), np.sin(turn[body])
        x, z = c * arm[body, 0] + s * arm[body, 2], -s * arm[body, 0] + c * arm[body, 2]
        found[body, :3] = spin[body] * z, 0.0, -spin[body] * x
        found[body, 3:] = 0.0, spin[body], 0.0
    return found.ravel() - u


def _coordinates(system, ξ):
    return ξ.reshape(2, 6)[:, 4]
