"""Springs and dry friction whose numbers name signals, and what is said of signals that are not finite."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbproj
from mbproj import InputError, SimulationError, equilibrium, export_model, modes, read_scene_text
from tests.crossed import crossed, full
from tests.elements.scenes import ran

# Springs whose numbers name signals: their motion, their energy, their rest and their linear model.

ON_RAIL = "type: linear_spring_damper, joint: rail"
BETWEEN = "type: spring_damper, points: {ground: [-1, 0, 0], cart: [0, 0, 0]}"
SPRINGS = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, output_step: 0.1 s, integrator: dop853, tolerance: 1e-12}
bodies:
  cart: {mass: 2 kg, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0], velocity: [1, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
signals:
  k: 50*(1 + 0.5*sin(3*t))
  c: 2 + rail.displacement**2
  push: spring.force
forces:
  spring: {WHERE, stiffness: k, damping: c, FREE}
"""


def force(t, s, v):
    return -50.0 * (1.0 + 0.5 * np.sin(3.0 * t)) * (s - 0.1 * np.sin(t)) - (2.0 + s * s) * v


@pytest.mark.parametrize(
    ("where", "free", "formulation"),
    [
        full(ON_RAIL, "free_displacement: 0.1*sin(t)", "full"),
        (ON_RAIL, "free_displacement: 0.1*sin(t)", "auto"),
        (BETWEEN, "free_length: 1 m + 0.1*sin(t)", "auto"),
    ],
)
def test_it_pulls_as_its_numbers_are_then(where, free, formulation):
    """Against an integration of the two unknowns; the energy is that of what is put in and lost."""
    system, found, report = ran(SPRINGS.replace("WHERE", where).replace("FREE", free), formulation=formulation)
    to = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    exact = solve_ivp(lambda t, y: [y[1], force(t, *y) / 2.0], (0.0, 1.0), [0.0, 1.0], t_eval=found["time"], **to).y
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], exact[0], atol=1e-12)
    assert np.allclose(found["signals/value"][:, 2], force(found["time"], *exact), atol=1e-10)
    assert np.allclose(found["forces/force"][:, 0], found["signals/value"][:, 2], atol=1e-13)
    assert report.energy_drift_relative < 1e-10
    assert found["states/value"][-1, system.names.states.index("spring.heat")] > 0.2


def test_what_a_stiffness_that_grows_puts_in_is_the_energy_that_the_spring_gains():
    """A weightless load's spring is stretched and stands: k s²/2 grows by the work done."""
    text = SPRINGS.replace("WHERE", ON_RAIL).replace(", damping: c, FREE", ", free_displacement: 0.2")
    text = text.replace(", velocity: [1, 0, 0]", "").replace("mass: 2 kg", "mass: 1e9 kg")
    _, found, report = ran(text.replace("k: 50*(1 + 0.5*sin(3*t))", "k: 50*(1 + t)"), duration=1)
    work = found["diagnostics/work"][-1]
    assert work == pytest.approx(0.5 * 50.0 * 0.2**2, rel=1e-6)
    assert report.energy_drift_relative < 1e-9


def test_a_free_length_that_is_not_given_is_that_of_the_pose():
    text = SPRINGS.replace("WHERE", BETWEEN).replace(", FREE", "").replace(", velocity: [1, 0, 0]", "")
    _, found, _ = ran(text, duration=0.1)
    assert np.abs(found["joints/coordinate"][:, 0]).max() < 1e-14


@pytest.mark.parametrize("integrator", ["radau5", "esdirk4", "auto"])
def test_implicit_steps_know_its_slope(integrator):
    text = SPRINGS.replace("WHERE", ON_RAIL).replace("FREE", "free_displacement: 0")
    stiff = text.replace("k: 50*", "k: 5e6*").replace("c: 2 ", "c: 5e4 ")
    _, found, report = ran(stiff, integrator=integrator, tolerance=1e-7)
    exact = ran(stiff, integrator="dop853", tolerance=1e-10)[1]
    assert np.abs(found["joints/coordinate"] - exact["joints/coordinate"]).max() < 1e-6
    assert report.counters["evaluations"] < 5000


