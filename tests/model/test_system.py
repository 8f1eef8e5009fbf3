"""States of elements are a block of y: an entry of the layout alone has them recorded, continued, looked at for numbers
that are not finite, and controlled in their errors."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.errors import SimulationError
from mbproj.integrate import FullFormulation, simulate
from mbproj.linear import stored_state
from mbproj.results import ResultsWriter, open_results
from tests.crossed import crossed, full
from tests.integrate.event_scenes import bounce
from tests.model.element_scenes import DRIVEN, FORMULATIONS, T1, T2, case, run
from tests.support import Recorder

#: A mass that bounces on a rigid stop.
HITS = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, output_step: 0.05}
bodies: {ball: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints:
  guide: {type: prismatic, bodies: [ground, ball], location: [0, 0, 0], axis: [0, 0, 1],
          limits: {displacement: {range: [-0.2, 9], rigid: true, restitution: 0.6}}}
"""
FIXED = {"integrator": "rk4", "step": "0.005"}
BY_ERROR = {"integrator": "dopri5", "tolerance": "1e-9"}


def brief(formulation):
    """How long runs take, s: the full formulation takes milliseconds a step."""
    return 0.4 if formulation == "full" else 1.0


def exact(t):
    """x and z of the lags in closed form, from 0 and 0.5."""
    gain = 1.0 / (1.0 + 1j * DRIVEN * T1)
    first = (gain * np.exp(1j * DRIVEN * t)).imag
    left = -gain.imag  # of what decays with T1
    share = left * T1 / (T1 - T2)  # z' = (x - z)/T2 with x = left exp(-t/T1)
    steady = gain / (1.0 + 1j * DRIVEN * T2)
    second = (steady * np.exp(1j * DRIVEN * t)).imag + share * np.exp(-t / T1)
    return np.stack([first + left * np.exp(-t / T1), second + (0.5 - second[0]) * np.exp(-t / T2)], axis=1)


@crossed("integrator, formulation", ["dop853", "dopri5", "esdirk4", "radau5"], FORMULATIONS, dear=["full"])
def test_lags_are_those_of_the_closed_form(formulation, integrator):
    tolerance = "1e-7" if integrator in ("esdirk4", "radau5") else "1e-9"
    options = {"formulation": formulation, "integrator": integrator, "tolerance": tolerance}
    _, found, _ = run(options)
    np.testing.assert_allclose(found["states/value"], exact(found["time"]), atol=30 * float(tolerance))


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS[1:]])
def test_fixed_steps_keep_their_order(formulation):
    errors = []
    for step in ("0.01", "0.005"):
        _, found, _ = run({"formulation": formulation, "integrator": "rk4", "step": step}, until=brief(formulation))
        errors.append(np.abs(found["states/value"] - exact(found["time"])).max())
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.3


@pytest.mark.parametrize("formulation", [full("full"), *FORMULATIONS[1:]])
def test_errors_of_states_are_controlled_by_their_scale(formulation):
    """A quick state holds the steps; one whose scale is large does not, nor do quadratures and followed angles."""
    steps = []
    for scale in (1.0, 1e6):
        quick = ("300*cos(300*t)", "0*x")
        options = {"formulation": formulation, "integrator": "dopri5", "tolerance": "1e-6"}
        report, found, _ = run(options, brief(formulation), texts=quick, start=(0.0, 0.0), scale=(scale, 1.0))
        steps.append(report.counters["steps"])
        error = np.abs(found["states/value"][:, 0] - np.sin(300.0 * found["time"])).max()
        assert (error < 1e-4) == (scale == 1.0)
    assert steps[0] > 5 * steps[1]


@pytest.mark.full_where(formulation="full")
@crossed(
    "options, formulation",
    [FIXED, BY_ERROR, BY_ERROR | {"integrator": "radau5", "tolerance": "1e-5"}],
    FORMULATIONS,
    dear=["full"],
)
def test_they_go_on_with_the_bits_of_one_long_run(formulation, options):
    assert_goes_on(options | {"formulation": formulation}, brief(formulation))


@pytest.mark.parametrize("integrator", ["dopri5", "auto"])
@pytest.mark.parametrize("text", [bounce(), HITS], ids=["kinks", "impacts"])
def test_they_go_on_across_events_and_methods(text, integrator):
    """The kink of a law, and a rigid stop between whose impacts are legs: the end of one is the start of the next."""
    assert_goes_on(BY_ERROR | {"integrator": integrator}, text=text)


def assert_goes_on(options, until=1.0, **own):
    (_, whole, _), (_, _, marks) = run(options, until, **own), run(options, 0.5 * until, **own)
    _, rest, _ = run(options, until, resumed=marks[-1], **own)
    np.testing.assert_allclose(whole["states/value"], exact(whole["time"]), atol=1e-3)
    first = int(np.searchsorted(whole["time"], marks[-1]["t"], side="right"))
    assert 0 < first < len(whole["time"])
    for path in whole.blocks[0]:
        np.testing.assert_array_equal(rest[path], whole[path][first:], err_msg=path)


def test_a_results_file_has_them(tmp_path):
    scene, system, state, settings = case(BY_ERROR)
    recorder = Recorder()
    with ResultsWriter(tmp_path / "found.h5", scene, system.names.as_mapping()) as writer:
        simulate(system, state, settings, writer)
    simulate(system, state, settings, recorder)
    with open_results(tmp_path / "found.h5") as results:
        assert results.names("states") == ("lag.x", "lag.z")
        assert results.names("state_units") == ("V", "A/s")
        np.testing.assert_array_equal(results["states/value"], recorder["states/value"])
        again = stored_state(system, results, 0.5)
        np.testing.assert_array_equal(again.x, results["states/value"][10])


@pytest.mark.full_where(formulation="full")
@crossed("options, formulation", [FIXED, BY_ERROR], FORMULATIONS, dear=["full"])
def test_a_rate_without_a_value_names_its_state(formulation, options):
    with pytest.raises(SimulationError, match=r"state 'lag\.z'.*sqrt"):
        run(options | {"formulation": formulation}, texts=("-x", "sqrt(0.5 - t)"))


def test_a_projection_moves_the_blocks_that_say_so():
    _, system, state, settings = case(FIXED | {"formulation": "full"})
    formulation = FullFormulation.of(system, state, settings)
    layout = formulation.layout
    y = layout.vector_of(state.layout.common_blocks(state.y, layout))
    y = y + 1e-3 * np.random.default_rng(0).normal(size=len(y))
    moved, _ = formulation.project_between(0.0, y)
    for block in layout.blocks:
        assert block.size
        assert np.array_equal(moved[layout[block.name]], y[layout[block.name]]) != block.projected
