"""Steps end at events in time and in the state, in every formulation, and methods keep their order."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from mbproj.base.errors import SimulationError
from mbproj.equations.assembly.compiled import compile_system
from mbproj.motion.time_events import time_events
from mbproj.scene.scene import read_scene_text
from tests.crossed import crossed, full
from tests.integrate.event_scenes import (
    DOOR,
    INERTIA,
    TROLLEY,
    bounce,
    contact_times,
    door_times,
    height_at,
    rotor,
    run,
)

# Events in time: steps end where functions of time have kinks, jumps or narrow features, in every formulation.

FORMULATIONS = ("full", "reduced", "planar")
#: Torques of 0.4 ms or less, with their impulses in N m s.
PULSES = {
    "500*(sign(t - 1) - sign(t - 1.0004))": 0.4,
    "1000*max(0, 1 - abs(t - 1)/2e-4)": 0.2,
    "1000*exp(-((t - 1)/1e-4)**2)": 0.1 * np.sqrt(np.pi),
    "500*(sign(t - 1) - sign(t - 1.0004))*(1 + 0*angle)": 0.4,
}
#: A jump, a kink, and what is smooth.
TORQUE = "sin(3*t) - 2*sin(angle) + 2*sign(t - 0.513) + 3*abs(t - 1.137)"


def events(text: str, end: float) -> list[tuple[float, str, str]]:
    system = compile_system(read_scene_text(text))
    return [(event.time, event.name, event.kind) for event in time_events(system, 0.0, end, end / 1000)]


def last_angle(torque: str, **options: str) -> float:
    return float(run(rotor(torque), **options)[0]["joints/coordinate"][-1, 0])


@crossed(
    "formulation, integrator, torque",
    [
        pytest.param(*each)
        for each in (("full", "dopri5"), *product(("reduced", "planar"), ("bs32", "dopri5", "dop853")))
    ],
    PULSES,
    dear=["full"],
)
def test_a_short_pulse_is_not_lost(formulation, integrator, torque):
    """I ω = ∫τ dt after it, at a tolerance of 1e-8 with steps that would pass over it."""
    recorder, _ = run(rotor(torque), formulation=formulation, integrator=integrator, tolerance="1e-8", output_step="1")
    assert recorder["joints/speed"][-1, 0] == pytest.approx(PULSES[torque] / INERTIA, rel=3e-5)


@crossed(
    "formulation, integrator, order, steps",
    FORMULATIONS,
    [pytest.param("dop853", 8, ("0.25", "0.125")), pytest.param("rk4", 4, ("0.02", "0.01"))],
    dear=["full"],
)
def test_fixed_steps_keep_their_order_across_a_jump_and_a_kink(formulation, integrator, order, steps):
    exact = last_angle(TORQUE, integrator="dop853", tolerance="1e-14", output_step="2")
    coarse, fine = (
        abs(last_angle(TORQUE, integrator=integrator, step=step, formulation=formulation) - exact) for step in steps
    )
    assert np.log2(coarse / fine) > order - 0.4


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_grid_of_fixed_steps_stays(formulation):
    """The step with the jump in it is split; its second part ends where it would have ended."""
    recorder, report = run(rotor("sign(t - 0.513)"), formulation=formulation, integrator="rk4", step="0.1")
    np.testing.assert_array_equal(recorder["time"], [*(0.1 * np.arange(20)), 2.0])
    assert report.counters["steps"] == 21
    assert recorder["diagnostics/step_size"][6] == pytest.approx(0.087)


@pytest.mark.parametrize("how", [{"integrator": "rk4", "step": "0.1"}, {"integrator": "dopri5", "tolerance": "1e-9"}])
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_sample_at_a_jump_belongs_to_its_time(formulation, how):
    """sign(0) = 0: no torque at t = 1 itself; before it one, after it another, so that the speed is |t - 1| - 1."""
    recorder, _ = run(rotor("0.5*sign(t - 1)"), formulation=formulation, output_step="0.1", **how)
    time = recorder["time"]
    np.testing.assert_allclose(recorder["bodies/angular_acceleration"][:, 0, 1], np.sign(time - 1.0), atol=1e-9)
    np.testing.assert_allclose(recorder["joints/speed"][:, 0], np.abs(time - 1.0) - 1.0, atol=1e-5)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_jump_at_the_start_is_seen_from_the_right(formulation):
    """sign(t) is 0 at the start alone: a first stage that saw it would lose a sixth of the first step's impulse."""
    recorder, _ = run(rotor("0.5*sign(t)"), formulation=formulation, integrator="rk4", step="0.05")
    np.testing.assert_allclose(recorder["joints/speed"][:, 0], recorder["time"], rtol=1e-3)