def test_rest_and_modes_go_by_what_the_signal_is_there():
    """k = 40 + 100 s and a push of 10 N: 100 s² + 40 s = 10, and dF/ds = -(40 + 200 s)."""
    text = SPRINGS.replace("WHERE", ON_RAIL).replace("damping: c, FREE", "free_displacement: 0")
    text = text.replace("50*(1 + 0.5*sin(3*t))", "40 + 100*rail.displacement").replace(", velocity: [1, 0, 0]", "")
    text += "  load: {type: force, body: cart, force: [10 N, 0, 0]}\n"
    scene = read_scene_text(text)
    s = (-40.0 + np.sqrt(40.0**2 + 4000.0)) / 200.0
    rest = equilibrium(scene)
    assert rest.coordinates["rail.displacement"] == pytest.approx(s, abs=1e-12)
    found = modes(scene, at="equilibrium")
    assert max(abs(found.eigenvalues)) == pytest.approx(np.sqrt((40.0 + 200.0 * s) / 2.0), rel=1e-9)


def test_an_export_says_that_its_numbers_change():
    text = SPRINGS.replace("WHERE", ON_RAIL).replace("damping: c, FREE", "free_displacement: 0")
    table = export_model(read_scene_text(text), "mjcf").table
    said = dict(zip(table["element"], table["what"], strict=True))
    assert said["force 'spring'"] == "left out: numbers of it change in a run"


# Dry friction whose coefficients and forces name signals: sliding, sticking, and where it gives way.

G = 9.81
SLIDER = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2 s, output_step: 0.01 s, integrator: dop853, tolerance: 1e-11}
bodies:
  cart: {mass: 2 kg, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0], velocity: [SPEED, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
signals:
  mu: MU
forces:
  brake: {type: friction, joint: rail, coulomb: {FRICTION}}
  push: {type: linear_spring_damper, joint: rail, force: PUSH}
"""


def scene(speed, mu, friction, push):
    return SLIDER.replace("SPEED", speed).replace("MU", mu).replace("FRICTION", friction).replace("PUSH", push)


@pytest.mark.full_where(formulation="full")
@crossed("friction, formulation", ["coefficient: mu", "force: mu * 19.62 N"], ["auto", "full"], dear=["full"])
def test_it_slides_stops_sticks_and_breaks_away_as_the_signal_says(friction, formulation):
    """v' = -μ g with μ = 0.4 - 0.2 t from 2 m/s; it rests, and slides again when 2 μ g falls below 1 N: t = 1.7452."""
    text = scene("2", "0.4 - 0.2*t", friction, "-1 N").replace("push:", "push: ")
    _, found, report = ran(text, formulation=formulation, output_step=2 if formulation == "full" else 0.01)
    accelerates = np.poly1d([0.1 * G, -0.4 * G - 0.5, 2.0])  # v: of friction and of the push of -1 N
    rests = float(min(root.real for root in accelerates.roots))
    way = float(np.polyint(accelerates)(rests))
    slips = (0.4 - 1.0 / (2.0 * G)) / 0.2
    v = np.polyint(np.poly1d([-0.2 * G, 0.4 * G - 0.5]))  # goes backwards: friction drives forwards
    end = np.polyint(v - v(slips))
    assert found["joints/coordinate"][-1, 0] == pytest.approx(way + end(2.0) - end(slips), abs=1e-9)
    assert report.energy_drift_relative < 1e-9


def test_fixed_and_implicit_steps_find_the_same():
    text = scene("2", "0.4 - 0.2*t", "coefficient: mu", "-1 N")
    exact = ran(text)[1]["joints/coordinate"][-1, 0]
    for settings in (
        {"integrator": "rk4", "tolerance": None, "step": 0.01},
        {"integrator": "radau5", "tolerance": 1e-9},
    ):
        assert ran(text, **settings)[1]["joints/coordinate"][-1, 0] == pytest.approx(exact, abs=1e-7)


def test_what_holds_is_at_least_what_slides_and_nothing_is_below_0():
    text = scene("1", "0.1 - 0.2*t", "coefficient: mu, static: 0.5*mu", "0 N")
    _, found, _ = ran(text, duration=1)
    assert found["joints/speed"][-1, 0] == pytest.approx(1.0 - G * 0.1 * 0.5 / 2.0, abs=1e-9)


def test_regularised_friction_takes_signals_too():
    text = scene("1", "0.1 + rail.displacement", "coefficient: mu, regularised: 1e-6 m/s", "0 N")
    _, found, _ = ran(text, duration=0.2)
    s, v = found["joints/coordinate"][-1, 0], found["joints/speed"][-1, 0]
    assert 0.5 * v**2 - 0.5 == pytest.approx(-G * (0.1 * s + 0.5 * s**2), abs=1e-9)


# What is said of signals that are not finite, of instants of controllers, and of names of rates.

ROOT = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2 s, output_step: 0.02 s, HOW}
bodies:
  rod: {mass: 1 kg, inertia: [0.02, 0.02, 0.02], position: [0, 0, -0.4]}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, -1, 0]}
markers:
  tip: {body: rod, location: [0, 0, -0.8]}
