"""Equilibria against closed forms, and `mbproj equilibrium` and what begins there."""

from __future__ import annotations

import json
import re
from math import acos, asin, atan, cos, pi, sin, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from mbproj.base.errors import InputError
from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.find import equilibrium, other_equilibria
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.modes import modes
from mbproj.results.reader import open_results
from mbproj.scene.scene import read_scene, read_scene_text
from tests.cli.commands import mbproj
from tests.linear.closed_forms import HEAD, g, turning, under_gravity, weightless
from tests.support import ROOT

# Equilibria against closed forms: where they are, whether they are stable, and what has none.

PENDULUM = under_gravity("""\
bodies:
  bar: {mass: 2, inertia: [0.1, 0.2, 0.2], position: [0.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0], angle: START}
""")


def at_rest(text, t=0.0, **parameters):
    scene = read_scene_text(text, parameters={name: repr(value) for name, value in parameters.items()})
    system = compile_system(scene)
    return equilibrium(system, assembled_start(scene, system), t)


def coordinates(found):
    names = found.reference.system.names.coordinates
    return dict(zip(names, found.reference.motion.expected.tolist(), strict=True))


@pytest.mark.parametrize("start", ["0", "-80 deg", "-89.999 deg", "200 deg", "2"])
def test_a_pendulum_comes_to_hang_from_anywhere(start):
    found = at_rest(PENDULUM.replace("START", start))
    assert sin(coordinates(found)["pin.angle"]) == pytest.approx(1.0, abs=1e-15)
    assert found.stable and not found.neutral
    assert found.reference.imbalance.relative < 1e-14
    assert found.steps < 20


def test_upright_it_rests_too_but_is_not_stable():
    found = at_rest(PENDULUM.replace("START", "-90 deg"))
    assert (found.steps, found.stable, found.unstable) == (0, False, "of pin.angle")


def test_a_mass_on_a_spring_sags_by_its_weight():
    text = under_gravity("""\
bodies:
  m: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  j: {type: prismatic, bodies: [ground, m], location: [0, 0, 0], axis: [0, 0, 1]}
forces:
  s: {type: linear_spring_damper, joint: j, stiffness: 50}
""")
    assert coordinates(at_rest(text)) == {"j.displacement": pytest.approx(-2 * g / 50, rel=1e-14)}


TRUSS = weightless("""\
parameters: {load: 0}
bodies:
  m: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.3]}
joints:
  j: {type: prismatic, bodies: [ground, m], AXES}
forces:
  left: {type: spring_damper, points: {ground: [-1, 0, 0], m: [0, 0, 0.3]}, stiffness: 1000, free_length: 1.1}
  right: {type: spring_damper, points: {ground: [1, 0, 0], m: [0, 0, 0.3]}, stiffness: 1000, free_length: 1.1}
  push: {type: force, body: m, force: [0, 0, load]}
""")


TRUSS = TRUSS.replace("AXES", "location: {ground: [0, 0, 0], m: [0, 0, 0]}, axis: {ground: [0, 0, 1], m: [0, 0, 1]}")


def test_a_truss_of_two_springs_rests_on_either_side():
    """√(1 + z²) is the free length above and below, and between the two it is not stable (von Mises)."""
    scene = read_scene_text(TRUSS)
    system = compile_system(scene)
    found = equilibrium(system, assembled_start(scene, system))
    height = sqrt(1.1**2 - 1.0)
    assert coordinates(found)["j.displacement"] == pytest.approx(height, rel=1e-12)
    (other,) = other_equilibria(system, found, 10)
    assert other.stable
    assert coordinates(other)["j.displacement"] == pytest.approx(-height, rel=1e-12)


def test_under_a_load_the_truss_snaps_through_where_its_side_has_no_equilibrium():
    def lift(z):
        return -2000.0 * (1.0 - 1.1 / sqrt(1.0 + z * z)) * z

    held = brentq(lambda z: lift(z) - 10.0, 0.3, 0.45)
    assert coordinates(at_rest(TRUSS, load=-10.0))["j.displacement"] == pytest.approx(held, rel=1e-12)
    below = brentq(lambda z: lift(z) - 100.0, -2.0, -0.46)
    assert coordinates(at_rest(TRUSS, load=-100.0))["j.displacement"] == pytest.approx(below, rel=1e-12)


