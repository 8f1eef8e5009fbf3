"""Inverse dynamics: an excavator by hand, shared forces, smoothing, and `mbproj loads`."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from mbproj import InputError, compile_system, loads, run
from mbproj.scene.scene import read_scene_text
from mbproj.studies.inverse.given_motion import GivenMotion, smoothed
from tests.cli.commands import mbproj

# An excavator: boom, arm and bucket in a vertical plane, each moved by a cylinder, and its forces by hand.

MASS = np.array([1200.0, 500.0, 400.0])
MOMENT = np.array([2500.0, 400.0, 90.0])
LENGTH = np.array([5.0, 2.5, 1.2])
CENTRE = np.array([2.4, 1.1, 0.6])
GRAVITY = 9.81
#: Of each cylinder: its end on the link before, in the axes of that link from its joint, and its end on its own link.
BASE = np.array([[0.6, -0.4], [3.2, 0.7], [0.8, 0.4]])
ROD = np.array([[2.2, 0.5], [-0.6, 0.4], [-0.3, 0.25]])
#: θ(t) = mean + swing sin(2π t / 4 s + phase): angles of the joints, the first from the horizontal.
MEAN, SWING, PHASE = np.array([0.7, -1.4, -0.8]), np.array([0.25, 0.35, 0.5]), np.array([0.3, 1.1, 2.0])
RATE = 2.0 * np.pi / 4.0
NAMES = ("boom", "arm", "bucket")


def motion(t):
    """Angles of the joints and their first and second derivatives, (3, T) each."""
    phase = RATE * t + PHASE[:, None]
    return (
        MEAN[:, None] + SWING[:, None] * np.sin(phase),
        RATE * SWING[:, None] * np.cos(phase),
        -(RATE**2) * SWING[:, None] * np.sin(phase),
    )


def excavator_coordinates(t):
    """The joints' coordinates (T, 3): they count from the pose that the scene gives."""
    return (motion(t)[0] - motion(np.zeros(1))[0]).T


def direction(angle):
    """Along a link, and across it, in the plane (x, z)."""
    return np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])


def cylinder_forces(t):
    """By hand, (T, 3), positive where a cylinder pushes: the moments of inertia and weight about each joint of all that
    it carries, over how a cylinder lengthens with its angle."""
    θ, rate, bend = (np.cumsum(part, axis=0) for part in motion(t))
    relative = motion(t)[0]
    place, pushed = np.zeros((2, len(t))), np.zeros((2, len(t)))
    joints, centres, inertias = [], [], []
    for k in range(3):
        along, across = direction(θ[k])
        swung = across * bend[k] - along * rate[k] ** 2
        joints.append(place)
        centres.append(place + CENTRE[k] * along)
        inertias.append(MASS[k] * (pushed + CENTRE[k] * swung + np.array([[0.0], [GRAVITY]])))
        place, pushed = place + LENGTH[k] * along, pushed + LENGTH[k] * swung
    forces = []
    for k in range(3):
        torque = np.zeros(len(t))
        for carried in range(k, 3):
            arm = centres[carried] - joints[k]
            torque += MOMENT[carried] * bend[carried] + arm[0] * inertias[carried][1] - arm[1] * inertias[carried][0]
        along, across = direction(relative[k])
        before = np.array([LENGTH[k - 1] if k else 0.0, 0.0])
        rod = before[:, None] + ROD[k][0] * along + ROD[k][1] * across
        apart = rod - BASE[k][:, None]
        turned = ROD[k][0] * across - ROD[k][1] * along
        lengthens = np.sum(apart * turned, axis=0) / np.linalg.norm(apart, axis=0)
        forces.append(torque / lengthens)
    return np.stack(forces, axis=1)