signals:
  other: 3 + t
  inner: sqrt(0.3 - pin.angle)
  U: 2 + 20*inner + 0*other
controllers:
  pd: {period: 2 ms, hold: {u: HELD}}
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: U + 3}
"""


@pytest.mark.parametrize(
    "how", ["tolerance: 1e-9", "integrator: rk4, step: 1 ms", full("formulation: full, tolerance: 1e-5")]
)
def test_the_first_signal_that_is_not_finite_is_named_with_its_inputs(how):
    with pytest.raises(SimulationError) as stopped:
        ran(ROOT.replace("HOW", how).replace("HELD", "0"))
    assert stopped.value.time == pytest.approx(0.0859, abs=1e-3)
    said = str(stopped.value)
    assert "at force 'motor': 'U + 3' fails: signal 'inner' is not finite: 'sqrt(0.3 - pin.angle)', sqrt(-" in said
    assert "is not finite, with pin.angle = 0.3" in said


def test_so_is_that_of_a_controller():
    text = ROOT.replace("HOW", "tolerance: 1e-6").replace("HELD", "inner").replace("torque: U + 3", "torque: 20")
    with pytest.raises(SimulationError, match=r"controller 'pd': 'inner' fails: signal 'inner' is not finite"):
        ran(text)


@pytest.mark.parametrize(
    ("how", "period", "note"),
    [
        ("integrator: rk4, step: 5 ms", "3 ms", "'pd' acts inside of steps of 0.005 s: they end there"),
        ("integrator: rk4, step: 5 ms", "1 ms", "up to 1000 steps a second beside 200"),
        ("integrator: rk4, step: 5 ms", "20 ms", ""),
        ("tolerance: 1e-6", "3 ms", ""),
        ("tolerance: 1e-6", "3 s", "'pd' has one instant in a run of 2 s"),
    ],
)
def test_instants_that_cost_steps_or_never_come_are_noted(how, period, note):
    text = ROOT.replace("HOW", how).replace("HELD", "0").replace("period: 2 ms", f"period: {period}")
    notes = [str(each) for each in read_scene_text(text).notes]
    assert len(notes) == bool(note)
    assert note in "".join(notes)


def test_rates_are_suggested_by_what_signals_call_them():
    for wrong, right in (("pin.angle_speed", "pin.angle_dot"), ("tip.velocity_x", "tip.x_dot")):
        text = ROOT.replace("HOW", "tolerance: 1e-6").replace("HELD", wrong)
        with pytest.raises(InputError, match=f"unknown name '{wrong}'; did you mean '{right}'"):
            read_scene_text(text)


def test_linear_models_know_rates_by_both_names():
    text = ROOT.replace("HOW", "tolerance: 1e-6").replace("HELD", "0").partition("controllers:")[0]
    found = mbproj.linearize(
        read_scene_text(text),
        inputs=["pin.angle"],
        outputs=["pin.angle_speed", "pin.angle_dot", "tip.velocity_x", "tip.x_dot"],
    )
    C = np.asarray(found.matrices[2])
    np.testing.assert_array_equal(C[0], C[1])
    np.testing.assert_array_equal(C[2], C[3])
    assert np.abs(C[0]).max() > 0.1


SLOW = """
import sys, time
import mbproj

mbproj.run(sys.argv[1], controller=lambda t, see: time.sleep(0.02), period=0.01, output=sys.argv[2])
"""


def test_a_killed_run_with_a_function_is_known_as_one(tmp_path):
    """So that neither `rerun` nor `continue` goes on without it."""
    scene, results = tmp_path / "scene.yaml", tmp_path / "out.h5"
    text = ROOT.replace("HOW", "integrator: rk4, step: 1 ms").replace("HELD", "0").replace("torque: U + 3", "torque: 0")
    scene.write_text(text.replace("  inner: sqrt(0.3 - pin.angle)\n", "").replace("20*inner + ", ""))
    process = subprocess.Popen([sys.executable, "-c", SLOW, str(scene), str(results)])
    part = tmp_path / "out.h5.part"
    for _ in range(300):
        if part.exists() and part.stat().st_size:
            break
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert part.exists()
    for again in (mbproj.rerun, mbproj.continue_run):
        with pytest.raises(InputError, match="a function in Python acted on the run"):
            again(results)


def test_whether_a_dataset_is_there(tmp_path):
    text = ROOT.replace("HOW", "tolerance: 1e-6").replace("HELD", "0").replace("torque: U + 3", "torque: 0")
    found = mbproj.run(read_scene_text(text.replace("duration: 2 s", "duration: 0.1 s")))
    assert "signals/value" in found
    assert "joints/coordinates" not in found
