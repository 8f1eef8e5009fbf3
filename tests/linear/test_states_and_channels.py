"""Linear models of mechanisms whose elements have states and whose functions name channels."""

from __future__ import annotations

from dataclasses import replace

import h5py
import numpy as np
import pytest

from mbproj.base.thresholds import THRESHOLDS
from mbproj.commands import equilibrium as equilibrium_command
from mbproj.commands import linearize as linearize_command
from mbproj.commands import modes as modes_command
from mbproj.equations.kinematics import pose_of
from mbproj.equations.tangent_space import moved, tangent_velocities, velocities
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.modes import modes, notes_on, stored
from mbproj.linear.reduction import projected
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space import linear_model
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.simulate import simulate
from mbproj.results.linear_files import read_modes, write_modes
from mbproj.results.reader import open_results
from mbproj.studies.record import record_equilibrium
from tests.model.element_scenes import PENDULUM, RATES, case, driven
from tests.support import Recorder

# Linear models of mechanisms whose elements have states: x' = f is linear in them, as SciPy or a closed form says.

#: It hangs, with 2 kg 0.5 m below its pin: ω² = 9.81 / 0.6, and its damper takes 0.3 N m s.
HANGING = PENDULUM.replace("position: [0.5, 0, 0]", "position: [0, 0, -0.5]")
#: A vibration with 400 rad/s and damping 0.1, which is linear at x = 0 alone.
VIBRATES = ("z", "-1.6e5*x - 80*z + x**2")
SWINGS = -0.25 + 1j * np.sqrt(9.81 / 0.6 - 0.0625)
RINGS = -40.0 + 1j * np.sqrt(1.6e5 - 1600.0)


def made(texts, **own):
    """(scene, system, start) of the pendulum with these rates."""
    return case({"formulation": "full", "step": "0.01"}, text=HANGING, texts=texts, **own)[:3]


def rest(texts, **own):
    """Its equilibrium."""
    _, system, state = made(texts, **own)
    return equilibrium(system, state)


def at_start(texts, **own):
    _, system, state = made(texts, **own)
    return reference_at(system, state, "start")


def test_modes_have_the_eigenvalues_of_states_with_their_names():
    found = modes(at_start(VIBRATES, start=(0.0, 0.0)))
    np.testing.assert_allclose(found.eigenvalues, [SWINGS, RINGS], rtol=1e-12)
    assert [found.name(mode) for mode in (0, 1)] == [
        "rod 100 %; gravity and preload 100 %",
        "state lag.x 50 %, state lag.z 50 %",
    ]
    np.testing.assert_allclose(found.states[1, 0] / found.states[1, 1], 1.0 / RINGS, rtol=1e-12)
    np.testing.assert_allclose(found.state_share, [[0.0, 0.0], [0.5, 0.5]], atol=1e-12)
    assert np.abs(found.states[1]).max() == pytest.approx(1.0)
    np.testing.assert_array_equal(found.shapes[1], 0.0)
    assert found.freedom == 1


def test_a_state_that_nothing_changes_is_neutral():
    found = modes(at_start(("0*x", "x - z"), start=(0.0, 0.0)))
    assert found.eigenvalues[0] == 0.0
    assert found.name(0) == "neutral: state lag.x 100 %"


def test_states_that_change_are_noted():
    found = modes(at_start(("3 - x", "x - z"), start=(1.0, 1.0)))
    assert "states change here: 'lag.x' by 2 V/s" in notes_on(found)


def test_the_linear_model_has_first_order_states():
    reference = at_start(VIBRATES, start=(0.0, 0.0))
    found = linear_model(reference, ["pin.angle"], ["pin.angle", "lag.z"])
    assert found.states == ("displacement_1", "displacement_1_speed", "lag.x", "lag.z")
    assert found.state_units == ("1", "1/s", "V", "A/s")
    assert found.output_units == ("rad", "A/s")
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(found.A))[:2], [np.conj(RINGS), RINGS], rtol=1e-12)
    np.testing.assert_allclose(found.A[2:, 2:], [[0.0, 1.0], [-1.6e5, -80.0]], rtol=1e-14)
    np.testing.assert_array_equal(found.C[1], [0.0, 0.0, 0.0, 1.0])
    np.testing.assert_array_equal(found.B[2:], 0.0)


def test_its_response_is_that_of_a_run():
    """The states of the model from a small x, by the exponential of A."""
    from scipy.linalg import expm

    found = linear_model(at_start(VIBRATES, start=(0.0, 0.0)), ["pin.angle"], ["lag.x", "lag.z"])
    _, system, state, settings = case(
        {
            "formulation": "full",
            "integrator": "dop853",
            "tolerance": "1e-11",
            "duration": "0.05",
            "output_step": "0.01",
        },
        text=HANGING,
        texts=VIBRATES,
        start=(1e-5, 0.0),
    )
    recorder = Recorder()
    simulate(system, state, settings, recorder)
    exact = [found.C @ expm(found.A * t) @ [0.0, 0.0, 1e-5, 0.0] for t in recorder["time"]]
    np.testing.assert_allclose(recorder["states/value"], exact, atol=1e-8)


