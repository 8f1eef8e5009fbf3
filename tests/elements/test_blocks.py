"""Blocks of signals: transfer functions, filters, gains, state spaces, limited rates, delays; against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal
from scipy.linalg import expm

from mbproj import compile_system, equilibrium, linearize, modes, read_scene, read_scene_text
from mbproj.base.errors import InputError
from tests.cli.commands import succeeds
from tests.elements.scenes import FORMULATIONS, ran

#: A cart that nothing pushes, and a signal.
SCENE = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5 s, output_step: 50 ms, integrator: dop853, tolerance: 1e-12, formulation: auto}
bodies:
  cart: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1, speed: 0.5}
signals:
  y: BLOCK
"""
WANTED = 3.0  # a step of so much


def output(block, formulation="auto", **options):
    """Times and the signal."""
    _, found, _ = ran(SCENE.replace("BLOCK", block), formulation=formulation, **options)
    return found["time"], found["signals/value"][:, 0]


@pytest.mark.parametrize("formulation", FORMULATIONS[1:] or FORMULATIONS)
@pytest.mark.parametrize(
    ("num", "den"), [([0.1, 1.0], [0.01, 1.0]), ([2.0], [0.02, 0.06, 1.0, 4.0]), ([1.0, 3.0, 20.0], [1.0, 4.0, 50.0])]
)
def test_a_transfer_function_answers_a_step_as_its_matrices_do(num, den, formulation):
    t, y = output(f"{{transfer_function: {{of: {WANTED}, num: {num}, den: {den}}}}}", formulation)
    _, expected = signal.step((num, den), T=t)
    assert y == pytest.approx(WANTED * expected, abs=1e-9)


@pytest.mark.parametrize("order", [1, 2, 3, 5, 6])
def test_a_filter_has_the_poles_of_butterworth(order):
    scene = read_scene_text(SCENE.replace("BLOCK", f"{{filter: {{of: 1, time: 20 ms, order: {order}}}}}"))
    own = linearize(scene, inputs=["rail.displacement"], outputs=["rail.displacement"])
    at = [index for index, name in enumerate(own.states) if name.startswith("y.")]
    _, poles, _ = signal.butter(order, 50.0, analog=True, output="zpk")
    assert np.sort_complex(np.linalg.eigvals(own.A[np.ix_(at, at)])) == pytest.approx(np.sort_complex(poles), rel=1e-9)
    t, y = output(f"{{filter: {{of: {WANTED}, time: 20 ms, order: {order}, initial: 1}}}}")
    _, step = signal.step(signal.butter(order, 50.0, analog=True), T=t)
    assert y == pytest.approx(1.0 + (WANTED - 1.0) * step, abs=1e-9)


def test_a_state_space_of_two_inputs_has_outputs_by_name():
    block = """
    state_space:
      {of: [rail.displacement, 2], A: [[-3, 1], [0, -4]], B: [[1, 0], [0, 2]], C: [[1, 0], [1, 1]], D: [[0, 0], [0, 5]],
       initial: [0.2, 0.3], outputs: [a, b]}"""
    # The place and speed of the cart, the states, and 1.
    A = np.zeros((5, 5))
    A[0, 1], A[2, [0, 2, 3]], A[3, [3, 4]] = 1.0, [1.0, -3.0, 1.0], [-4.0, 4.0]
    for formulation in FORMULATIONS:
        _, found, _ = ran(SCENE.replace("BLOCK", block), formulation=formulation, duration=0.1, tolerance=1e-10)
        t, (a, b) = found["time"], found["signals/value"].T
        x = np.array([expm(A * at) @ [0.1, 0.5, 0.2, 0.3, 1.0] for at in t])
        assert a == pytest.approx(x[:, 2], abs=1e-10)
        assert b == pytest.approx(x[:, 2] + x[:, 3] + 10.0, abs=1e-10)


def test_a_rate_is_limited_and_ends_as_a_lag():
    """It rises by 6 a second until 6 (time) is left, and the rest decays."""
    block = "{rate_limit: {of: 3, rate: 6, time: 50 ms, initial: 1.5}}"
    t, y = output(block)
    until = (3.0 - 1.5 - 0.3) / 6.0
    expected = np.where(t < until, 1.5 + 6.0 * t, 3.0 - 0.3 * np.exp(-(t - until) / 0.05))
    assert y == pytest.approx(expected, abs=1e-10)
    t, y = output("{rate_limit: {of: -3, rate: 6, falling: 2, time: 50 ms}}")
    assert y == pytest.approx(-2.0 * t, abs=1e-12)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    "options", [{}, {"integrator": "rk4", "tolerance": None, "step": 0.003}], ids=["error", "fixed"]
)
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_delay_is_what_was_there_so_many_periods_ago(formulation, options):
    """Of the place 0.1 + 0.5 t. A sample at an instant has the value from before it."""
    block = "{delay: {of: rail.displacement, time: 60 ms, period: 20 ms, initial: 0.7 m}}"
    t, y = output(block, formulation, output_step=0.03, **{"tolerance": 1e-8, "duration": 0.15, **options})
    last = np.ceil(t / 0.02 - 1e-9) - 1.0  # the instant before
    expected = np.where(last < 3, 0.7, 0.1 + 0.5 * 0.02 * (last - 3))
    assert y == pytest.approx(expected, abs=1e-13)


