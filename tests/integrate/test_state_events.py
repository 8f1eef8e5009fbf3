"""Events in the state: steps end where a law changes its branch, in every formulation, and methods keep their order."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.dynamics import assemble
from mbproj.errors import SimulationError
from mbproj.integrate import simulate
from mbproj.model import compile_system, initial_guess
from mbproj.scene import read_scene_text, settings_to_run
from tests.crossed import full
from tests.integrate.event_scenes import DOOR, INERTIA, bounce, contact_times, door_times, height_at, rotor
from tests.support import Recorder

FORMULATIONS = ("full", "reduced", "planar")
#: Where NumPy takes seconds, and other tests here are of it.
SELDOM_FULL = (full("full"), "reduced", "planar")
FINE = {"integrator": "dop853", "tolerance": "1e-11"}


class Log(Recorder):
    """A recorder that keeps the events, too."""

    def events(self, events) -> None:
        self.met = list(events)


def run(text: str, **options: str):
    scene = read_scene_text(text, simulation=options)
    system = compile_system(scene)
    log = Log()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), log)
    return log, report


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_mass_bounces_on_a_spring_as_in_closed_form(formulation):
    end = 0.5 if formulation == "full" else 2.0
    log, report = run(bounce(), formulation=formulation, duration=str(end), **FINE)
    expected = [t for t in contact_times(9) if t < end]
    assert len(expected) == report.events
    np.testing.assert_allclose([event.time for event in log.met], expected, atol=2e-11)
    assert [event.direction for event in log.met] == [-1, 1] * (len(expected) // 2)
    assert {(event.name, event.kind) for event in log.met} == {("force 'floor'", "kink of max")}
    height = [height_at(t) for t in log["time"]]
    np.testing.assert_allclose(log["bodies/position"][:, 0, 2], height, atol=2e-10)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_door_meets_its_stop_in_closed_form(formulation):
    log, _ = run(DOOR, formulation=formulation, duration="1.2", output_step="0.6", **FINE)
    np.testing.assert_allclose([event.time for event in log.met], door_times(), atol=1e-10)
    assert [event.kind for event in log.met] == ["kink of max", "kink of max", "jump of sign"]


@pytest.mark.parametrize(("integrator", "order"), [("dopri5", 5), ("dop853", 8)])
@pytest.mark.parametrize("text", [DOOR, bounce()], ids=["door", "bounce"])
def test_methods_keep_their_order(text, integrator, order):
    """The error falls with the number of steps to the power of the order, but for the few steps around events."""
    end = run(text, integrator="dop853", tolerance="1e-13", duration="1.5")[0]["bodies/position"][-1, 0]
    errors, steps = [], []
    for tolerance in ("1e-5", "1e-7", "1e-9", "1e-11"):
        log, report = run(text, integrator=integrator, tolerance=tolerance, duration="1.5")
        errors.append(np.linalg.norm(log["bodies/position"][-1, 0] - end))
        steps.append(report.counters["steps"])
    assert errors[-1] < 1e-9
    slope = np.polyfit(np.log(steps), np.log(np.maximum(errors, 1e-15)), 1)[0]
    assert -slope > 0.8 * order


@pytest.mark.parametrize(
    ("torque", "energy"),
    [
        ("-7*abs(angle)*angle", lambda s: 7.0 / 3.0 * abs(s) ** 3),
        ("-3*sign(angle)", lambda s: 3.0 * abs(s)),
        ("-2*floor(4*angle)", lambda s: 0.5 * np.floor(4.0 * s) * (4.0 * s - 0.5 * np.floor(4.0 * s) - 0.5)),
        ("-40*max(0, angle - 0.2)**1.5", lambda s: 16.0 * max(0.0, s - 0.2) ** 2.5),
        ("-5*min(angle, 0.3)", lambda s: 2.5 * min(s, 0.3) ** 2 + 1.5 * max(s - 0.3, 0.0)),
        ("-3*sqrt(max(0, angle - 0.1))", lambda s: 2.0 * max(0.0, s - 0.1) ** 1.5),
    ],
)
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_energy_is_kept_across_edges(formulation, torque, energy):
    """½ I ω² + the potential of the law, from ω = 2 rad/s at 0 on."""
    text = rotor(torque).replace("axis: [0, 1, 0]}", "axis: [0, 1, 0], speed: 2 rad/s}")
    log, report = run(text, formulation=formulation, output_step="0.5", **FINE)
    angle, speed = log["joints/coordinate"][:, 0], log["joints/speed"][:, 0]
    total = 0.5 * INERTIA * speed**2 + [energy(s) for s in angle]
    np.testing.assert_allclose(total, total[0], rtol=1e-8)
    assert report.events > 0


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_rows_and_ends_of_a_table_are_events(formulation):
    """A torque of -4 N m from 0.2 rad on, and none before: it stops the rotor, and throws it back."""
    table = "table: {rows: [[0, 0], [0.2, 0], [0.2001, -4], [0.7, -4]], between: linear}"
    text = rotor("1").replace('torque: "1"', table).replace("0, 1, 0]}", "0, 1, 0], speed: 1 rad/s}")
    log, _ = run(text, formulation=formulation, integrator="dopri5", tolerance="1e-9", duration="0.5")
    assert [(event.kind, event.direction) for event in log.met] == [("kink of table", d) for d in (1, 1, -1, -1)]
    assert log.met[0].time == pytest.approx(0.2, abs=1e-10)
    assert log["joints/speed"][-1, 0] == pytest.approx(-1.0, abs=1e-7)


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_a_brake_reverses_and_a_brake_that_sticks_stops_the_run(formulation):
    """I ω' = 5 - 5 t - 2 sign ω: ω = 0 at t = 1.2, where the load is -1 and the brake holds ±2."""
    brake = {"formulation": formulation, "integrator": "dopri5", "tolerance": "1e-9", "output_step": "1"}
    with pytest.raises(SimulationError, match=r"from both sides.*dry friction") as stopped:
        run(rotor("-2*sign(angle_dot) + 5*(1 - t)"), **brake)
    assert stopped.value.time == pytest.approx(1.2, abs=1e-9)
    assert "force 'push'" in str(stopped.value) and "'sign' in '-2*sign(angle_dot) + 5*(1 - t)'" in str(stopped.value)
    assert "on a joint write type: friction with 'coulomb', which sticks" in str(stopped.value)
    log, _ = run(rotor("-0.2*sign(angle_dot) + 5*(1 - t)"), **brake)  # ω = 0 at 1.92, where the load is -4.6
    assert [event.time for event in log.met] == [pytest.approx(1.92, abs=1e-9)]
    with pytest.raises(SimulationError, match="stopped at t = 0 s at force 'push'"):
        run(rotor("-2*sign(angle_dot) + 1"), **brake)
    log, _ = run(rotor("-2*sign(angle_dot) + 3"), **brake)
    assert log["joints/speed"][-1, 0] == pytest.approx(2.0 / INERTIA)
    assert run(rotor("-2*sign(angle_dot)"), **brake)[0]["joints/speed"][-1, 0] == 0.0


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_a_law_that_chatters_stops_the_run(formulation):
    with pytest.raises(SimulationError, match="from both sides"):
        run(rotor("-2*sign(angle) + 0.6"), formulation=formulation, **FINE)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_an_edge_that_jumps_in_time_is_seen(formulation):
    """The stop jumps to where the rotor is beyond it: from then on it pushes."""
    text = rotor("-100*max(0, angle - 0.5*(1.5 - sign(t - 0.5)))").replace("0, 1, 0]}", "0, 1, 0], speed: 1 rad/s}")
    log, _ = run(text, formulation=formulation, duration="1", output_step="0.1", **FINE)
    s, omega = log["time"][5:] - 0.5, np.sqrt(100.0 / INERTIA)
    start = np.hypot(0.25, 1.0 / omega) * np.cos(omega * s - np.arctan2(1.0 / omega, 0.25))
    near = start > -0.05
    np.testing.assert_allclose(log["joints/coordinate"][5:, 0][near][:2], 0.25 + start[near][:2], atol=1e-8)


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_fixed_steps_end_at_edges_too_and_return_to_their_grid(formulation):
    log, report = run(DOOR, formulation=formulation, integrator="dop853", step="0.01", duration="1.2")
    np.testing.assert_allclose([event.time for event in log.met], door_times(), atol=1e-10)
    np.testing.assert_allclose(log["time"], 0.1 * np.arange(13), atol=1e-15)
    assert report.passed == ""


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_an_edge_that_a_step_passes_there_and_back_is_met(formulation):
    """A mass thrown up at 2 m/s would pass a spring 0.15 m above it and be back within the one step of 0.4 s."""
    text = bounce("-5000*max(0, l - 10.15)").replace("axis: [0, 0, 1]", "axis: [0, 0, 1], speed: 2")
    log, _ = run(text, formulation=formulation, integrator="rk4", step="0.4", duration="0.4", output_step="0.4")
    assert log.met[0].time == pytest.approx((2.0 - np.sqrt(4.0 - 2.0 * 9.81 * 0.15)) / 9.81, abs=1e-12)


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_fixed_steps_pass_over_an_edge_that_pushes_back_and_say_so(formulation):
    """ω = 0 at t = 1.2, where the brake of 2 N m would hold the load of -1 N m. Other edges are located still."""
    law = "-2*sign(angle_dot) + 5*(1 - t) + 0*max(0, angle - 0.1)"
    log, report = run(rotor(law), formulation=formulation, integrator="rk4", step="0.01", duration="1.3")
    assert [event.kind for event in log.met] == ["kink of max", "jump of sign"]
    what, _, times = report.passed.partition("', ")
    assert what == f"force 'push': 'sign' in '{law}"
    assert times.endswith("first before t = 1.2 s")
    assert abs(log["joints/speed"][-1, 0]) < 0.03 / INERTIA


def test_samples_and_a_break_at_an_event_change_no_step():
    """Recording has no say in the steps: a sample may fall on an event, or very near to one."""
    meets, *_ = door_times()
    plain, few = run(DOOR, duration="1.5", **FINE)
    dense, many = run(DOOR, duration="1.5", integrator="dop853", tolerance="1e-11", output_step="0.001")
    assert few.counters["steps"] == many.counters["steps"]
    assert plain["joints/coordinate"][-1, 0] == dense["joints/coordinate"][-1, 0]
    log, _ = run(DOOR, duration="1.5", break_times=f"{meets!r}, 9", **FINE)
    assert log["joints/coordinate"][-1, 0] == pytest.approx(plain["joints/coordinate"][-1, 0], abs=1e-9)
