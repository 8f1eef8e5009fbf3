"""Linear models of mechanisms whose elements have states: x' = f is linear in them, as SciPy or a closed form says."""

from __future__ import annotations

from dataclasses import replace

import h5py
import numpy as np
import pytest

from mbproj.cli.linear import equilibrium as equilibrium_command
from mbproj.cli.linear import linearize as linearize_command
from mbproj.cli.linear import modes as modes_command
from mbproj.integrate import simulate
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.mode_notes import notes_on
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space.model import linear_model
from mbproj.linear.stored import stored
from mbproj.results import open_results, read_modes, write_modes
from mbproj.runs import record_equilibrium
from mbproj.thresholds import THRESHOLDS
from tests.model.element_scenes import PENDULUM, case
from tests.support import Recorder

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
    monkeypatch.setattr("mbproj.dynamics.blocks.THRESHOLDS", replace(THRESHOLDS, large=0))
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