def excavator(*, driven: bool):
    """The mechanism; `driven` by motions of its joints, else free, with the cylinders as forces of nothing."""
    θ = np.cumsum(motion(np.zeros(1))[0][:, 0])
    bodies, joints, forces, motions, place = {}, {}, {}, {}, np.zeros(2)
    before, before_place, before_angle = "ground", np.zeros(2), 0.0
    for k, name in enumerate(NAMES):
        along, across = direction(θ[k])
        bodies[name] = {
            "mass": float(MASS[k]),
            "inertia": [1.0, float(MOMENT[k]), 1.0 + float(MOMENT[k])],
            "position": _in_space(place + CENTRE[k] * along),
            "orientation": {"axis": [0, -1, 0], "angle": float(θ[k])},
        }
        joints[f"{name}_pin"] = {
            "type": "revolute",
            "bodies": [before, name],
            "location": _in_space(place),
            "axis": [0, -1, 0],
        }
        ahead, beside = direction(before_angle)
        forces[f"{name}_cylinder"] = {
            "type": "spring_damper",
            "points": {
                before: _in_space(before_place + BASE[k][0] * ahead + BASE[k][1] * beside),
                name: _in_space(place + ROD[k][0] * along + ROD[k][1] * across),
            },
            "stiffness": 0.0,
        }
        if driven:
            at, start = f"{RATE!r}*t + {float(PHASE[k])!r}", f"sin({float(PHASE[k])!r})"
            motions[f"{name}_motion"] = {
                "joint": f"{name}_pin",
                "angle": f"{float(SWING[k])!r} * (sin({at}) - {start})",
            }
        before, before_place, before_angle = name, place, float(θ[k])
        place = place + LENGTH[k] * along
    found = {
        "mbproj": 1,
        "gravity": [0, 0, -GRAVITY],
        "simulation": {"duration": 4.0, "step": 0.02},
        "bodies": bodies,
        "joints": joints,
        "forces": forces,
        "markers": {"tooth": {"body": "bucket", "location": {"bucket": [float(LENGTH[2] - CENTRE[2]), 0, 0]}}},
    }
    return found | ({"motions": motions} if driven else {})


def _in_space(place):
    return [float(place[0]), 0.0, float(place[1])]


# Inverse dynamics: an excavator by hand, shared forces, what is refused, and what smoothing does.

CYLINDERS = tuple(f"{name}_cylinder" for name in NAMES)
PINS = tuple(f"{name}_pin.angle" for name in NAMES)


@pytest.fixture(scope="module")
def dug():
    """A run of the driven excavator."""
    return run(excavator(driven=True), duration=1.0, step=0.01, output_step=0.02)


def given(t, noise=0.0):
    values = excavator_coordinates(t)
    return GivenMotion(PINS, ("rad",) * 3, t, values + noise * np.random.default_rng(4).normal(size=values.shape))