@pytest.mark.parametrize(
    "how",
    [
        {"integrator": "bs32", "tolerance": "1e-7"},
        {"integrator": "dopri5", "tolerance": "1e-8"},
        {"integrator": "dop853", "tolerance": "1e-8"},
        {"integrator": "rk4", "step": "10 ms"},
    ],
)
def test_a_move_between_two_rests_is_not_passed_over(how):
    """The load swings by 0.41 m about where the trolley has brought it."""
    fine, _ = run(TROLLEY, integrator="dop853", step="5 ms", tolerance=None, output_step="1")
    recorder, report = run(TROLLEY, **how, output_step="1")
    np.testing.assert_allclose(recorder["markers/position"], fine["markers/position"], atol=2e-5)
    assert fine["markers/position"][-1, 0, 0] == pytest.approx(0.9085, abs=1e-4)
    assert report.position_violation.value < 2e-13 and report.velocity_violation.value < 1e-13


def test_what_counts_as_an_event():
    found = events(TROLLEY, 10.0)
    assert [(round(time, 9), kind) for time, _, kind in found] == [(3.0, "kink"), (3.2, "kink")]
    assert {name for _, name, _ in found} == {"motion 'move'"}
    (pulse,) = (torque for torque in PULSES if "exp" in torque)
    (begins, ends) = events(rotor(pulse), 2.0)
    assert begins[2] == "narrow feature begins" and ends[2] == "narrow feature ends"
    assert 0.999 < begins[0] < 0.9998 and 1.0002 < ends[0] < 1.001


def test_a_pulse_is_one_feature_although_it_is_quiet_at_its_top():
    """Its value stands still there for some of the sampled times: without `quiet_stretch` it would end at 1.0118."""
    (begins, _, _), (ends, _, _) = events(rotor("exp(-((t - 1)/0.012)**2)"), 2.0)
    np.testing.assert_allclose([1.0 - begins, ends - 1.0], 0.049, rtol=0.01)
    assert 1.0 in [round(time, 9) for time, _, _ in events(rotor("sqrt(abs(t - 1))"), 2.0)]
    assert events(rotor("sqrt(0.2 - t)"), 2.0) == []  # it has no value from there on
    assert events(rotor("sin(40*t) + t**3 - exp(-2*t)*cos(7*t)"), 2.0) == []


def test_break_times_are_steps_ends():
    recorder, report = run(rotor("sin(t)"), integrator="dopri5", tolerance="1e-6", break_times="0.25,0.5 s,7")
    assert report.events == 2
    same, _ = run(rotor("sin(t)"), integrator="dopri5", tolerance="1e-6")
    assert recorder["joints/speed"][-1, 0] == pytest.approx(same["joints/speed"][-1, 0], abs=1e-5)
    _, fixed = run(rotor("sin(t)"), integrator="rk4", step="0.1", break_times="0.25,0.5")
    assert fixed.counters["steps"] == 21


def test_very_many_kinks_count_up_to_a_bound_and_are_named():
    _, report = run(rotor("abs(sin(5000*t))"), integrator="rk4", step="0.01")
    assert report.crowded == ("force 'push'",) and 1000 <= report.events <= 1002


