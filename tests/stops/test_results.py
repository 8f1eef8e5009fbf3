"""What results, expectations and commands say of stops."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest

from mbproj import compile_system, read_scene_text
from mbproj.results.reader import open_results
from mbproj.scene.blocks.stops import stop_units
from mbproj.show.figures.kinds import draw
from tests.cli.commands import mbproj, succeeds
from tests.scene.scenes import errors
from tests.stops.scenes import SCENE as MANY

# What results of stops show: expectations, tables, pictures and the summary, of a hammer that falls on an anvil.

#: A hammer of 2 kg falls by 0.2 m on an anvil, and rests there after two bounces that count for nothing.
HAMMER = """\
mbproj: 1
title: Hammer and anvil
gravity: [0, 0, -9.81]
parameters: {speed: sqrt(2 * 9.81 * 0.2)}
simulation: {duration: 0.3 s, tolerance: 1.0e-9, integrator: dop853, output_step: 10 ms, formulation: full}
bodies:
  hammer: {mass: 2 kg, inertia: [1, 1, 1], position: [0, 0, 0.25]}
joints:
  rail: {type: prismatic, bodies: [ground, hammer], location: [0, 0, 0.25], axis: [0, 0, 1]}
forces:
  anvil:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: hammer, location: {hammer: [0, 0, -0.05]}}
    rigid: true
    restitution: 0
expect:
  falls: {stop: anvil, quantity: gap, at: 0.1 s, value: 0.2 - 9.81 / 2 * 0.01, absolute: 1.0e-12, source: free fall}
  arrives: {stop: anvil, quantity: rate, at: 0.2 s, value: -9.81 * 0.2, absolute: 1.0e-12, source: free fall}
  weighs: {stop: anvil, quantity: force, at: end, value: 2 * 9.81, absolute: 1.0e-9, source: statics}
"""
SPEED = math.sqrt(2 * 9.81 * 0.2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("hammer")
    (path / "hammer.yaml").write_text(HAMMER)
    succeeds("run", "hammer.yaml", "--quiet", "--json", folder=path)
    return path


def test_expectations_hold(folder):
    found = json.loads(mbproj("batch", "hammer.yaml", "--json", folder=folder).stdout)
    assert "falls short" not in json.dumps(found)
    worse = HAMMER.replace("value: 2 * 9.81", "value: 3 * 9.81")
    (folder / "worse.yaml").write_text(worse)
    assert mbproj("batch", "worse.yaml", folder=folder).returncode == 4


def test_info_counts_impacts(folder):
    said = mbproj("info", "results.h5", folder=folder).stdout
    assert f"1 impact of up to {2 * SPEED:.4g} N s, which took {SPEED**2:.4g} J" in said
    assert f"stop 'anvil', impact of {2 * SPEED:.6g} N s, which took {SPEED**2:.3g} J" in said
    seen = json.loads(mbproj("info", "results.h5", "--json", folder=folder).stdout)["stops"]["anvil"]
    assert (seen["impacts"], seen["unit"]) == (1, "m")
    assert (seen["largest_impulse"], seen["energy"]) == (pytest.approx(2 * SPEED), pytest.approx(SPEED**2))
    assert seen["largest_force"] == pytest.approx(2 * 9.81, rel=1e-9)
    assert seen["least_gap"] == pytest.approx(0.0, abs=1e-10)


def test_tables_of_stops_and_of_impacts(folder):
    done = mbproj("export", "results.h5", "--table", "stop-anvil", "--table", "events", folder=folder)
    assert done.stdout.split() == ["results-stop-anvil.csv", "results-events.csv"]
    with (folder / "results-stop-anvil.csv").open() as file:
        heading, *rows = csv.reader(file)
    assert heading == ["time (s)", "gap (m)", "rate (m/s)", "force (N)"]
    t, gap, rate, force = np.array(rows, dtype=float).T
    flying = t < SPEED / 9.81
    np.testing.assert_allclose(gap, np.where(flying, 0.2 - 9.81 / 2 * t**2, 0.0), atol=1e-10)
    np.testing.assert_allclose(rate, np.where(flying, -9.81 * t, 0.0), atol=1e-10)
    np.testing.assert_allclose(force, np.where(flying, 0.0, 2 * 9.81), atol=1e-9)
    with (folder / "results-events.csv").open() as file:
        heading, *rows = csv.reader(file)
    assert heading == ["time (s)", "direction", "impulse (N s or N m s)", "energy (J)"]
    time, _, impulse, energy = np.array(rows, dtype=float).T
    struck = impulse > 0.0
    np.testing.assert_allclose(time[struck], [SPEED / 9.81], rtol=1e-9)
    np.testing.assert_allclose([*impulse[struck], *energy[struck]], [2 * SPEED, SPEED**2], rtol=1e-9)


def test_the_picture_has_gap_and_force_and_a_line_at_the_impact(folder):
    with open_results(folder / "results.h5") as results:
        figure = draw("stops", [results], ["hammer"])
        gap, force = (axis for axis in figure.axes if axis.get_visible())
        assert (gap.get_ylabel(), force.get_ylabel()) == ("anvil: gap (m)", "force (N)")
        drawn = gap.lines[0].get_ydata()
        np.testing.assert_allclose(drawn, results["stops/gap"][:, 0], atol=1e-9)
        lines = [line.get_xdata()[0] for line in force.lines if len(set(line.get_xdata())) == 1]
        assert min(abs(np.array(lines) - SPEED / 9.81)) < 1e-9


# What a scene may expect of its stops.

EXPECTING = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  arm: {mass: 2 kg, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  hinge: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 0, 1],
    limits: {angle: {range: [null, 90 deg], stiffness: 100}}}
expect:
  hit: {STOP, source: statics}
"""