def test_the_cylinders_of_an_excavator_push_as_the_moments_by_hand_say(dug):
    found = loads(dug, actuators=CYLINDERS)
    expected = cylinder_forces(dug.time)
    np.testing.assert_allclose(found.force, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    assert found.units == ("N",) * 3
    assert found.freedom == found.rank == 3
    assert found.balance < 1e-12


def test_along_the_motions_their_own_torques_are_found_again(dug):
    found = loads(dug)
    recorded = dug["motions/force"]
    np.testing.assert_allclose(found.force, recorded, rtol=0.0, atol=1e-10 * np.abs(recorded).max())


def test_a_motion_given_by_samples_takes_the_same_forces_but_for_the_spline():
    """The error of the second derivative of a spline of degree 5 falls with h⁴."""
    errors = []
    for count in (31, 61):
        t = np.linspace(0.0, 4.0, count)
        found = loads(excavator(driven=False), given(t), actuators=CYLINDERS)
        expected = cylinder_forces(t)
        inside = slice(count // 5, -count // 5)
        errors.append(np.abs(found.force - expected)[inside].max() / np.abs(expected).max())
        assert found.balance < 1e-12
        assert all(each.noise == 0.0 and each.largest < 1e-12 for each in found.smoothing)
    assert errors[0] < 3e-4
    assert errors[0] / errors[1] > 10.0


def test_without_names_the_given_coordinates_are_the_actuators():
    t = np.linspace(0.0, 4.0, 41)
    found = loads(excavator(driven=False), given(t))
    assert found.names == PINS
    assert found.units == ("N m",) * 3


def test_the_tooth_of_the_bucket_and_one_angle_tell_the_whole_motion():
    """Markers: x and z of the tooth and the angle of the bucket's pin take the place of three angles."""
    scene, t = excavator(driven=True), np.linspace(0.0, 1.0, 51)
    results = run(scene, duration=1.0, step=0.02)
    tooth = results.marker("tooth").position
    values = np.column_stack([tooth[:, 0], tooth[:, 2], results.coordinate("bucket_pin.angle").value])
    motion = GivenMotion(("tooth.x", "tooth.z", "bucket_pin.angle"), ("m", "m", "rad"), results.time, values)
    found = loads(excavator(driven=False), motion, actuators=CYLINDERS)
    expected = cylinder_forces(t)
    inside = slice(10, -10)
    np.testing.assert_allclose(found.force[inside], expected[inside], rtol=0.0, atol=1e-5 * np.abs(expected).max())


@pytest.mark.full
def test_noise_is_smoothed_and_what_that_changes_is_said():
    """Samples with noise of 1e-4 rad: its size is found, and the forces are near those of the true motion,
    while interpolation would make accelerations of noise."""
    t = np.linspace(0.0, 4.0, 121)
    found = loads(excavator(driven=False), given(t, 1e-4), actuators=CYLINDERS)
    expected = cylinder_forces(t)
    assert [each.noise for each in found.smoothing] == pytest.approx([1e-4] * 3, rel=0.3)
    assert all(1e-4 < each.largest < 6e-4 for each in found.smoothing)
    off = np.abs(found.force - expected)[12:-12] / np.abs(expected).max(axis=0)
    assert off.max() < 0.1
    raw = loads(excavator(driven=False), given(t, 1e-4), actuators=CYLINDERS, smooth={"rad": 0.0})
    assert np.abs(raw.force - expected)[12:-12].max() > 3.0 * np.abs(found.force - expected)[12:-12].max()


def test_what_is_given_twice_is_averaged():
    """Angles and a marker that contradict each other by noise: the closed motion is between them."""
    t = np.linspace(0.0, 1.0, 26)
    results = run(excavator(driven=True), duration=1.0, step=0.02, output_step=0.04)
    tooth = results.marker("tooth").position[:, [0, 2]]
    values = np.column_stack([excavator_coordinates(t), tooth + np.array([3e-4, -3e-4])])
    names, units = (*PINS, "tooth.x", "tooth.z"), ("rad",) * 3 + ("m",) * 2
    found = loads(excavator(driven=False), GivenMotion(names, units, t, values), actuators=CYLINDERS)
    changes = {each.name: each.largest for each in found.smoothing}
    assert 0.0 < changes["tooth.x"] < 3e-4
    assert 0.0 < changes["boom_pin.angle"] < 3e-4
    assert found.balance < 1e-12


def test_of_more_actuators_than_freedoms_the_least_weighted_squares_are_taken(dug):
    """With cylinders and torques at the same joints: p = W⁻¹Bᵀ(B W⁻¹Bᵀ)⁻¹ τ, of which B is known in closed form."""
    torques, cylinders = loads(dug, actuators=PINS).force, loads(dug, actuators=CYLINDERS).force
    weights = {"boom_cylinder": 4.0}
    both = loads(dug, actuators=(*PINS, *CYLINDERS), weights=weights)
    assert both.is_shared
    lever = torques / cylinders
    w = np.array([4.0, 1.0, 1.0])
    share = torques / (1.0 + lever**2 / w)
    np.testing.assert_allclose(both.force[:, :3], share, rtol=1e-9, atol=1e-9 * np.abs(torques).max())
    np.testing.assert_allclose(both.force[:, 3:], lever * share / w, rtol=1e-9, atol=1e-9 * np.abs(cylinders).max())
    assert both.balance < 1e-12


def test_a_freedom_without_an_actuator_is_named(dug):
    with pytest.raises(InputError) as raised:
        loads(dug, actuators=CYLINDERS[:2])
    problem = raised.value.problems[0]
    assert "reach 2 of 3 degrees of freedom" in problem.message
    assert "bucket_pin.angle" in str(problem.hint)


def test_a_motion_that_leaves_a_freedom_open_is_refused():
    t = np.linspace(0.0, 4.0, 41)
    motion = GivenMotion(PINS[:2], ("rad",) * 2, t, excavator_coordinates(t)[:, :2])
    with pytest.raises(InputError, match="determines 2 of 3 degrees of freedom"):
        loads(excavator(driven=False), motion, actuators=CYLINDERS)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"actuators": ("boom_cylindre",)}, "no actuator 'boom_cylindre'"),
        ({"actuators": ("boom_motion", "boom_pin.angle")}, "two actuators act along 'boom_pin.angle'"),
        ({"weights": {"arm_motian": 2.0}}, "'arm_motian' is no actuator here"),
    ],
)
def test_names_that_are_wrong_are_said(dug, asked, said):
    with pytest.raises(InputError, match=said):
        loads(dug, **asked)