def test_a_force_that_follows_its_body_has_no_energy_and_an_equilibrium_all_the_same():
    """F along the bar's end against its weight: a torque F l = m g d cos θ."""
    text = PENDULUM.replace("START", "0.1") + "forces:\n"
    text += "  push: {type: force, body: bar, location: {bar: [0.5, 0, 0]}, force: [0, 0, 5], axes: body}\n"
    found = at_rest(text)
    assert cos(coordinates(found)["pin.angle"]) == pytest.approx(5.0 / (2 * g * 0.5), rel=1e-12)
    assert found.stable


def test_neutral_directions_are_named_and_stay():
    text = under_gravity("""\
bodies:
  wheel: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  bob: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  hub: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], angle: 0.7}
  pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}
""")
    found = at_rest(text)
    assert found.neutral == ("of hub.angle",)
    assert coordinates(found) == {"hub.angle": pytest.approx(0.7, abs=1e-14), "pin.angle": pytest.approx(pi / 2)}


def test_what_falls_freely_is_refused_with_the_direction():
    text = HEAD + "bodies:\n  stone: {mass: 3, inertia: [1, 1, 1], position: [0, 0, 0]}\n"
    with pytest.raises(NoEquilibrium, match=r"nothing balances 29\.43 N .* in which 'stone' shifts along z"):
        at_rest(text)


def test_so_is_a_wheel_with_a_constant_torque():
    text = under_gravity("""\
bodies:
  wheel: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  hub: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  drive: {type: torque, body: wheel, torque: [0, 4, 0]}
""")
    with pytest.raises(
        NoEquilibrium, match=r"nothing balances 0 N and 4 N m on 'wheel' along the motion of hub\.angle"
    ):
        at_rest(text)


DRIVEN = under_gravity("""\
bodies:
  crank: {mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0]}
  bob: {mass: 1, inertia: [0.2, 0.2, 0.2], position: [1, 0, -0.5]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, bob], location: [1, 0, 0], axis: [0, 1, 0]}
motions:
  lift: {joint: A, angle: {smooth_step: {to: -2, duration: 1 s}}}
""")


def test_motions_are_held_where_they_are_at_a_time():
    found = coordinates(at_rest(DRIVEN, t=3.0))
    assert (found["A.angle"], found["B.angle"]) == (pytest.approx(-2.0), pytest.approx(2.0))


def test_a_motion_that_goes_on_is_refused():
    with pytest.raises(InputError, match=r"motion 'lift' is not constant at t = 0\.5 s: its rate is -3\.75 per s"):
        at_rest(DRIVEN, t=0.5)


@pytest.mark.parametrize("free_angle", [0.0, 0.9, 2.5, 4.5])
def test_the_slider_crank_held_by_a_spring_rings_where_it_rests_as_its_energy_says(free_angle):
    """Its one coordinate φ: V'(φ) = 0 and λ² = -V''(φ) / T, by differences of the energies of its closed poses."""
    path = ROOT / "mechanisms" / "spatial_slider_crank.yaml"
    scene = read_scene(path)
    crank = scene.joints[0].name
    text = path.read_text() + (
        f"forces:\n  hold: {{type: torsion_spring_damper, joint: {crank}, stiffness: 0.6, free_angle: {free_angle}}}\n"
    )
    found = at_rest(text)
    assert found.stable
    assert found.reference.imbalance.relative < 1e-13
    value = modes(found.reference).eigenvalues[0]
    assert value.real == 0.0
    assert value.imag == pytest.approx(_by_energy(text, crank, coordinates(found)[f"{crank}.angle"]), rel=1e-5)