def expecting(given):
    return EXPECTING.replace("STOP", given)


def test_stops_have_the_names_and_units_of_the_arrays():
    scene = read_scene_text(MANY)
    names = compile_system(scene).names
    found = stop_units({joint.name: joint for joint in scene.joints}, {force.name: force for force in scene.forces})
    assert found == dict(zip(names.stops, names.stop_units, strict=True))


@pytest.mark.parametrize(
    ("quantity", "number", "value", "unit"),
    [("gap", "45 deg", 0.7853981633974483, "rad"), ("rate", "1 rad/s", 1.0, "rad/s"), ("force", "3 N*m", 3.0, "N*m")],
)
def test_an_expectation_of_a_stop(quantity, number, value, unit):
    """The scene has no forces, and its stop is there all the same."""
    given = f"stop: hinge.angle.high, quantity: {quantity}, at: end, value: {number}, relative: 0.1"
    (found,) = read_scene_text(expecting(given)).expectations
    assert (found.of, found.item, found.quantity, found.unit) == ("stop", "hinge.angle.high", quantity, unit)
    assert found.value == pytest.approx((value,), rel=1e-15)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("stop: hinge.angle.low, quantity: gap", "10:15: error: unknown stop 'hinge.angle.low'; did you mean "
         "'hinge.angle.high'?"),
        ("stop: hinge.angle.high, quantity: position",
         "10:43: error: a stop has no 'position'; it has: gap, rate, force"),
    ],
)  # fmt: skip
def test_an_expectation_of_no_stop(given, message):
    assert errors(expecting(f"{given}, at: end, value: 1, absolute: 1")) == [f"f.yaml:{message}"]


def test_a_force_that_is_a_stop_is_expected_as_a_stop():
    text = expecting("force: rope, quantity: force, at: end, value: 1, absolute: 1").replace(
        "expect:",
        "forces: {rope: {type: stop, points: {ground: [0, 0, 0], arm: [1, 0, 0]}, longest: 2, rigid: true}}\nexpect:",
    )
    (found,) = errors(text)
    assert "force 'rope' is a stop; write  stop: NAME  with the quantity gap, rate or force" in found


def test_units_of_what_is_expected_are_those_of_the_stop():
    (found,) = errors(expecting("stop: hinge.angle.high, quantity: force, at: end, value: 3 N, absolute: 1"))
    assert found == "f.yaml:10:66: error: 'force' is in N*m, this is a force, in N"


# Commands on scenes with stops.

TROLLEY = """\
mbproj: 1
title: Trolley
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  trolley: {mass: 2 kg, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, trolley], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.2,
    limits: {displacement: {range: [-1, 0.2], rigid: true}}}
forces:
  rope: {type: stop, points: {ground: [-1, 0, 0], trolley: [0, 0, 0]}, longest: 1.5, stiffness: 1e4}
"""


def test_check_says_which_stops_touch_at_the_start(tmp_path):
    path = tmp_path / "trolley.yaml"
    path.write_text(TROLLEY)
    said = mbproj("check", str(path), folder=tmp_path).stdout.splitlines()
    assert "  3 stops, touching at the start: 'rail.displacement.high'" in said
    found = json.loads(mbproj("check", str(path), "--json", folder=tmp_path).stdout)["stops_at_start"]
    assert {name: (round(entry["gap"], 12), entry["touches"], entry["unit"]) for name, entry in found.items()} == {
        "rail.displacement.low": (1.2, False, "m"),
        "rail.displacement.high": (0.0, True, "m"),
        "rope": (0.3, False, "m"),
    }


def test_check_refuses_a_start_beyond_a_stop(tmp_path):
    path = tmp_path / "trolley.yaml"
    path.write_text(TROLLEY.replace("displacement: 0.2,", "displacement: 0.9,"))
    done = mbproj("check", str(path), folder=tmp_path)
    assert done.returncode == 2
    assert "trolley.yaml:9:41: error: the start is beyond the stop 'rail.displacement.high' by 0.7 m" in done.stderr
    assert "trolley.yaml:11:81: error: the start is beyond the stop 'rope' by 0.4 m: at 1.9 m" in done.stderr


def test_check_and_run_refuse_a_motion_beyond_a_stop_alike(tmp_path):
    path = tmp_path / "trolley.yaml"
    scene = TROLLEY.replace("displacement: 0.2,", "displacement: -0.1,")
    path.write_text(f"{scene}motions: {{push: {{joint: rail, displacement: 0.5*sin(t) - 0.1}}}}\n")
    checked, ran = (mbproj(command, str(path), folder=tmp_path) for command in ("check", "run"))
    assert (checked.returncode, ran.returncode) == (2, 2)
    assert checked.stderr == ran.stderr
    assert "trolley.yaml:9:41: error: motion 'push' drives rail.displacement beyond this rigid stop" in ran.stderr
