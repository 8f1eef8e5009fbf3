"""Linear models against closed forms and against runs of small amplitude; forces without a linear part."""

from __future__ import annotations

import json
from dataclasses import replace
from math import sqrt

import h5py
import numpy as np
import pytest
from scipy.io import loadmat
from scipy.linalg import expm
from scipy.signal import StateSpace, freqresp

from mbproj import Mechanism
from mbproj.base.errors import InputError
from mbproj.base.mechanisms_folder import mechanism
from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space import linear_model
from mbproj.motion.simulate import simulate
from mbproj.results.linear_files import read_model
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.scene.settings import settings_to_run
from mbproj.studies.verify import short_runs
from mbproj.studies.verify.case import Case, Finding
from mbproj.studies.verify.checks import CHECKS, _check
from tests.cli.commands import mbproj
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.linear.closed_forms import LAVAL, g, modes_of, under_gravity, weightless
from tests.support import Recorder

MASS = under_gravity("""\
bodies:
  m: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  j: {type: prismatic, bodies: [ground, m], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  s: {type: linear_spring_damper, joint: j, stiffness: 50, damping: 3}
  push: {type: force, body: m, force: [0, 0, 0]}
markers:
  tip: {body: m, location: [0.5, 0, 0]}
""")


def model_of(text, inputs, outputs):
    scene = read_scene_text(text)
    system = compile_system(scene)
    return linear_model(reference_at(system, assembled_start(scene, system), "start"), inputs, outputs)


def test_a_mass_on_a_spring():
    """x / F = 1 / (m s² + c s + k), whichever way the force comes; the reaction carries no force along the slide."""
    inputs, outputs = ["j.displacement", "s", "push.x", "push.y"], ["tip.x", "j.displacement_speed", "j.force_y"]
    model = model_of(MASS, inputs, outputs)
    frequency, found = freqresp(
        StateSpace(*model.matrices[:1], *(m[..., :1] for m in (model.B,)), model.C[:1], model.D[:1, :1])
    )
    s = 1j * frequency
    np.testing.assert_allclose(found, 1 / (2 * s**2 + 3 * s + 50), rtol=1e-9)
    np.testing.assert_allclose(model.B[:, 0], model.B[:, 1], atol=1e-15)
    np.testing.assert_allclose(model.B[:, 0], model.B[:, 2], atol=1e-15)
    np.testing.assert_allclose(model.D, [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, -1]], atol=1e-14)
    assert (model.input_units, model.output_units) == (("N",) * 4, ("m", "m/s", "N"))


CART = under_gravity("""\
bodies:
  cart: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  bob: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, -0.5]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}
  pin: {type: revolute, bodies: [cart, bob], location: [0, 0, 0], axis: [0, 1, 0]}
motions:
  shake: {joint: rail, displacement: 0}
markers:
  tip: {body: bob, location: [0, 0, -1]}
""")


def test_the_second_derivative_of_a_motion_is_the_input():
    """A pendulum whose pivot is shaken: I θ'' + m g d θ = m d w'', with the sign of the pin's axis, and the force that
    shakes it is on no output but the rail's own."""
    model = model_of(CART, ["shake"], ["pin.angle", "rail.displacement", "tip.x"])
    inertia = 0.1 + 2 * 0.25
    s = 1j * np.array([0.3, 2.0, 9.0])
    found = np.array([model.C @ np.linalg.solve(x * np.eye(4) - model.A, model.B) + model.D for x in s])[:, :, 0]
    swing = 2 * 0.5 / (inertia * s**2 + 2 * g * 0.5)
    np.testing.assert_allclose(found[:, 0], swing, rtol=1e-10)
    np.testing.assert_allclose(found[:, 1], 1 / s**2, rtol=1e-10)
    np.testing.assert_allclose(found[:, 2], 1 / s**2 - swing, rtol=1e-10)
    assert (model.states[1], model.state_units[1], model.input_units) == ("shake", "m", ("m/s^2",))


def test_its_eigenvalues_are_the_modes():
    scene = read_scene_text(MASS)
    system = compile_system(scene)
    reference = reference_at(system, assembled_start(scene, system), "start")
    model = linear_model(reference, ["s"], ["tip.x"])
    own = np.linalg.eigvals(model.A)
    np.testing.assert_allclose(own[own.imag > 0], modes(reference).eigenvalues, rtol=1e-12)


