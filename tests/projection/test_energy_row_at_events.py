"""The energy balance as a row of the velocity projection in motions with events, contacts, friction, stiff forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbproj.dynamics import assemble
from mbproj.integrate import Mark, simulate
from mbproj.model import compile_system, initial_guess
from mbproj.runs import notes_on_rows
from mbproj.scene import read_scene, read_scene_text, settings_to_run, with_options
from tests.crossed import crossed
from tests.integrate.event_scenes import bounce, height_at
from tests.integrate.stiff_scenes import CLAMP
from tests.projection.long_runs import CONTROLLED, SCENES, run
from tests.support import Recorder

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
    whole = float(options.get("duration", what.settings.duration or 1.0))
    marks: list[Mark] = []

    def simulated(duration: float, **others: Any) -> tuple[Any, Recorder]:
        asked = with_options(what, {**options, "energy_row": "true", "duration": str(duration)})
        system, recorder = compile_system(asked), Recorder()
        state = assemble(system, initial_guess(asked, system))
        return simulate(system, state, settings_to_run(asked), recorder, **others), recorder

    report, recorded = simulated(whole)
    simulated(whole / 2, keep=lambda name, build, mark: marks.append(mark))
    continued, rest = simulated(whole, resumed=marks[-1])
    assert continued.rows == report.rows and report.rows.steps > 0
    assert np.array_equal(rest["bodies/position"][-1], recorded["bodies/position"][-1])