def _by_energy(text, crank, angle):
    """√(V'' / m) of the crank's angle, T = ½ m φ'²."""
    from dataclasses import replace

    from mbproj.equations.energy import total_energy

    scene = read_scene_text(text)

    def energy(at, speed):
        joints = [
            replace(j, start={"angle": at}, speed={"angle": speed}) if j.name == crank else j for j in scene.joints
        ]
        there = replace(scene, joints=tuple(joints))
        system = compile_system(there)
        return total_energy(system, assembled_start(there, system))

    h = 1e-3
    V = [energy(angle + k * h, 0.0) for k in (-2, -1, 0, 1, 2)]
    stiffness = (-V[0] + 16 * V[1] - 30 * V[2] + 16 * V[3] - V[4]) / (12 * h**2)
    return sqrt(stiffness / (2 * (energy(angle, 1.0) - V[2])))


GOVERNOR = under_gravity("""\
bodies:
  shaft: {mass: 2, inertia: [0.1, 0.1, 0.05], position: [0, 0, 0]}
  left: {mass: 1, inertia: [0, 0, 0], position: [-0.15, 0, -0.2]}
  right: {mass: 1, inertia: [0, 0, 0], position: [0.15, 0, -0.2]}
joints:
  A: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, 0, 1]}
  L: {type: revolute, bodies: [shaft, left], location: [0, 0, 0], axis: [0, 1, 0]}
  R: {type: revolute, bodies: [shaft, right], location: [0, 0, 0], axis: [0, 1, 0]}
""")


@pytest.mark.parametrize("speed", [3.0, 7.0, 10.0, 20.0])
def test_a_governor_opens_with_its_speed(speed):
    """cos θ = g / (Ω² l) above √(g/l), and hangs below."""
    found = turning(GOVERNOR, speed)
    expected = acos(min(1.0, g / (speed**2 * 0.25)))
    assert coordinates(found)["R.angle"] == pytest.approx(atan(0.15 / 0.2) - expected, abs=1e-10)
    assert found.stable
    assert found.drive == pytest.approx([0.0], abs=1e-12)
    assert found.reference.motion.u.reshape(-1, 6)[2, 1] == pytest.approx(speed * 0.25 * sin(expected), abs=1e-10)


def test_a_governor_at_speed_rings_as_its_arms_say():
    """Held at its speed, each arm by itself: λ² = -Ω² sin² θ."""
    text = GOVERNOR + "motions:\n  turn: {joint: A, angle: {constant_speed: 9}}\n"
    found = modes(turning(text, 9.0).reference)
    opening = asin(sqrt(1.0 - (g / (81 * 0.25)) ** 2))
    np.testing.assert_allclose(found.eigenvalues, 1j * 9.0 * sin(opening), rtol=1e-9)
    assert not found.turns


def test_a_governor_on_a_horizontal_shaft_has_no_steady_turn():
    text = GOVERNOR.replace("gravity: [0, 0, -9.81]", "gravity: [0.1, 0, -9.81]")
    with pytest.raises(InputError, match="forces do not turn with the mechanism: after a turn by 1 rad"):
        turning(text, 9.0)


def test_what_cannot_turn_as_one_is_named():
    with pytest.raises(InputError, match=r"'L\.angle' is not an angle between the ground and a body"):
        turning(GOVERNOR, 9.0, "L.angle")
    more = "  B: {type: revolute, bodies: [ground, left], location: [-0.15, 0, 0], axis: [0, 1, 0]}\n"
    with pytest.raises(InputError, match="joint 'B' keeps the mechanism from turning as one at this speed"):
        turning(GOVERNOR + more, 9.0)
    with pytest.raises(InputError, match="motion 'turn' keeps the mechanism from turning as one at this speed"):
        turning(GOVERNOR + "motions:\n  turn: {joint: A, angle: {constant_speed: 8}}\n", 9.0)


# `mbproj equilibrium` and what begins there: the report, the file, the scene that is written, runs.

SCENE = under_gravity("""\
bodies:
  bar:                                   # a comment
    mass: 2
    inertia: [0.1, 0.2, 0.2]
    position: [0.5, 0, 0]
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0], speed: 2 rad/s}   # another
""")
FALLS = HEAD + "bodies:\n  stone: {mass: 3, inertia: [1, 1, 1], position: [0, 0, 0]}\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    (tmp_path / "falls.yaml").write_text(FALLS)
    return tmp_path