TWO = under_gravity("""\
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
  b: {mass: 2, inertia: [0.2, 0.2, 0.2], position: [1, 0, -0.5]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: spherical, bodies: [a, b], location: [1, 0, 0]}
forces:
  spring: {type: torsion_spring_damper, joint: A, stiffness: 60, damping: 2}
  push: {type: force, body: b, location: {b: [0, 0, -0.3]}, force: [SIZE, 0.5*SIZE, 0]}
markers:
  tip: {body: b, location: [1, 0, -1]}
""")


def test_a_small_step_of_a_force_moves_it_as_the_model_says():
    """Markers and reactions of a run from the equilibrium, against the model's step response."""
    size, end = 1e-5, 0.4
    scene = read_scene_text(TWO.replace("SIZE", "0"))
    system = compile_system(scene)
    rest = equilibrium(system, assembled_start(scene, system))
    outputs = ["tip.x", "tip.y", "tip.z", "A.angle", "A.force_x", "A.force_z", "A.torque_x", "B.force_y"]
    model = linear_model(rest.reference, ["push.x", "push.y"], outputs)
    u = np.array([1.0, 0.5])
    n = len(model.A)
    grown = expm(end * np.block([[model.A, (model.B @ u)[:, None]], [np.zeros((1, n + 1))]]))[:n, n]
    expected = model.C @ grown + model.D @ u

    def run(force):
        pushed = read_scene_text(TWO.replace("SIZE", repr(force)))
        settings = replace(settings_to_run(pushed), duration=end, step=1e-3, output_step=end)
        kept = Recorder()
        simulate(compile_system(pushed), replace(rest.state, t=0.0), settings, kept)
        reaction, torque = kept["joints/reaction_force"][-1], kept["joints/reaction_torque"][-1]
        tip = kept["markers/position"][-1, 0]
        return np.array([*tip, kept["joints/coordinate"][-1, 0], *reaction[0, [0, 2]], torque[0, 0], reaction[1, 1]])

    found = (run(size) - run(-size)) / (2 * size)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


LIGHT = under_gravity("""\
bodies:
  plate: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 0]}
  block: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  p: {type: prismatic, bodies: [ground, plate], location: [0, 0, 0], axis: [1, 0, 0]}
  b: {type: prismatic, bodies: [plate, block], location: [1, 0, 0], axis: [1, 0, 0]}
forces:
  first: {type: linear_spring_damper, joint: p, stiffness: 30DAMPED}
  second: {type: linear_spring_damper, joint: b, stiffness: 60}
  push: {type: force, body: plate, force: [0, 0, 0]}
""")


def test_what_moves_no_mass_follows_the_others_and_the_inputs_at_once():
    """A block of mass m on two springs one after the other, with a force F on the plate between them: with x of the
    block and z of the plate, z = (k2 x + F) / (k1 + k2) and m x'' = k2 (z - x); b.displacement is x - z."""
    model = model_of(LIGHT.replace("DAMPED", ""), ["push.x"], ["p.displacement", "b.displacement"])
    assert model.A.shape == (2, 2)
    k1, k2, m = 30.0, 60.0, 2.0
    s = 1j * np.array([0.3, 2.0, 9.0])
    found = np.array([model.C @ np.linalg.solve(i * np.eye(2) - model.A, model.B) + model.D for i in s])[..., 0]
    x = k2 / (k1 + k2) / (m * s**2 + k1 * k2 / (k1 + k2))
    z = (k2 * x + 1) / (k1 + k2)
    np.testing.assert_allclose(found, np.array([z, x - z]).T, rtol=1e-12)


def test_the_rate_of_what_follows_an_input_at_once_is_refused():
    with pytest.raises(InputError, match=r"'p\.displacement_speed' has the rate of an input, as nothing between"):
        model_of(LIGHT.replace("DAMPED", ""), ["push.x"], ["p.displacement_speed"])
    model = model_of(LIGHT.replace("DAMPED", ""), ["b.displacement"], ["b.displacement"])
    static = model.D - model.C @ np.linalg.solve(model.A, model.B)
    np.testing.assert_allclose(static, 1.0 / 60.0, rtol=1e-12)


