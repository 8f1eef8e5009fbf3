"""What is said of signals that are not finite, of instants of controllers, and of names of rates."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import mbproj
from mbproj import InputError, SimulationError, read_scene_text
from tests.crossed import full
from tests.elements.scenes import ran

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
