"""The energy balance and momenta as rows of the velocity projection, in runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mbproj
from mbproj import Report
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.formulations import choice
from mbproj.motion.formulations.invariants import momenta_of
from mbproj.motion.marks import Mark
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.scene.settings import settings_to_run, with_options
from mbproj.studies.record import notes_on_rows
from tests.crossed import crossed
from tests.projection.long_runs import CONTROLLED, FIXED, IMPLICIT, SCENES, WORKED, run
from tests.support import Recorder

HOW = [pytest.param(IMPLICIT, id="esdirk4"), pytest.param(FIXED, id="rk4"), pytest.param(CONTROLLED, id="dop853")]


@crossed("how, formulation", HOW, ["planar", "reduced"])
def test_the_balance_of_driven_and_damped_mechanisms_holds_to_round_off(formulation: str, how: dict[str, Any]) -> None:
    options = {**how, "duration": 1.0, "output_step": 0.05, "formulation": formulation}
    without, _ = run(WORKED, **options)
    report, _ = run(WORKED, **options, energy_row="true")
    assert report.rows.steps == report.counters["steps"] and not report.rows.refused
    assert report.energy_drift < 2e-13
    assert without.energy_drift > 1e3 * report.energy_drift
    assert report.position_violation.value < 1e-12 and report.velocity_violation.value < 1e-12


@pytest.mark.parametrize("method", ["gopm", "mass-orthogonal"])
def test_every_metric_keeps_the_balance_and_the_joints(method: str) -> None:
    options = {**FIXED, "duration": 0.1, "output_step": 0.01, "projection": method}
    report, _ = run("spatial_slider_crank", **options, energy_row="true")
    assert report.rows.steps == 10
    assert report.energy_drift_relative < 1e-13 and report.velocity_violation.value < 1e-11


def test_full_has_no_rows_of_energy_and_momentum(monkeypatch: pytest.MonkeyPatch) -> None:
    said = "the full formulation has no rows of energy and momentum"
    for row in ("energy_row", "momentum_row"):
        with pytest.raises(mbproj.InputError, match=f"{said}; use reduced: 'formulation: reduced'"):
            run(WORKED, **FIXED, formulation="full", **{row: "true"})
    with pytest.raises(mbproj.InputError, match=f"{said}, and the projection 'mmopm' .* only; use reduced, which"):
        run(WORKED, **FIXED, projection="mmopm", energy_row="true")
    monkeypatch.setattr(choice, "core", lambda: None)
    with pytest.raises(mbproj.InputError, match="rows of energy and momentum need the kernel; install a C"):
        run(WORKED, **FIXED, energy_row="true", formulation="full")


def test_the_row_is_left_near_rest_and_said_so() -> None:
    report, _ = run("physical_pendulum", **FIXED, duration=3, output_step=0.1, energy_row="true")
    assert 0 < report.rows.rest < 40
    assert report.rows.steps + report.rows.rest == report.counters["steps"]


def test_a_mechanism_that_motions_drive_has_nothing_to_correct() -> None:
    text = WORKED.replace("forces:\n  motor", "unused").split("unused")[0] + '  swing: {joint: pin, angle: "9*t"}\n'
    report, _ = run(text, energy_row="true")
    assert report.degrees_of_freedom == 0 and report.rows.steps == 0


@pytest.mark.parametrize(("scene", "number"), [("heavy_top", 1), ("free_body", 6), ("spatial_four_bar", 0)])
def test_the_momenta_are_those_that_nothing_changes(scene: str, number: int) -> None:
    what = read_scene(SCENES / f"{scene}.yaml")
    system = compile_system(what)
    assert len(momenta_of(system, assemble(system, initial_guess(what, system)))) == number


def test_a_free_body_keeps_its_momenta_to_round_off() -> None:
    options = {**FIXED, "step": 0.05, "duration": 2, "output_step": 0.05}

    def change(**rows: str) -> float:
        _, found = run("free_body", **options, **rows)
        what = read_scene(SCENES / "free_body.yaml")
        system = compile_system(what)
        ω, Λ = found["bodies/angular_velocity"][:, 0], found["bodies/orientation"][:, 0]
        w, x = Λ[:, :1], Λ[:, 1:]
        L = ω @ system.inertia[0]
        turned = L + 2.0 * w * np.cross(x, L) + 2.0 * np.cross(x, np.cross(x, L))
        return float(np.abs(turned - turned[0]).max() / np.linalg.norm(turned[0]))

    assert change() > 1e-9
    assert change(momentum_row="true") < 1e-12


def test_a_top_keeps_its_energy_and_its_momentum_at_once() -> None:
    """The correction of the momentum changes the energy, which the other row takes into account."""
    options = {**FIXED, "step": 0.001, "duration": 0.2, "output_step": 0.02}
    alone, _ = run("heavy_top", **options, momentum_row="true")
    both, _ = run("heavy_top", **options, momentum_row="true", energy_row="true")
    assert alone.energy_drift_relative > 1e-10
    assert both.rows.steps == both.counters["steps"] and both.energy_drift_relative < 1e-14


@crossed("how, formulation", HOW, ["reduced", "planar"])
def test_a_continued_run_has_the_same_bits(formulation: str, how: dict[str, Any]) -> None:
    options = {**how, "formulation": formulation, "energy_row": "true", "output_step": 0.05}
    what = read_scene_text(WORKED)
    marks: list[Mark] = []

    def simulated(duration: float, **others: Any) -> tuple[Report, Recorder]:
        given = {**{name: str(value) for name, value in options.items()}, "duration": str(duration)}
        scene = with_options(what, given)
        system, recorder = compile_system(scene), Recorder()
        state = assemble(system, initial_guess(scene, system))
        return simulate(system, state, settings_to_run(scene), recorder, **others), recorder

    whole, recorded = simulated(0.3)
    simulated(0.15, keep=lambda name, build, mark: marks.append(mark))
    report, rest = simulated(0.3, resumed=marks[-1])
    assert report.rows == whole.rows and report.rows.steps > 0
    assert np.array_equal(rest["bodies/position"][-1], recorded["bodies/position"][-1])


def test_velocities_that_are_not_projected_have_no_rows() -> None:
    with pytest.raises(mbproj.InputError, match="'energy' is a row of the velocity projection, which is off"):
        run(WORKED, energy_row="true", project_velocity="false")
    with pytest.raises(mbproj.InputError, match="'none' has no 'energy'"):
        run(WORKED, energy_row="true", projection="none")


def test_a_motion_that_steps_do_not_resolve_is_refused_and_said_so() -> None:
    report, _ = run("heavy_top", integrator="rk4", step=0.02, duration=1, output_step=0.1, energy_row="true")
    assert report.rows.refused > 40 and report.energy_drift_relative > 1e-3
    (said,) = (each for each in notes_on_rows(report) if "refused" in each.text)
    assert f"refused at {report.rows.refused} of 50 steps" in said.text and report.doubt > 1.0


def test_of_more_freedoms_a_balance_that_is_kept_does_not_hide_what_a_note_would_say_without_it() -> None:
    options = {"integrator": "rk4", "step": 0.005, "duration": 8, "output_step": 0.1}
    without, _ = run("five_bar", **options)
    report, _ = run("five_bar", **options, energy_row="true")
    assert without.drifts and not report.drifts and report.rows.refused == 0
    assert report.hidden == pytest.approx(report.rows.furthest / report.exchanged / 1e-4)
    assert any("up to" in each.text and "although the balance is kept" in each.text for each in notes_on_rows(report))


def test_of_one_freedom_what_the_row_gives_in_sum_is_no_doubt() -> None:
    options = {"integrator": "rk4", "step": 0.005, "duration": 30, "output_step": 0.1}
    report, _ = run("planar_four_bar", **options, energy_row="true")
    assert report.rows.moved > 1e-5 * report.exchanged and report.doubt < 1.0
    assert not list(notes_on_rows(report))


def test_round_off_of_the_energy_is_not_corrected_where_next_to_nothing_moves() -> None:
    options = {**CONTROLLED, "duration": 5, "output_step": 0.1}
    given = {"start": "1e-7"}
    _, free = run("physical_pendulum", given, **options)
    report, found = run("physical_pendulum", given, **options, energy_row="true")
    assert report.rows.refused == 0 and not list(notes_on_rows(report))
    swung = np.abs(free["joints/coordinate"][:, 0]).max()
    assert 1e-8 < swung < 1e-6
    assert np.abs(found["joints/coordinate"] - free["joints/coordinate"]).max() < 1e-3 * swung