def test_damped_motions_without_mass_are_refused():
    with pytest.raises(InputError, match="a motion moves no mass and is damped"):
        model_of(LIGHT.replace("DAMPED", ", damping: 2"), ["push.x"], ["p.displacement"])


def test_names_that_there_are_not_are_refused():
    with pytest.raises(InputError, match=r"--inputs: error: unknown input 'push\.w'; did you mean 'push\.[xyz]'"):
        model_of(MASS, ["push.w"], ["tip.x"])
    with pytest.raises(InputError, match=r"--outputs: error: unknown output 'tip'"):
        model_of(MASS, ["s"], ["tip"])


def test_what_moves_has_no_model_that_stays():
    turning = CART.replace("displacement: 0}", "displacement: 0.1*t}").replace("mass: 2", "mass: 1")
    swinging = turning.replace("axis: [0, 1, 0]}\nmotions", "axis: [0, 1, 0], speed: 2 rad/s}\nmotions")
    with pytest.raises(InputError, match="the mechanism moves here, so that its linear model changes with time"):
        model_of(swinging, ["shake"], ["pin.angle"])
    assert model_of(LAVAL, ["up"], []).A.shape == (12, 12)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.yaml").write_text(MASS)
    return tmp_path


def test_the_files_hold_the_same_model(folder):
    asked = ["linearize", "scene.yaml", "--inputs", "s,push.y", "--outputs", "tip.x,j.force_y"]
    found = json.loads(mbproj(*asked, "--json", folder=folder).stdout)
    for name in ("a.npz", "a.mat"):
        assert mbproj(*asked, "-q", "-o", name, folder=folder).returncode == 0
        assert mbproj(*asked, "-q", "-o", name, folder=folder).returncode == 0, "its own file is replaced"
    stored, numpy, matlab = read_model(folder / "linear.h5"), np.load(folder / "a.npz"), loadmat(folder / "a.mat")
    for letter in "ABCD":
        for other in (getattr(stored, letter), numpy[letter], matlab[letter]):
            np.testing.assert_array_equal(other, found[letter])
    assert tuple(stored.outputs) == ("tip.x", "j.force_y") == tuple(numpy["outputs"])
    assert [text.strip() for text in matlab["input_units"]] == ["N", "N"]
    with h5py.File(folder / "linear.h5") as file:
        assert file.attrs["format"] == "mbproj linear model"
    assert mbproj("plot", "linear.h5", folder=folder).stdout.split() == ["linear-bode.png"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "a.txt"], "--output: error: 'a.txt' has no ending of a linear model; end it in .h5, .npz, .mat"),
        (["-o", "note.npz"], "'note.npz' exists and is not an .npz file of mbproj, so it is not replaced"),
    ],
)
def test_where_it_cannot_be_written_is_said(folder, arguments, said):
    (folder / "note.npz").write_text("mine")
    done = mbproj("linearize", "scene.yaml", "--inputs", "s", "--outputs", "tip.x", *arguments, folder=folder)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr


# Runs of small amplitude follow the modes, on shipped mechanisms; a model that is wrong is found out.

RINGING = (
    "bennett",
    "bricard",
    "delta_robot",
    "double_pendulum",
    "five_bar",
    "locomotive",
    "massless_coupler",
    "physical_pendulum",
    "planar_four_bar",
    "spatial_four_bar",
)


def checked(name):
    return short_runs.small_motions(Case(Mechanism.of(read_scene(mechanism(name)))))


@pytest.mark.parametrize("name", [name if number % 4 == 0 else full(name) for number, name in enumerate(RINGING)])
def test_a_run_beside_the_equilibrium_follows_the_mode_that_it_begins_in(name):
    found = checked(name)
    assert isinstance(found, Finding), found
    assert found.measured < 1e-6


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("hooke_shaft", "no mode oscillates"),
        ("free_body", "there are no joint coordinates to compare"),
        full("stewart_platform", "there is nothing to linearise: there is no equilibrium"),
        ("inline_four", "there is nothing to linearise"),
    ],
)
def test_it_says_where_it_does_not_apply(name, why):
    assert why in checked(name)


