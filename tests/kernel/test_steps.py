"""The kernel's time loop: counters, schedules, times, turns, recording."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from mbproj.motion.steppers.tableau import load_tableau
from tests.crossed import crossed
from tests.kernel.scenes import bits, mechanism, needs_kernel, run, spinner
from tests.support import random_chain

pytestmark = needs_kernel
COUNTED = ("steps", "rejected_steps", "evaluations", "projections", "velocity_iterations", "projection_failures")
FORMULATIONS = ["full", "reduced", "planar"]


@pytest.fixture
def chain():
    return random_chain(12, ["revolute", "universal", "spherical"])


@pytest.mark.parametrize("integrator", ["heun2", "rk4", "bs32", "dopri5", "dop853"])
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_fixed_steps_count_as_in_full(integrator, formulation):
    """An evaluation at the start, and one for each stage of a step: the first stage is the last step's end."""
    _, report = run(mechanism("five_bar"), duration=0.1, step=0.03, integrator=integrator, formulation=formulation)
    counts = report.counters
    assert (counts["steps"], counts["rejected_steps"], counts["projections"]) == (4, 0, 4)
    assert counts["evaluations"] == 1 + 4 * load_tableau(integrator).stages
    assert counts["velocity_iterations"] == 4


@crossed("integrator, formulation", ["dopri5", "bs32", "dop853"], FORMULATIONS, dear=["full"])
def test_error_control_counts_as_in_full(integrator, formulation):
    """Two evaluations for the start and the first step's size; each trial all stages and the end; each accepted
    step one more after its projection; outputs inside steps the extension's stages and one each."""
    keys = {"duration": 0.1, "tolerance": 1e-5, "integrator": integrator, "formulation": formulation}
    _, sparse = run(mechanism("five_bar"), output_step=0.1, **keys)
    stages, counts = load_tableau(integrator).stages, sparse.counters
    trials = counts["steps"] + counts["rejected_steps"]
    assert counts["evaluations"] == 2 + stages * trials + counts["steps"]
    _, dense = run(mechanism("five_bar"), output_step=0.001, **keys)
    inside = 99  # no step ends at an output time but the last
    extra = len(load_tableau(integrator).extra_c) * counts["steps"]
    assert dense.counters["steps"] == counts["steps"]
    assert dense.counters["evaluations"] == counts["evaluations"] + inside + extra


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_samples_carry_the_counters_of_the_steps_that_lead_to_them(formulation):
    """A sample inside a step is one of that step, which is accepted and counted; the start has cost something too."""
    keys = {"tolerance": 1e-5, "integrator": "dopri5", "output_step": 0.02}
    recorder, _ = run(mechanism("five_bar"), duration=0.2, formulation=formulation, **keys)
    steps = recorder["diagnostics/steps"]
    assert steps[0] == 0
    assert np.all(steps[1:] >= 1)
    assert [recorder[f"diagnostics/{name}"][0] for name in ("evaluations", "factorisations")] == [2, 2]
    # Between two samples of one step no work is done but theirs.
    assert np.all(recorder["diagnostics/projections"] == steps)


@pytest.mark.parametrize("formulation", ["full", "reduced"])
def test_schedules_are_those_of_full(chain, formulation):
    """Every fourth step; never below a threshold; one level alone."""
    keys = {"duration": 2.0, "step": 0.05, "formulation": formulation}
    _, every = run(chain, projection={"every": 4}, **keys)
    assert [every.counters[name] for name in ("projections", "velocity_iterations")] == [10, 10]
    _, threshold = run(chain, projection={"threshold": 1e-5}, **keys)
    assert 0 < threshold.counters["projections"] < 40
    assert 1e-13 < threshold.position_violation.value <= 1e-5
    _, position = run(chain, projection={"velocity": False}, **keys)
    assert position.counters["velocity_iterations"] == 0
    assert position.position_violation.value <= 1e-13 < 1e-9 < position.velocity_violation.value
    _, velocity = run(chain, projection={"position": False}, **keys)
    assert velocity.counters["projection_iterations"] == 0
    assert velocity.velocity_violation.value <= 1e-12 < 1e-10 < velocity.position_violation.value


@pytest.mark.parametrize("options", [{"every": 3}, {"velocity": False}, {"position": False}, {"test": "paper"}])
def test_counters_of_schedules_are_those_of_full(chain, options):
    counts = [
        run(chain, duration=1.0, step=0.05, formulation=kind, projection=options)[1].counters
        for kind in ("full", "reduced")
    ]
    assert [counts[0][name] for name in COUNTED] == [counts[1][name] for name in COUNTED]