def test_json_has_stable_keys_and_the_file_one_sample(folder):
    found = json.loads(mbproj("equilibrium", "scene.yaml", "--json", folder=folder).stdout)
    assert (found["converged"], found["stable"], found["neutral"]) == (True, True, [])
    assert found["coordinates"] == {"pin.angle": pytest.approx(pi / 2, rel=1e-14)}
    assert found["reactions"]["pin"]["force"] == pytest.approx([0, 0, 2 * 9.81], abs=1e-12)
    assert found["residual"]["relative"] < 1e-14
    with open_results(folder / "equilibrium.h5") as results:
        assert results.time.tolist() == [0.0]
        np.testing.assert_allclose(results.body("bar").position[0], [0, 0, -0.5], atol=1e-15)
        assert not results.body("bar").velocity.any()


def test_the_pose_is_written_into_the_scene_and_the_run_stays_there(folder):
    done = mbproj("equilibrium", "scene.yaml", "--write", folder=folder)
    assert "scene.yaml: the joints start there now" in done.stdout
    text = (folder / "scene.yaml").read_text()
    assert "# a comment" in text and "# another" in text and "speed" not in text
    assert re.sub(r", angle: 1\.5707963267948\d+", "", text) == SCENE.replace(", speed: 2 rad/s", "")
    assert mbproj("run", "scene.yaml", "-o", "r.h5", folder=folder).returncode == 0
    with open_results(folder / "r.h5") as results:
        assert np.abs(results.coordinate("pin.angle").value - pi / 2).max() < 1e-13


@pytest.mark.parametrize("way", ["option", "scene"])
def test_a_run_begins_there(folder, way):
    if way == "scene":
        (folder / "scene.yaml").write_text(SCENE.replace("step: 1 ms}", "step: 1 ms, start: equilibrium}"))
    more = ["--start", "equilibrium"] if way == "option" else []
    assert mbproj("run", "scene.yaml", "-o", "r.h5", *more, folder=folder).returncode == 0
    assert mbproj("rerun", "r.h5", "-o", "again.h5", folder=folder).returncode == 0
    for name in ("r.h5", "again.h5"):
        with open_results(folder / name) as results:
            assert results.settings.start == "equilibrium"
            assert np.abs(results.coordinate("pin.angle").value - pi / 2).max() < 1e-13


def test_what_has_none_fails_and_says_why(folder):
    done = mbproj("equilibrium", "falls.yaml", "--json", folder=folder)
    assert done.returncode == 3
    assert json.loads(done.stdout)["converged"] is False
    assert "there is no equilibrium: nothing balances 29.43 N" in done.stderr
    done = mbproj("run", "falls.yaml", "--start", "equilibrium", folder=folder)
    assert (done.returncode, "there is no equilibrium" in done.stderr) == (3, True)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--steady", "pin.angle"], "--steady: error: 'pin.angle' is not NAME=RATE"),
        (["--steady", "pin.angl=60rpm"], "--steady: error: unknown joint coordinate 'pin.angl'; did you mean"),
        (["--steady", "pin.angle=60 m"], "--steady pin.angle: error: '--steady pin.angle' is in rad/s"),
        (["--steady", "pin.angle=60rpm"], "forces do not turn with the mechanism"),
        (["--write", "--steady", "pin.angle=60rpm"], "--write: error: a steady turn is no pose at rest"),
        (["--at", "-1"], "--at: error: '--at' must be at least 0"),
    ],
)
def test_what_is_wrong_is_said_at_its_place(folder, arguments, said):
    done = mbproj("equilibrium", "scene.yaml", *arguments, folder=folder)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr


def test_a_pose_that_joints_do_not_tell_is_not_written(folder):
    text = SCENE.replace("type: revolute", "type: spherical").replace(", axis: [0, 1, 0], speed: 2 rad/s", "")
    (folder / "ball.yaml").write_text(text)
    done = mbproj("equilibrium", "ball.yaml", "--write", folder=folder)
    assert (done.returncode, "begin runs there with 'start: equilibrium'" in done.stderr) == (2, True)
    assert (folder / "ball.yaml").read_text() == text