@pytest.mark.parametrize(
    ("texts", "start", "x", "stable"),
    [
        (("2 - x", "(x - z)*1e5"), (0.0, 0.5), (2.0, 2.0), True),
        (("3 - x**3", "x - z**3"), (1.0, 1.0), (3.0 ** (1 / 3), 3.0 ** (1 / 9)), True),
        (("z", "1 - x**2 - z"), (0.3, 0.0), (1.0, 0.0), True),
        (("x - 2", "x - z"), (0.0, 0.0), (2.0, 2.0), False),
        (("1e4*x*(300 - x)", "x - z"), (1.0, 0.0), (300.0, 300.0), True),
    ],
)
def test_states_do_not_change_in_an_equilibrium(texts, start, x, stable):
    found = rest(texts, start=start)
    np.testing.assert_allclose(found.state.x, x, rtol=1e-10, atol=1e-12)
    assert found.stable is stable
    assert found.unstable == ("" if stable else "of state 'lag.x'")
    assert found.reference.motion.expected[0] == pytest.approx(0.0, abs=1e-12)


def test_a_neutral_state_stays_as_it_was():
    found = rest(("0*x", "x - z"), start=(0.7, 0.0))
    np.testing.assert_allclose(found.state.x, [0.7, 0.7], rtol=1e-12)
    assert found.neutral == ("of state 'lag.x'",)


def test_a_state_that_drifts_is_named():
    with pytest.raises(NoEquilibrium, match=r"state 'lag\.z' drifts by 1.3 A/s/s, and nothing brings that to 0"):
        rest(("2 - x", "1.3 + 0*z"))


def test_states_have_modes_in_many_bodies_too(monkeypatch):
    expected = modes(at_start(VIBRATES, start=(0.0, 0.0)))
    for module in ("modes", "bordered"):
        monkeypatch.setattr(f"mbproj.linear.{module}.THRESHOLDS", replace(THRESHOLDS, large=0))
    monkeypatch.setattr("mbproj.equations.blocks.THRESHOLDS", replace(THRESHOLDS, large=0))
    found = modes(at_start(VIBRATES, start=(0.0, 0.0)))
    np.testing.assert_allclose(found.eigenvalues, expected.eigenvalues, rtol=1e-10)
    np.testing.assert_allclose(found.state_share, expected.state_share, atol=1e-10)


def test_commands_tell_them():
    found = modes(at_start(VIBRATES, start=(0.0, 0.0)))
    numbers = modes_command.numbers(found, "s.yaml", "modes.h5", None)
    assert numbers["modes"][1]["name"] == "state lag.x 50 %, state lag.z 50 %"
    assert set(numbers["modes"][1]["states"]) == {"lag.x", "lag.z"}
    assert "lag.z +1" in modes_command.report(found, "s", None)
    model = linear_model(at_start(("3 - x", "x - z")), ["pin.angle"], ["lag.x"])
    report = linearize_command.report(model, "s")
    assert "linear model with 4 states" in report
    assert "note: states change here: 'lag.x' by 3 V/s, 'lag.z' by -0.5 A/s/s" in report
    rests = rest(("2 - x", "x - z"))
    assert equilibrium_command.numbers(rests, [], "s", "o", None)["states"] == pytest.approx(
        {"lag.x": 2.0, "lag.z": 2.0}
    )
    assert "  states\n    lag.x  2 V\n    lag.z  2 A/s" in equilibrium_command.report(rests, [], "s")


def test_files_hold_them(tmp_path):
    scene, system, state = made(VIBRATES, start=(0.0, 0.0))
    found = modes(reference_at(system, state, "start"))
    read = read_modes(write_modes(tmp_path / "modes.h5", stored(found, "t"), scene))
    assert (read.states, read.state_units) == (("lag.x", "lag.z"), ("V", "A/s"))
    np.testing.assert_array_equal(read.state_shape, found.states)
    np.testing.assert_array_equal(read.state_share, found.state_share)
    record_equilibrium(scene, tmp_path / "equilibrium.h5", equilibrium(system, state), {})
    with open_results(tmp_path / "equilibrium.h5") as results:
        assert results.names("states") == ("lag.x", "lag.z")
        np.testing.assert_allclose(results["states/value"], [[0.0, 0.0]], atol=1e-12)


def test_files_from_before_have_none(tmp_path):
    scene, system, state = made(VIBRATES, start=(0.0, 0.0))
    path = write_modes(tmp_path / "modes.h5", stored(modes(reference_at(system, state, "start")), "t"), scene)
    with h5py.File(path, "r+") as file:
        for name in ("state_names", "state_units", "state_real", "state_imag", "state_share"):
            del file["modes"][name]
    read = read_modes(path)
    assert read.states == ()
    assert read.state_share.shape == (2, 0)


# Linear models of mechanisms whose functions name channels: a motor with a controller, and forces that go by the motion
# of something else, against the equations of their own and against differences of what a run integrates.

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