CAM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, output_step: 0.1, tolerance: 1.0e-8}
bodies:
  wheel: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
  follower: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0.3]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [1, 0, 0], axis: [0, 1, 0], speed: 60 rpm}
  slide: {type: prismatic, bodies: [ground, follower], location: [1, 0, 0.3], axis: [0, 0, 1]}
  cam: {type: coupler, of: {pin: 0, slide: 1}, function: {rows: [ROWS], between: periodic}}
"""
KNOT = "[0 deg, 0 mm], [90 deg, 12 mm], [180 deg, 20 mm], [270 deg, 12 mm], [360 deg, 0 mm]"
BETWEEN = "[-45 deg, 3 mm], [45 deg, 3 mm], [180 deg, 20 mm], [315 deg, 3 mm]"


@needs_kernel
@pytest.mark.parametrize(("rows", "rests"), [(KNOT, True), full(BETWEEN, False)], ids=["knot", "between"])
def test_a_cam_that_rests_at_a_knot_has_no_motion_that_is_linear_on_both_sides(rows, rests):
    """The third derivative of its lift jumps there. Order and energy are told from motions that pass no knot."""
    case = Case(Mechanism.of(read_scene_text(CAM.replace("ROWS", rows))))
    found = {name: _check(name, CHECKS[name], case) for name in ("linear", "order", "energy")}
    assert (
        found["linear"].remark.startswith(
            "it rests at the edge of a law, and moves differently on its two sides: joint 'cam'"
        )
        == rests
    )
    assert found["linear"].verdict == ("does not apply" if rests else "passed")
    assert "failed" not in {each.verdict for each in found.values()}


def test_a_frequency_that_is_wrong_is_found_out(monkeypatch):
    """By a part in 10 000."""

    def wrong(reference):
        found = modes(reference)
        return replace(found, eigenvalues=found.eigenvalues * 1.0001)

    monkeypatch.setattr(short_runs, "modes", wrong)
    found = checked("physical_pendulum")
    assert not found.passed
    assert found.measured == pytest.approx(1e-4 * 3.14159 / 2, rel=0.1)


# Forces without a linear part at a pose are refused by name; beside it they are linear.


def test_a_force_without_a_slope_is_refused_by_name():
    text = LAVAL.replace("stiffness: 1000, free_length: 0}\n  down", "force: -sqrt(l - 0.3)}\n  down")
    with pytest.raises(InputError, match="force 'up' has no slope at this pose"):
        modes_of(text)


BUFFER = weightless("""\
bodies:
  cart: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: AT}
forces:
  spring: {type: linear_spring_damper, joint: rail, stiffness: 50}
  stop: {type: linear_spring_damper, joint: rail, force: FORCE}
""")


@pytest.mark.parametrize(
    ("force", "said"),
    [
        ("-300 * max(0, displacement - 0.2)", "has a kink, the slope 0 before and -300 after it,"),
        (
            "-300 * max(0, displacement - 0.2) * exp(displacement_dot)",
            "has a kink, the slope 0 before and -300 after it,",
        ),
        ("-7 * sign(displacement_dot)", "jumps from 7 to -7"),
        ("-7 * abs(displacement - 0.2)", "has a kink, the slope 7 before and -7 after it,"),
        ("-7 * abs(displacement_dot)", "has a kink, the slope 7 before and -7 after it,"),
    ],
)
def test_a_force_with_a_kink_at_the_pose_is_refused_by_name(force, said):
    text = BUFFER.replace("FORCE", f'"{force}"')
    with pytest.raises(InputError, match=f"force 'stop' {said} at this pose: it has no linear part"):
        modes_of(text.replace("AT", "0.2"))
    modes_of(text.replace("AT", "0.2001").replace("_dot", "_dot + 0.01"))  # beside it


@pytest.mark.parametrize(
    ("force", "stiffness"),
    [
        ("-300 * max(0, displacement - 0.2)", 350.0),
        ("-7 * (displacement - 0.3) ** 3", 50.0),
        ("-2 * displacement_dot * abs(displacement_dot)", 50.0),
    ],
)
def test_where_it_is_smooth_it_is_linear(force, stiffness):
    text = BUFFER.replace("AT", "0.3").replace("FORCE", f'"{force}"')
    assert abs(modes_of(text).eigenvalues[0]) == pytest.approx(sqrt(stiffness / 2), rel=1e-9)