LQR = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3 s, output_step: 0.5 s, tolerance: 1e-9, integrator: dop853}
bodies:
  cart: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  pole: {mass: 0.2 kg, inertia: [0.006, 0.006, 0.0001], position: [0, 0, 0.3]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
  pin: {type: revolute, bodies: [cart, pole], location: [0, 0, 0], axis: [0, 1, 0]START}
LOOP
"""
OUTPUTS = ["rail.displacement", "pin.angle", "rail.displacement_speed", "pin.angle_speed"]
CLOSED = """
signals:
  u: {gain: {of: [rail.displacement, pin.angle, rail.displacement_dot, pin.angle_dot], file: lqr.csv}, unit: N}
forces:
  drive: {type: linear_spring_damper, joint: rail, force: -u}
"""


def plant(tmp_path):
    """The linear model of a cart with a pole that stands."""
    return linearize(read_scene_text(LQR.replace("LOOP", "").replace("START", "")), ["rail.displacement"], OUTPUTS)


def test_a_gain_from_a_linear_model_closes_the_loop_as_it_was_designed(tmp_path):
    from scipy.linalg import solve_continuous_are

    model = plant(tmp_path)
    A, B, C, _ = model.matrices
    S = solve_continuous_are(A, B, C.T @ np.diag([10.0, 10.0, 1.0, 1.0]) @ C, np.eye(1))
    K = B.T @ S
    np.savetxt(tmp_path / "lqr.csv", K @ np.linalg.inv(C), delimiter=",", fmt="%.17g")
    path = tmp_path / "closed.yaml"
    path.write_text(LQR.replace("LOOP", CLOSED).replace("START", ", angle: 0.2"))
    scene = read_scene(path)
    upright = read_scene(path, {"joints.pin.angle": "0"})
    closed = linearize(upright, ["rail.displacement"], OUTPUTS)
    found, designed = (np.sort_complex(np.linalg.eigvals(each)) for each in (closed.A, A - B @ K))
    assert found == pytest.approx(designed, rel=1e-9)
    assert designed.real.max() < -0.5
    # What was run has the numbers in it.
    (tmp_path / "lqr.csv").unlink()
    again = read_scene_text(scene.text, "again", scene.overrides)
    assert again.signals == scene.signals
    assert ran(scene.text, scene.overrides)[1]["joints/coordinate"][-1] == pytest.approx([0.0, 0.0], abs=0.05)


def test_a_model_in_a_file_is_a_block(tmp_path):
    path = tmp_path / "scene.yaml"
    spring = "forces:\n  spring: {type: linear_spring_damper, joint: rail, stiffness: 8, damping: 1}"
    path.write_text(LQR.replace("LOOP", spring).replace("START", ", angle: 0"))
    arguments = ["--inputs", "rail.displacement", "--outputs", "rail.displacement,pin.angle"]
    succeeds("linearize", "scene.yaml", *arguments, "-o", "model.h5", folder=tmp_path)
    other = tmp_path / "other.yaml"
    other.write_text(SCENE.replace("BLOCK", "{state_space: {of: 1, file: model.h5, outputs: [x, angle]}}"))
    model = linearize(read_scene(path), ["rail.displacement"], ["rail.displacement", "pin.angle"])
    own = read_scene(other)
    assert [state.name for state in own.states] == [f"y.x{at}" for at in range(1, 5)]
    _, found, _ = ran(own.text, own.overrides)
    _, y = signal.step(signal.StateSpace(*model.matrices), T=found["time"])
    assert found["signals/value"] == pytest.approx(y, rel=1e-9, abs=1e-12)


def test_equilibrium_and_modes_know_the_states_of_blocks():
    text = SCENE.replace("BLOCK", "{transfer_function: {of: rail.displacement, num: [6], den: [0.1, 3]}}").replace(
        "signals:", "forces: {k: {type: linear_spring_damper, joint: rail, force: 8 - 2*y}}\nsignals:"
    )
    found = equilibrium(read_scene_text(text))
    assert found.coordinates["rail.displacement"] == pytest.approx(2.0, abs=1e-9)
    A = np.array([[0, 1, 0], [0, 0, -1], [60, 0, -30]])
    eigenvalues = modes(read_scene_text(text), at="equilibrium").eigenvalues
    expected = np.linalg.eigvals(A)
    assert np.sort_complex(eigenvalues) == pytest.approx(np.sort_complex(expected[expected.imag >= 0]), rel=1e-9)
    late = text.replace("signals:", "signals:\n  late: {delay: {of: y, time: 1 ms, period: 1 ms}}")
    with pytest.raises(InputError, match="'late' acts at instants"):
        modes(read_scene_text(late))


WRONG = {
    "degree": ("{transfer_function: {of: 1, num: [1, 0, 0], den: [1, 1]}}", "it would differentiate"),
    "zero": ("{transfer_function: {of: 1, num: [1], den: [0, 1]}}", "begins with 0"),
    "initial": ("{transfer_function: {of: 1, num: [1], den: [1, 1], initial: [1, 2]}}", "it has 1 states"),
    "high": (f"{{transfer_function: {{of: 1, num: [1], den: {[1] * 12}}}}}", "has the degree 11"),
    "shape": ("{state_space: {of: 1, A: [[1, 2]], B: [[1]], C: [[1]]}}", "2 numbers in row 1 of 'A'"),
    "rows": ("{state_space: {of: 1, A: [[1]], B: [[1], [2]], C: [[1]]}}", "2 rows in 'B'"),
    "no matrix": ("{state_space: {of: 1, A: [[1]]}}", "lacks A, B or C"),
    "inputs": ("{gain: {of: [1, 2], rows: [[1, 2, 3]]}}", "3 numbers in row 1 of 'rows'"),
    "names": ("{gain: {of: 1, rows: [[1], [2]], outputs: [a]}}", "1 names of outputs"),
    "one name": ("{gain: {of: 1, rows: [[1], [2]], outputs: [a, a]}}", "two outputs of one name"),
    "periods": ("{delay: {of: 1, time: 5 ms, period: 2 ms}}", "2.5 periods"),
    "many": ("{delay: {of: 1, time: 5 s, period: 1 ms}}", "5000 values"),
    "two": ("{delay: {of: 1, time: 5 s, period: 1 s}, value: 3}", "cannot both be given"),
    "none": ("{unit: V}", "missing key"),
    "a key": ("{filter: {of: 1, time: 1, ordr: 2}}", "did you mean 'order'"),
    "a name": ("{filter: {of: rail.displacment, time: 1}}", "did you mean 'rail.displacement'"),
    "a part": ("{gain: {of: 1, rows: [[1], [2]]}}\n  z: 2*y.y3", "unknown name 'y.y3'"),
    "itself": ("{gain: {of: y, rows: [[1]]}}", "depends on itself: y -> y"),
    "units": ("{filter: {of: 1 V + 2 m, time: 1}}", "cannot be added"),
    "start": ("{filter: {of: 1 V, time: 1, initial: 1 m}}", "has an input that is a voltage"),
    "a file": ("{gain: {of: 1, file: k.csv}}", "needs a scene that is a file itself"),
    "both": ("{gain: {of: 1, file: k.csv, rows: [[1]]}}", "cannot both be given"),
    "more": ("{state_space: {of: 1, file: k.h5, B: [[1]]}}", "has a 'file' and 'B'"),
}


@pytest.mark.parametrize("case", WRONG)
def test_mistakes_are_told_at_their_line(case):
    block, message = WRONG[case]
    with pytest.raises(InputError) as caught:
        compile_system(read_scene_text(SCENE.replace("BLOCK", block)))
    assert message in str(caught.value), str(caught.value)
    assert len(caught.value.problems) == 1, str(caught.value)


def test_a_name_that_a_joint_has_is_taken():
    text = SCENE.replace("y: BLOCK", "rail: {filter: {of: 1, time: 1}}")
    with pytest.raises(InputError, match="name of one of the joints"):
        read_scene_text(text)


FILES = {
    "none": (None, "is not there"),
    "outside": ("../k.csv", "is not there"),
    "words": ("1, a", "is no table of numbers"),
    "underscores": ("1, 8_9", "is no table of numbers"),
    "empty": ("# nothing", "has no numbers"),
    "no model": ("1, 2", "is no linear model"),
    "ragged": ("1, 2\n3", "1 numbers in row 2"),
}


@pytest.mark.parametrize("case", FILES)
def test_files_that_cannot_be_read_are_told(case, tmp_path):
    content, message = FILES[case]
    path = tmp_path / "scene.yaml"
    block = "{state_space: {of: 1, file: k.csv}}" if case == "no model" else "{gain: {of: [1, 2], file: k.csv}}"
    path.write_text(SCENE.replace("BLOCK", block.replace("k.csv", "../k.csv") if case == "outside" else block))
    if content and case != "outside":
        (tmp_path / "k.csv").write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        read_scene(path)
    assert len(caught.value.problems) == 1