def test_a_free_motion_takes_no_force_of_an_actuator():
    """A pendulum that swings by itself, with a torque at its joint: zero."""
    results = run("mechanisms/physical_pendulum.yaml", duration=0.5)
    (name,) = results.names("coordinates")
    found = loads(results, actuators=[name])
    assert np.abs(found.force).max() < 1e-9


def test_actuators_that_are_forces_of_the_scene_replace_what_they_do():
    """A spring along a slide, whose recorded force is found again as that of an actuator."""
    text = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5, step: 1 ms, output_step: 10 ms}
bodies: {box: {mass: 2, inertia: [1, 1, 1], position: [0.3, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, box], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1}}
forces:
  spring: {type: linear_spring_damper, joint: rail, stiffness: 80, damping: 3}
  push: {type: force, body: box, force: [4, 0, 0]}
"""
    results = run(text)
    spring = loads(results, actuators=["spring"]).force[:, 0]
    np.testing.assert_allclose(spring, results.force("spring").force, rtol=0.0, atol=1e-10)
    push = loads(results, actuators=["push.x"]).force[:, 0]
    np.testing.assert_allclose(push, 4.0, rtol=1e-10)


def test_at_a_dead_centre_there_is_no_force_and_it_is_said():
    """A slider-crank moved by its crank, with the force at the piston: through the dead centre that pushes nothing."""
    text = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {duration: 1, step: 0.01}
bodies:
  crank: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.1, 0, 0]}
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
  piston: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.8, 0, 0]}
joints:
  main: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1]}
  pin: {type: revolute, bodies: [crank, rod], location: [0.2, 0, 0], axis: [0, 0, 1]}
  wrist: {type: point_on_line, bodies: [piston, rod], location: [0.8, 0, 0], axis: [0, 0, 1]}
  bore: {type: prismatic, bodies: [ground, piston], location: [0.8, 0, 0], axis: [1, 0, 0]}
motions: {drive: {joint: main, angle: {constant_speed: 1 Hz}}}
"""
    results = run(text.replace("1 Hz", "6.283185307179586 rad/s"))
    found = loads(results, actuators=["bore.displacement"])
    assert found.dead.tolist() == pytest.approx([0.0, 0.5, 1.0])
    assert np.isnan(found.force[0, 0])
    assert np.isfinite(found.force[1:50, 0]).all()


def test_dry_friction_is_refused_as_it_goes_by_reactions():
    text = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.1, step: 1 ms}
bodies: {box: {mass: 2, inertia: [1, 1, 1], position: [0.3, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, box], location: [0, 0, 0], axis: [1, 0, 0]}}
forces: {guide: {type: friction, joint: rail, coulomb: {coefficient: 0.1}}}
motions: {drive: {joint: rail, displacement: 0.1*t}}
"""
    with pytest.raises(InputError, match="dry friction 'guide"):
        loads(text)


def test_dry_friction_of_a_constant_force_acts_against_the_rate():
    """A box on a slope that goes to and fro, and rests in between: m (a + g sin β) + F sign v."""
    rise, back = ("max(0, min(1, (t - 0.2)/0.3))", "max(0, min(1, (t - 0.7)/0.3))")
    law = " - ".join(f"0.2*({x})**3*(10 - 15*{x} + 6*({x})**2)" for x in (rise, back))
    text = f"""
