"""The energy balance and momenta as rows of the velocity projection, also with events, contacts and stiff forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mbproj
from mbproj import Report, Scene
from mbproj.equations.assembly.compiled import compile_system
from mbproj.motion.formulations import choice
from mbproj.motion.formulations.invariants import momenta_of
from mbproj.motion.marks import Mark
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.scene.settings import settings_to_run, with_options
from mbproj.studies.record import notes_on_rows
from tests.crossed import crossed
from tests.integrate.event_scenes import bounce, height_at
from tests.integrate.stiff_scenes import CLAMP
from tests.support import ROOT, Recorder, assembled

SCENES = ROOT / "mechanisms"
FIXED = {"step": 0.01, "integrator": "rk4"}
CONTROLLED = {"tolerance": 1e-9, "integrator": "dop853"}
IMPLICIT = {"tolerance": 1e-6, "integrator": "esdirk4"}

#: A pendulum that never rests, with a torque, a damper and a spring; a motor's motion drives a cart below it.
WORKED = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {duration: 1 s, step: 0.01, output_step: 0.05}
bodies:
  cart: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  bar: {mass: 2 kg, inertia: [0.01, 0.2, 0.2], position: [0.5, 0, 0], angular_velocity: [0, 0, 9]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
  pin: {type: revolute, bodies: [cart, bar], location: [0, 0, 0], axis: [0, 0, 1]}
motions:
  shake: {joint: rail, displacement: "0.1*sin(3*t)"}
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: "2*cos(angle)"}
  coil: {type: torsion_spring_damper, joint: pin, stiffness: 5, damping: 0.1}
"""


def run(scene: str, parameters: dict[str, str] | None = None, **options: Any) -> tuple[Report, Recorder]:
    """Of a scene of ours, or of a text."""
    options = {name: str(value) for name, value in options.items()}
    given = parameters or {}
    what = read_scene_text(scene) if "\n" in scene else read_scene(SCENES / f"{scene}.yaml", given)
    what = with_options(what, options)
    system, state = assembled(what)
    recorder = Recorder()
    return simulate(system, state, settings_to_run(what), recorder), recorder


# The energy balance and momenta as rows of the velocity projection, in runs.

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
    assert len(momenta_of(*assembled(read_scene(SCENES / f"{scene}.yaml")))) == number


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


def goes_on(scene: Scene, options: dict[str, Any], duration: float) -> None:
    """Checks that a run that goes on from half of the time has the bits of the whole one, and that its row acts."""
    marks: list[Mark] = []

    def simulated(until: float, **others: Any) -> tuple[Report, Recorder]:
        given = {**options, "energy_row": "true", "duration": until}
        asked = with_options(scene, {name: str(value) for name, value in given.items()})
        recorder = Recorder()
        return simulate(*assembled(asked), settings_to_run(asked), recorder, **others), recorder

    whole, recorded = simulated(duration)
    simulated(duration / 2, keep=lambda name, build, mark: marks.append(mark))
    report, rest = simulated(duration, resumed=marks[-1])
    assert report.rows == whole.rows and report.rows.steps > 0
    assert np.array_equal(rest["bodies/position"][-1], recorded["bodies/position"][-1])


@crossed("how, formulation", HOW, ["reduced", "planar"])
def test_a_continued_run_has_the_same_bits(formulation: str, how: dict[str, Any]) -> None:
    goes_on(read_scene_text(WORKED), {**how, "formulation": formulation, "output_step": 0.05}, 0.3)


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


# The energy balance as a row of the velocity projection in motions with events, contacts, friction, stiff forces.

#: With impacts, dry friction that sticks and slides, compliant stops, motors.
CONTACTS = ("bouncing_ball", "newtons_cradle", "door_closer", "drum_brake", "stick_slip", "quarter_car", "bump_stop")


