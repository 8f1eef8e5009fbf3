"""The drift of the energy in studies: its parts, and the row that holds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import read_scene
from mbproj.base.errors import InputError
from mbproj.commands.tradeoff import WARNED, _cells
from mbproj.studies.compare import compare, energy_split
from mbproj.studies.measure.reference import sampled
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism, sample_times, solve
from mbproj.studies.recommend import recommend
from mbproj.studies.stability import Limits, Subject, judged
from mbproj.studies.tradeoff import tradeoff
from mbproj.studies.verify.checks import verify
from tests.crossed import once, where
from tests.support import ROOT

# Studies know the row of the energy: what it gives, that it keeps the order, and that its balance proves nothing.

FOUR_BAR = ROOT / "mechanisms" / "planar_four_bar.yaml"
FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
TIMES = sample_times(1.0, 20)


def test_compare_shows_what_the_row_gives_and_takes():
    asked = {"integrators": ("rk4",), "steps": (0.01,), "until": 1.0, "repetitions": 1, "processes": 1}
    found = compare(read_scene(FOUR_BAR), projections=("none", "gpopm"), energy_rows=(False, True), **asked)
    assert [entry.label for entry in found.entries] == ["none", "gpopm", "gpopm, energy row"]
    _, without, kept = (entry.numbers for entry in found.entries)
    assert "energy_row_given" not in without
    assert kept["rows_steps"] == kept["steps"] and kept["rows_refused"] == 0
    assert kept["energy_row_moved"] >= abs(kept["energy_row_given"]) > 1e-8
    assert abs(kept["energy_drift"]) < 1e-12 < 1e-8 < abs(without["energy_drift"])
    assert kept["energy_drift_projection"] == pytest.approx(-kept["energy_drift_integrator"], abs=1e-12)
    assert kept["error"] < without["error"]
    with pytest.raises(InputError, match="'energy' is a row of the velocity projection, which is off"):
        compare(
            read_scene(FOUR_BAR, {}, {"project_velocity": False}), projections=("gpopm",), energy_rows=(True,), **asked
        )


@pytest.mark.parametrize(
    "setting",
    [Setting(step=0.01), Setting("gopm", step=0.005, every=3)],
    ids=str,
)
def test_the_rows_work_is_that_of_the_projection(slider_crank, setting):
    solution = solve(slider_crank, replace(setting, energy_row=True), TIMES)
    split = energy_split(slider_crank, solution)
    assert np.abs(split.integrator).max() > 1e-7
    assert split.integrator + split.projection == pytest.approx(solution.energy_balance, abs=1e-11)


@pytest.mark.parametrize(
    ("integrator", "name"), once(["rk4", "dop853", "esdirk4"], ["planar_four_bar", "double_pendulum", "governor"])
)
def test_the_order_of_the_integrator_is_kept_with_the_row(name, integrator):
    """The governor is damped."""
    options = {"energy_row": True, "integrator": integrator, "step": 1e-3}
    found = verify(read_scene(ROOT / "mechanisms" / f"{name}.yaml", {}, options))
    assert [(check.name, check.measured, check.allowed) for check in found.of("failed")] == []
    passed = {check.name: check.remark for check in found.of("passed")}
    assert f"{integrator} has order" in " ".join(passed.values())


@pytest.mark.full
def test_where_the_row_costs_the_order_verify_says_so():
    """What a stiff damper loses is integrated worse than the motion, and the row turns that into velocities."""
    path = ROOT / "mechanisms" / "split_coupler.yaml"
    failed = {}
    for row in (False, True):
        found = verify(read_scene(path, {}, {"energy_row": row, "integrator": "esdirk4", "step": 1e-3}))
        failed[row] = [check.name for check in found.of("failed")]
    assert failed == {False: [], True: ["order"]}


def test_a_step_that_the_balance_condemns_without_the_row_does_not_hold_with_it():
    scene = read_scene(FIVE_BAR)
    free, kept = (
        judged(Subject(scene, Setting(step=0.01, energy_row=row), 6.0, Limits(energy=1e-4)), 0.01)
        for row in (False, True)
    )
    assert free.state != "holds" and kept.state != "holds"
    assert kept.energy > 1e-4 and "the energy row gave or took" in kept.cause


@pytest.mark.parametrize(("name", "goal"), [("spherical_pendulum", 0.02), ("five_bar", 0.02)])
def test_of_what_is_recommended_no_run_notes_that_its_row_hides_a_wrong_motion(name, goal):
    options = {"output_step": 0.05, "energy_row": True}
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml", {}, options)
    found = recommend(scene, goal, until=1.0, timed=False)
    report = solve(Mechanism.of(scene), found.setting, sampled(scene, 1.0)).report
    assert found.setting.energy_row and found.best.at() <= goal
    assert report.doubt <= 1.0


@pytest.mark.full
def test_a_trade_off_marks_settings_of_which_their_runs_warn():
    found = tradeoff(
        read_scene(FIVE_BAR),
        projections=("gpopm",),
        integrators=("rk4",),
        until=2.0,
        longest=0.01,
        repetitions=1,
        processes=1,
    )
    warned = dict(zip(found.table["setting"], found.table["warned"], strict=True))
    assert {bool(each) for each in warned.values()} == {True, False}
    assert any(each for setting, each in warned.items() if "--energy-row true" in setting)
    for index, each in enumerate(found.table["warned"]):
        if found.trials[index].failure is None:
            assert _cells(found, index)[-1].endswith(WARNED) == bool(each)


# An energy drift is the sum of the integrator's part and the projections' work.

SETTINGS = [
    Setting(step=0.01),
    Setting("gopm", step=0.005, every=3),
    Setting(step=0.01, threshold=1e-6),
    Setting(step=0.01, formulation="full"),
    Setting("gopm", "heun2", step=0.0125 / 2),
    Setting("gopm", "esdirk4", step=0.01, every=3),
    Setting(integrator="radau5", step=0.01),
]


@pytest.mark.parametrize(
    "setting", where(lambda setting: setting.formulation != "full", SETTINGS), ids=lambda setting: setting.label
)
def test_the_parts_sum_up_to_the_drift(slider_crank, setting):
    solution = solve(slider_crank, setting, TIMES)
    split = energy_split(slider_crank, solution)
    drift = solution.energy_balance
    assert np.abs(drift).max() > 1e-6
    assert split.integrator + split.projection == pytest.approx(drift, abs=1e-11)


@pytest.mark.parametrize("integrator", ["dopri5", "dop853"])
def test_of_an_error_controlled_run_too(slider_crank, integrator):
    """At the end, which is the end of a step: samples inside are of the continuous extension. Single steps project with
    the factor of another stage than steps under error control, which counts in the second order."""
    solution = solve(slider_crank, Setting(integrator=integrator, tolerance=1e-5), TIMES)
    split = energy_split(slider_crank, solution)
    assert abs(solution.energy_balance[-1]) > 1e-7
    assert split.integrator[-1] + split.projection[-1] == pytest.approx(solution.energy_balance[-1], rel=1e-3)


def test_without_projection_all_is_the_integrators(slider_crank):
    solution = solve(slider_crank, Setting("none", step=0.01), TIMES)
    split = energy_split(slider_crank, solution)
    assert np.array_equal(split.integrator, solution.energy_balance)
    assert not split.projection.any()


def test_a_velocity_projection_by_mass_takes_kinetic_energy_only(slider_crank):
    """v' is the M-orthogonal projection of v: T' = T - ½ Δvᵀ M Δv (Pythagoras). In GOPM's metric that is not so."""
    work = {}
    for method in ("gpopm", "gopm"):
        solution = solve(slider_crank, Setting(method, step=0.01, project_position=False), sample_times(1.0, 100))
        work[method] = np.diff(energy_split(slider_crank, solution).projection)
    assert np.all(work["gpopm"] <= 1e-15)
    assert work["gpopm"].min() < -1e-9
    assert work["gopm"].max() > 1e-7