#: Pulses of 0.5 ms that begin between two steps, with their impulses in N m s.
AT, WIDE = 0.5003, 5e-4
SHORT = {
    f"100*sin(pi*(t - {AT})/{WIDE})*(sign(t - {AT}) - sign(t - {AT} - {WIDE}))/2": 200 * WIDE / np.pi,
    f"100*sin(pi*(t - {AT})/{WIDE})*(1 + 0*angle)*(sign(t - {AT}) - sign(t - {AT} - {WIDE}))/2": 200 * WIDE / np.pi,
    f"100*exp(-((t - {AT})/{WIDE})**2)": 100 * WIDE * np.sqrt(np.pi),
    f"50*(sign(t - {AT}) + 1)*exp(-max(0, t - {AT})/{WIDE})": 100 * WIDE,
    f"100*sin(pi*t/{WIDE})*(1 - sign(t - {WIDE}))/2": 200 * WIDE / np.pi,
}
#: A base that jumps by 0.3 m in 0.1 ms, and a mass behind a spring and a damper.
JUMP = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5 s}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  b: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  r: {type: prismatic, bodies: [ground, a], location: [0, 0, 0], axis: [1, 0, 0]}
  s: {type: prismatic, bodies: [a, b], location: [1, 0, 0], axis: [1, 0, 0]}
forces: {f: {type: linear_spring_damper, joint: s, stiffness: 20, damping: 12}}
motions: {m: {joint: r, displacement: {smooth_step: {to: 0.3, duration: 0.1 ms, start: 0.1234}}}}
markers: {m: {body: b, location: [1, 0, 0]}}
"""
FIXED = [("full", "rk4"), ("planar", "rk4"), ("reduced", "heun2"), ("planar", "dop853"), ("planar", "radau5")]


@crossed("formulation, integrator, torque", [full(*FIXED[0]), *(pytest.param(*each) for each in FIXED[1:])], SHORT)
def test_fixed_steps_are_split_where_a_pulse_is_shorter(formulation, integrator, torque):
    recorder, report = run(rotor(torque), formulation=formulation, integrator=integrator, step="0.01", output_step="1")
    assert recorder["joints/speed"][-1, 0] == pytest.approx(SHORT[torque] / INERTIA, rel=1e-3)
    assert report.unresolved == ()


@pytest.mark.parametrize(("formulation", "integrator"), FIXED)
def test_a_move_shorter_than_a_step(formulation, integrator):
    """The damper gives the mass c/m of the jump as speed; then it is a damped oscillator: x'' + 6 x' + 10 x = 0."""
    t = 0.5 - 0.12345
    away = np.exp(-3 * t) * (-0.3 * np.cos(t) + (6 * 0.3 - 3 * 0.3) * np.sin(t))  # with x' = 12/2 0.3 at its start
    for step in ("10 ms", "0.1 ms") if formulation == "planar" else ("10 ms",):
        recorder, _ = run(JUMP, formulation=formulation, integrator=integrator, step=step, output_step="0.5")
        assert recorder["markers/position"][-1, 0, 0] == pytest.approx(1.3 + away, abs=1e-4)


def test_the_grid_stays_where_steps_are_split():
    """The step is cut at both ends of the move, and the move into 16 parts."""
    recorder, report = run(JUMP, integrator="rk4", step="10 ms", output_step="10 ms")
    np.testing.assert_allclose(recorder["time"], 0.01 * np.arange(51), rtol=1e-15)
    assert report.counters["steps"] == 50 + 2 + 15


def test_what_steps_resolve_is_not_split():
    """Tables of straight pieces, constant pulses, and what is slow beside the step."""
    for torque in (
        "sign(t - 0.5003) - sign(t - 0.5006)",
        "abs(t - 0.513) + abs(t - 0.537) + 0.1*sin(t)",
        "sin(3*t) + abs(t - 1.0003)",
    ):
        _, report = run(rotor(torque), integrator="rk4", step="0.01")
        assert report.counters["steps"] <= 202


def test_what_parts_of_a_step_do_not_resolve_is_named():
    _, report = run(rotor("sin(1e8*t)*(sign(t - 0.5003) - sign(t - 0.5008))"), integrator="rk4", step="0.01")
    assert report.unresolved == ("force 'push', 0.0005 s wide at 0.5003 s",)


# Events in the state: steps end where a law changes its branch, in every formulation, and methods keep their order.

#: Where NumPy takes seconds, and other tests here are of it.
SELDOM_FULL = (full("full"), "reduced", "planar")
FINE = {"integrator": "dop853", "tolerance": "1e-11"}


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