@crossed("scene, how", CONTACTS, ["dop853", "radau5", "auto"], together=1)
def test_contacts_begin_a_new_balance_and_each_step_is_counted_once(scene: str, how: str) -> None:
    options = {"integrator": how, "tolerance": 1e-7}
    _, free = run(scene, **options)
    report, found = run(scene, **options, energy_row="true")
    rows = report.rows
    assert rows.steps + rows.rest + rows.refused == report.counters["steps"]
    assert rows.refused == 0 and not list(notes_on_rows(report))
    off = np.abs(found["bodies/position"][-1] - free["bodies/position"][-1]).max()
    assert off < 3e-6


def test_impacts_in_the_full_formulation_begin_a_new_balance() -> None:
    options = {**CONTROLLED, "duration": 1.0, "formulation": "full", "energy_row": "true"}
    report, _ = run("bouncing_ball", **options)
    assert report.rows.steps + report.rows.rest == report.counters["steps"] and not report.rows.refused
    assert report.energy_drift_relative < 1e-13 and report.events > 0


@pytest.mark.parametrize(
    "how", [{"integrator": "rk4", "step": 0.002}, CONTROLLED, {"integrator": "auto", "tolerance": 1e-8}]
)
def test_a_mass_bounces_on_a_spring_as_in_closed_form(how: dict[str, Any]) -> None:
    report, found = run(bounce(), **how, duration=2, output_step=0.1, energy_row="true")
    height = found["bodies/position"][:, 0, 2]
    exact = np.array([height_at(t) for t in found["time"]])
    assert np.abs(height - exact).max() < (1e-3 if "step" in how else 3e-7)
    assert report.rows.steps > 0 and report.energy_drift_relative < (1e-2 if "step" in how else 1e-8)


#: A mass on a spring with a damper, driven; it starts on its steady motion x = cos 2t, where the spring is slack.
DRIVEN = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 20 s, step: 0.05, integrator: rk4, output_step: 0.1}
bodies: {mass: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}}
forces:
  coil: {type: linear_spring_damper, joint: rail, stiffness: 30, damping: 4}
  push: {type: linear_spring_damper, joint: rail, force: "22*cos(2*t) - 8*sin(2*t) - 30"}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_damped_driven_motion_keeps_its_closed_form_at_the_order_of_the_integrator(formulation: str) -> None:
    span = {"duration": 20, "output_step": 0.1, "formulation": formulation}
    off = []
    for h in (0.1, 0.05, 0.025):
        report, found = run(DRIVEN, **span, step=h, energy_row="true")
        off.append(np.abs(found["bodies/position"][:, 0, 0] - np.cos(2.0 * found["time"])).max())
        assert report.rows.steps > report.rows.rest and not report.rows.refused
    assert np.log2(off[0] / off[1]) > 3.5 and np.log2(off[1] / off[2]) > 3.5


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_auto_takes_the_balance_from_method_to_method(formulation: str) -> None:
    options = {"formulation": formulation, "energy_row": "true"}
    _, free = run(CLAMP, formulation=formulation)
    report, found = run(CLAMP, **options)
    assert any("radau5" in each or "esdirk4" in each for each in report.methods)
    assert report.rows.steps + report.rows.rest == report.counters["steps"]
    assert np.abs(found["bodies/position"] - free["bodies/position"]).max() < 1e-5


@pytest.mark.parametrize(
    ("scene", "options"),
    [
        (SCENES / "bouncing_ball.yaml", {"tolerance": "1e-8"}),
        (SCENES / "stick_slip.yaml", {"tolerance": "1e-8", "output_step": "0.05", "duration": "2"}),
        (CLAMP, {}),
    ],
    ids=["impacts", "friction", "auto"],
)
def test_a_run_with_events_continues_to_the_same_bits(scene: Any, options: dict[str, str]) -> None:
    what = read_scene_text(scene) if isinstance(scene, str) else read_scene(scene)
    goes_on(what, options, float(options.get("duration", what.settings.duration or 1.0)))