mbproj: 1
gravity: [-4, 0, -9]
simulation: {{duration: 1.2, output_step: 10 ms, kinematic: true}}
bodies: {{box: {{mass: 2, inertia: [1, 1, 1], position: [0.3, 0, 0]}}}}
joints: {{rail: {{type: prismatic, bodies: [ground, box], location: [0, 0, 0], axis: [1, 0, 0]}}}}
forces: {{guide: {{type: friction, joint: rail, coulomb: {{force: 3 N}}}}}}
motions: {{drive: {{joint: rail, displacement: "{law}"}}}}
"""
    found, done = loads(text), run(text)
    t = found.time
    inside = (np.abs(t - 0.35) < 0.14) | (np.abs(t - 0.85) < 0.14)
    rests = (t < 0.2) | (np.abs(t - 0.6) < 0.09) | (t > 1.01)
    x = np.where(t < 0.6, t - 0.2, t - 0.7) / 0.3
    sign = np.where(t < 0.6, 1.0, -1.0)
    bend = 0.2 * (60.0 * x - 180.0 * x**2 + 120.0 * x**3) / 0.09
    np.testing.assert_allclose(found["drive"][inside], (2.0 * (sign * bend + 4.0) + 3.0 * sign)[inside], atol=1e-10)
    np.testing.assert_allclose(found["drive"][rests], 8.0, atol=1e-10)
    np.testing.assert_allclose(found["drive"][inside], done["motions/force"][inside, 0], atol=1e-10)
    assert found.balance < 1e-12


def test_a_spline_tells_noise_from_a_smooth_motion():
    t = np.linspace(0.0, 2.0, 201)
    smooth = np.sin(3.0 * t)
    assert smoothed(t, smooth, None).noise == 0.0
    noisy = smooth + 1e-3 * np.random.default_rng(1).normal(size=len(t))
    found = smoothed(t, noisy, None)
    assert found.noise == pytest.approx(1e-3, rel=0.15)
    assert np.sqrt(np.mean(found.change**2)) == pytest.approx(found.noise, rel=0.01)


def test_a_motion_names_what_the_scene_has():
    system = compile_system(read_scene_text(excavator(driven=False), "digger"))
    assert system.names.coordinates == PINS


# `mbproj loads` on the command line: tables in, tables out, and what is refused with its place.

#: A bar that turns about a level axis: m = 2 kg, its centre 0.5 m away, J about the pin 0.3 + 2 · 0.25 kg m².
SCENE = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 1, step: 0.01}
bodies: {bar: {mass: 2, inertia: [0.1, 0.3, 0.3], position: [0.5, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0]}}
markers: {tip: {body: bar, location: {bar: [0.5, 0, 0]}}}
"""
MOTIONS = "motions: {m: {joint: A, angle: 0.5*sin(3*t)}}\n"
T = np.linspace(0.0, 1.0, 41)
ANGLE = 0.5 * np.sin(3.0 * T)
TORQUE = 0.8 * -9.0 * ANGLE + 2.0 * 9.8 * 0.5 * np.cos(ANGLE)


def write(folder, text, name="scene.yaml"):
    (folder / name).write_text(text)
    return name


def table(folder, headings, *columns):
    lines = [headings, *(",".join(f"{value:.17g}" for value in row) for row in zip(*columns, strict=True))]
    return write(folder, "\n".join(lines) + "\n", "given.csv")