def test_the_papers_stop_test_asks_for_small_corrections_not_for_closed_joints(chain):
    """ΔqᵀMΔq + CᵀC <= tolerance (sect. 5): a loose one is met by the first pass, a tight one needs two or more. Below
    1e-28, |C| would have to be less than round-off leaves."""
    keys = {"duration": 1.0, "step": 0.1, "formulation": "reduced"}
    _, loose = run(chain, projection={"test": "paper", "tolerance": 1.0}, **keys)
    _, tight = run(chain, projection={"test": "paper", "tolerance": 1e-26}, **keys)
    assert loose.counters["projection_iterations"] == 10
    assert tight.counters["projection_iterations"] >= 20
    assert tight.counters["projection_failures"] == loose.counters["projection_failures"] == 0
    assert tight.position_violation.value <= 1e-13 < loose.position_violation.value


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
@pytest.mark.parametrize("way", [{"step": 0.01}, {"tolerance": 1e-6, "integrator": "dopri5"}])
def test_recording_does_not_change_the_motion(formulation, way):
    """The same bits at the times that both record."""
    fine, coarse = (
        run(mechanism("five_bar"), duration=0.4, output_step=step, formulation=formulation, **way)[0]
        for step in (0.01, 0.2)
    )
    assert [len(fine["time"]), len(coarse["time"])] == [41, 3]
    at = [
        {path: block[path][every] for path in block if not path.startswith("diagnostics")}
        for block, every in ((joined(fine), slice(None, None, 20)), (joined(coarse), slice(None)))
    ]
    assert bits([at[0]]) == bits([at[1]])


@pytest.mark.parametrize("scene", ["n_four_bar", "locomotive", "bennett"])
def test_recording_does_not_change_the_steps_near_singular_poses(scene):
    """Where steps are checked and shortened, and other rows are held: what samples look at has no say in it."""
    keys = {"duration": 2.0, "tolerance": 1e-8, "integrator": "dop853"}
    fine, coarse = (run(mechanism(scene), output_step=step, **keys) for step in (0.01, 1.0))
    assert [found.counters["steps"] for _, found in (fine, coarse)] == [coarse[1].counters["steps"]] * 2
    for name in ("bodies/position", "bodies/velocity"):
        assert np.array_equal(fine[0][name][-1], coarse[0][name][-1]), name


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_no_step_grows_after_one_that_was_made_again(formulation):
    """Every step has its sample here; some would grow: their ratio is 1 to the bit."""
    recorder, report = run(
        mechanism("five_bar"),
        duration=5.0,
        tolerance=1e-3,
        integrator="dopri5",
        output_step=0.002,
        formulation=formulation,
    )
    _, first = np.unique(recorder["diagnostics/steps"], return_index=True)
    assert len(first) == report.counters["steps"] + 1
    size, rejected = (recorder[f"diagnostics/{name}"][first] for name in ("step_size", "rejected_steps"))
    again = np.flatnonzero(np.diff(rejected[:-1]) > 0) + 1
    growth = size[again + 1] / size[again]
    assert np.count_nonzero(growth == 1.0) >= 3 and growth.max() <= 1.0


def joined(recorder):
    return {path: recorder[path] for path in recorder.blocks[0]}


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
@pytest.mark.parametrize(("speed", "step"), [(200.0, 0.02), (-200.0, 0.02), (50.0, 0.1), (3.0, 0.3)])
def test_turns_are_counted(formulation, speed, step):
    """By less and by more than half a turn a step (4 and 5 rad here), over many turns and either way."""
    recorder, _ = run(
        spinner(speed),
        duration=300 * step,
        step=step,
        integrator="dop853",
        formulation=formulation,
        output_step=3 * step,
    )
    angle = recorder["joints/coordinate"][:, 0]
    np.testing.assert_allclose(angle, speed * recorder["time"], rtol=2e-2, atol=1e-9)
    exact = np.arctan2(*recorder["markers/position"][:, 0, 1::-1].T)
    np.testing.assert_allclose(np.exp(1j * angle), np.exp(1j * exact), atol=1e-9)


def test_turns_are_counted_at_outputs_inside_steps():
    """By error control, whose steps are as long as several turns of a free wheel."""
    recorder, _ = run(
        spinner(40.0), duration=10.0, tolerance=1e-9, integrator="dop853", output_step=0.01, formulation="planar"
    )
    np.testing.assert_allclose(recorder["joints/coordinate"][:, 0], 40.0 * recorder["time"], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_a_wheel_that_has_turned_by_1e5_rad_is_closed_to_1e_13(formulation):
    recorder, report = run(
        spinner(1000.0), duration=100.0, step=1e-3, output_step=1.0, integrator="rk4", formulation=formulation
    )
    assert recorder["joints/coordinate"][-1, 0] == pytest.approx(1e5, rel=0.02)
    assert report.position_violation.value <= 1e-13
    assert report.counters["projection_failures"] == 0


@pytest.mark.full
def test_a_million_steps_keep_closure_and_time():
    """t = t0 + k h to the last bit at every output, joints closed at every step, and the energy kept. A step
    takes four evaluations, and no call of Python: what is called depends on the samples."""
    calls = 0

    def count(*_: object) -> None:
        nonlocal calls
        calls += 1

    sys.setprofile(count)
    try:
        recorder, report = run(
            mechanism("physical_pendulum"), duration=1e3, step=1e-3, output_step=10.0, integrator="rk4"
        )
    finally:
        sys.setprofile(None)
    assert calls < 500_000
    assert [report.counters[name] for name in ("steps", "evaluations")] == [1_000_000, 4_000_001]
    assert report.counters["projection_iterations"] <= 1_000_000
    assert recorder["time"].tolist() == [10_000 * k * 1e-3 for k in range(100)] + [1e3]
    assert report.position_violation.value <= 1e-13
    assert report.energy_drift_relative < 1e-9