def test_a_table_in_degrees_gives_a_table_a_picture_and_numbers(tmp_path):
    given = table(tmp_path, "time (s), A.angle (deg)", T, np.degrees(ANGLE))
    scene = write(tmp_path, SCENE)
    done = mbproj(
        "loads", scene, "--given", given, "-o", "a.csv", "--plot", "a.png", "--over", "A.angle", folder=tmp_path
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "1 degree of freedom, 1 actuator, 41 samples" in done.stdout
    assert "power balance" in done.stdout and "interpolated" in done.stdout
    assert (tmp_path / "a.png").stat().st_size > 10_000
    with (tmp_path / "a.csv").open() as file:
        headings, *rows = csv.reader(file)
    assert headings == ["time (s)", "A.angle force (N m)", "A.angle rate (rad/s)", "A.angle power (W)"]
    found = np.array(rows, dtype=float)
    np.testing.assert_allclose(found[5:-5, 1], TORQUE[5:-5], rtol=0.0, atol=1e-5)
    numbers = json.loads(mbproj("loads", scene, "--given", given, "--json", folder=tmp_path).stdout)
    np.testing.assert_allclose(numbers["actuators"]["A.angle"]["force"], found[:, 1], rtol=1e-12)
    assert numbers["power_balance"] < 1e-12


@pytest.mark.full
def test_a_marker_in_millimetres_and_results_tell_the_same_motion(tmp_path):
    x, z = 1000.0 * np.cos(ANGLE), 1000.0 * np.sin(ANGLE)
    given = table(tmp_path, "t;tip.position_x [mm];tip.z [mm]".replace(";", ","), T, x, z)
    scene = write(tmp_path, SCENE)
    done = mbproj("loads", scene, "--given", given, "--actuator", "A.angle", "--json", folder=tmp_path)
    found = json.loads(done.stdout)["actuators"]["A.angle"]["force"]
    np.testing.assert_allclose(found[8:-8], TORQUE[8:-8], rtol=0.0, atol=1e-3)
    assert mbproj("run", write(tmp_path, SCENE + MOTIONS, "driven.yaml"), folder=tmp_path).returncode == 0
    of_results = json.loads(mbproj("loads", "results.h5", "--json", folder=tmp_path).stdout)
    t = np.array(of_results["time"])
    exact = -7.2 * 0.5 * np.sin(3.0 * t) + 9.8 * np.cos(0.5 * np.sin(3.0 * t))
    np.testing.assert_allclose(of_results["actuators"]["m"]["force"], exact, rtol=0.0, atol=1e-10)
    as_given = mbproj("loads", scene, "--given", "results.h5", "--actuator", "A.angle", "--json", folder=tmp_path)
    np.testing.assert_allclose(json.loads(as_given.stdout)["actuators"]["A.angle"]["force"], exact, atol=2e-4)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time, A.angel\n" + "0,0\n" * 7, "given.csv:1: error: column 'A.angel' is no joint coordinate"),
        ("time, A.angle (mm)\n" + "0,0\n" * 7, "given.csv:1: error: column 'A.angle' is in rad, and 'mm' is not"),
        ("time, A.angle (furlong)\n" + "0,0\n" * 7, "unknown unit 'furlong'"),
        ("A.angle\n" + "0\n" * 7, "it needs a column 'time (s)'"),
        ("time, A.angle\n0,0\n1,x\n", "given.csv:3: error: 'x' is not a number"),
        ("time, A.angle\n0,0\n1,4_5\n", "given.csv:3: error: '4_5' is not a number"),
        ("time, A.angle, A.angle\n" + "0,0,0\n" * 7, "given.csv:1: error: two columns are of 'A.angle'"),
        ("time, A.angle\n0,0\n1\n", "given.csv:3: error: it has 1 cells"),
        ("time, A.angle\n0,0\n1,nan\n", "given.csv:3: error: a number is not finite"),
        ("time, A.angle\n0,0\n1,1\n2,2\n", "it has 3 samples"),
        ("time, A.angle\n" + "".join(f"{t},0\n" for t in (0, 1, 2, 2, 3, 4, 5)), "given.csv:5: error: its time"),
        ("", "it is empty"),
    ],
)
def test_what_is_wrong_with_a_table_is_said_with_its_line(tmp_path, text, said):
    scene, given = write(tmp_path, SCENE), write(tmp_path, text, "given.csv")
    done = mbproj("loads", scene, "--given", given, folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "it is not said which actuators move the mechanism"),
        (("--smooth", "1 mm"), "--smooth is for a motion that is given"),
        (("--actuator", "B.angle"), "--actuator: error: there is no actuator 'B.angle'"),
        (("--actuator", "A.angle", "--weight", "A.angle"), "'A.angle' is not NAME=VALUE"),
        (("--actuator", "A.angle", "--over", "A.angel"), "did you mean 'A.angle'?"),
        (("--actuator", "A.angle", "--plot", "a.gif"), "has no ending of a picture"),
    ],
)
def test_options_that_are_wrong_are_said(tmp_path, options, said):
    done = mbproj("loads", write(tmp_path, SCENE), *options, folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr, done.stderr
