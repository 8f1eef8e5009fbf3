"""What results, expectations and commands say of dry friction, against closed forms."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from mbproj import InputError, compile_system, read_scene_text
from mbproj.results.analysis.contacts import friction_records, sticking
from mbproj.results.analysis.expectations import series
from mbproj.results.reader import open_results
from mbproj.scene.blocks.friction import friction_units
from mbproj.scene.blocks.observables import OBSERVABLES
from mbproj.show.figures.kinds import draw
from tests.cli.commands import mbproj, succeeds
from tests.friction.scenes import AGAIN, BELT, HOLDS, SLID, SLIDES, SLIPS, STICKS
from tests.friction.scenes import EVERY_FRICTION as MANY
from tests.scene.scenes import errors

# What results say of dry friction, of a block that sticks and slips on a belt: held against the closed form.

#: Two slides and a bit of the third sticking.
END = 3.5
HELD = SLIPS - STICKS + END - AGAIN
LOST = SLIDES * sum(SLID)


@pytest.fixture(scope="module")
def belt_results(tmp_path_factory):
    path = tmp_path_factory.mktemp("belt")
    (path / "belt.yaml").write_text(BELT)
    done = succeeds("run", "belt.yaml", "--json", folder=path)
    (path / "said.json").write_text(done.stdout)
    return path


@pytest.fixture
def results(belt_results):
    with open_results(belt_results / "results.h5") as opened:
        yield opened


def test_a_friction_by_name(results):
    assert results.names("frictions") == ("grip",) and results.names("friction_units") == ("m",)
    grip = results.friction("grip")
    slides = results.time < STICKS
    np.testing.assert_allclose(grip.force[slides], SLIDES, rtol=1e-15)
    assert set(grip.state[slides]) == {-1.0} and grip.rate[0] == pytest.approx(-0.2)
    assert grip.dissipation[-1] == pytest.approx(LOST, rel=1e-9)
    with pytest.raises(InputError, match=r"no dry friction 'grib'.*did you mean 'grip'"):
        results.friction("grib")


def test_when_it_sticks(results):
    """Between samples as the events say, and no longer than what is selected."""
    np.testing.assert_allclose(sticking(results, "grip"), [(STICKS, SLIPS), (AGAIN, END)], rtol=1e-9)
    part = results.select(start=1.0, stop=3.0)
    np.testing.assert_allclose(sticking(part, "grip"), [(1.0, SLIPS), (AGAIN, 3.0)], rtol=1e-9)
    (seen,) = friction_records(part).values()
    assert (seen["sticks"], seen["slips"]) == (1, 1)
    assert seen["energy"] == pytest.approx(SLIDES * SLID[1], rel=1e-9)


def test_summaries_count(belt_results):
    counted = [json.loads((belt_results / "said.json").read_text())["frictions"]]
    counted += [json.loads(mbproj("info", "results.h5", "--json", folder=belt_results).stdout)["frictions"]]
    for found in counted:
        grip = found["grip"]
        assert [grip[name] for name in ("unit", "sticks", "slips", "turns")] == ["m", 2, 1, 0]
        assert grip["sticking_seconds"] == pytest.approx(HELD, rel=1e-9)
        assert grip["sticking_part"] == pytest.approx(HELD / END, rel=1e-9)
        assert grip["energy"] == pytest.approx(LOST, rel=1e-9)
        assert HOLDS - 0.2 * 10 * 0.02 < grip["largest_force"] < HOLDS  # the spring's in the last sample before
    said = mbproj("info", "results.h5", folder=belt_results).stdout
    assert f"grip  began to stick 2 times, slipped once, stuck for {HELD:.4g} s ({100 * HELD / END:.3g} %)" in said
    assert f"t = {SLIPS:.9g} s: friction 'grip', slip, falling" in said


def test_expectations_of_friction(belt_results):
    found = json.loads((belt_results / "said.json").read_text())["expectations"]
    assert [(each["name"], each["holds"]) for each in found] == [("slides", True), ("rests", True), ("rubs", True)]


def test_a_table_of_friction(belt_results):
    done = mbproj("export", "results.h5", "--table", "friction-grip", folder=belt_results)
    assert done.stdout.split() == ["results-friction-grip.csv"]
    with (belt_results / "results-friction-grip.csv").open() as file:
        heading, *rows = csv.reader(file)
    assert heading == ["time (s)", "rate (m/s)", "force (N)", "state (1)", "dissipation (J)"]
    t, rate, force, state, lost = np.array(rows, dtype=float).T
    held = ((t > STICKS) & (t < SLIPS)) | (t > AGAIN)
    assert set(state[held]) == {0.0} and set(state[~held]) == {-1.0}
    np.testing.assert_allclose(rate[held], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.diff(force[held & (t < SLIPS)]), 10.0 * 0.2 * 0.02, rtol=1e-6)
    assert (np.diff(lost) >= 0.0).all()


def test_the_picture_shades_what_sticks(results):
    figure = draw("friction", [results], ["belt"])
    rate, force, energy, power = (axis for axis in figure.axes if axis.get_visible())
    labels = [axis.get_ylabel() for axis in (rate, force, energy, power)]
    said = "grip: rate (m/s), force (N), energy lost (J), power lost (W)"
    assert ", ".join(label.replace("\n", " ") for label in labels) == said
    for axis in (rate, force, energy, power):
        (shade,) = axis.collections
        spans = [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in shade.get_paths()]
        np.testing.assert_allclose(spans, [(STICKS, SLIPS), (AGAIN, END)], rtol=1e-9)
    sliding = results["friction/rate"][:, 0] * -results["friction/force"][:, 0]
    np.testing.assert_allclose(power.lines[0].get_ydata(), sliding, atol=1e-12)
    assert any("shaded: it sticks" in text.get_text() for text in figure.texts)


# What is said of a point that slides on the plane of a stop: both tangents together, by the name of the stop.

#: Thrown at 3 and 4 m/s along a floor with μ = 0.5 under g = 10 it rests after 1 s; with 12.5 J less.
FLOOR = """\
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 1.6 s, integrator: dop853, tolerance: 1.0e-10, output_step: 0.03 s}
bodies:
  box: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0], velocity: [3, 4, 0]}
forces:
  floor:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: box, location: {box: [0, 0, 0]}}
    rigid: true
    restitution: 0
    friction: {coefficient: 0.5, static: 0.6}
"""


@pytest.fixture(scope="module")
def floor_folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("floor")
    (path / "floor.yaml").write_text(FLOOR)
    succeeds("run", "floor.yaml", "--json", folder=path)
    return path


def test_both_tangents_are_one_friction(floor_folder):
    (name, found), *others = json.loads(mbproj("info", "results.h5", "--json", folder=floor_folder).stdout)[
        "frictions"
    ].items()
    assert (name, others, found["unit"]) == ("floor", [], "m")
    assert (found["sticks"], found["slips"], found["turns"]) == (1, 0, 0)
    assert found["sticking_seconds"] == pytest.approx(0.6, rel=1e-8)
    assert found["largest_force"] == pytest.approx(5.0, rel=1e-9)
    assert found["energy"] == pytest.approx(12.5, rel=1e-8)


def test_a_tangent_sticks_when_both_do(floor_folder):
    with open_results(floor_folder / "results.h5") as results:
        assert results.names("frictions") == ("floor.1", "floor.2")
        for name in results.names("frictions"):
            np.testing.assert_allclose(sticking(results, name), [(1.0, 1.6)], rtol=1e-8)


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("position: [0, 0, 0], velocity: [0, 0, 0]", "sticking at the start: 'floor' bears 0 of 6 N"),
        ("position: [0, 0, 1], velocity: [0, 0, 0]", "none sticks at the start"),
        ("position: [0, 0, 0], velocity: [3, 4, 0]", "none sticks at the start"),
    ],
)
def test_check_says_whether_the_point_sticks_where_it_touches(floor_folder, place, said):
    (floor_folder / "there.yaml").write_text(FLOOR.replace("position: [0, 0, 0], velocity: [3, 4, 0]", place))
    assert f"  1 dry friction, {said}" in mbproj("check", "there.yaml", folder=floor_folder).stdout.splitlines()


# A regularised brake never holds: how far it has crept is said, against the closed form.

#: 1 N m on a brake of 2 N m: it creeps with w artanh(1/2) as soon as J w/T have passed.
CREEPING = """\
mbproj: 1
gravity: [0, 0, 0]
parameters: {load: 1, speed: 0}
simulation: {duration: 2 s, integrator: radau5, tolerance: 1.0e-9, output_step: 0.05 s}
bodies:
  rotor: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
joints:
  B: {type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0, 0, 1], speed: speed}
forces:
  load: {type: torque, body: rotor, torque: [0, 0, load]}
  brake: {type: friction, joint: B, coulomb: {torque: 2, regularised: 0.01}}
"""


def test_how_far_it_has_crept(tmp_path):
    (tmp_path / "brake.yaml").write_text(CREEPING)
    done = succeeds("run", "brake.yaml", "--json", folder=tmp_path)
    said = mbproj("info", "results.h5", folder=tmp_path).stdout
    for found in (json.loads(done.stdout), json.loads(mbproj("info", "results.h5", "--json", folder=tmp_path).stdout)):
        brake = found["creep"]["brake"]
        assert (brake["unit"], brake["width"], found["frictions"]) == ("rad", 0.01, {})
        assert brake["seconds"] == pytest.approx(2.0)
        assert brake["creep"] == pytest.approx(2.0 * 0.01 * np.arctanh(0.5), rel=1e-4)
    assert f"brake  crept by {brake['creep']:.4g} rad in 2 s, slower than its 0.01 rad/s" in said


def test_what_slides_does_not_creep(tmp_path):
    (tmp_path / "brake.yaml").write_text(CREEPING.replace("{load: 1, speed: 0}", "{load: 3, speed: 1}"))
    mbproj("run", "brake.yaml", "--quiet", folder=tmp_path)
    assert "brake  never slower than its 0.01 rad/s" in mbproj("info", "results.h5", folder=tmp_path).stdout


# What a scene may expect of its dry friction, and what a run then finds.

#: I ω' = -4 from ω = 3: the disc turns 9/4 rad in 1.5 s, and its energy of 9 J is lost.
EXPECTING = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1e-10, integrator: dopri5, output_step: 0.25}
bodies: {disc: {mass: 1, inertia: [1, 1, 2], position: [0, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, disc], location: [0, 0, 0], axis: [0, 0, 1], speed: 3}}
forces: {brake: {type: friction, joint: A, coulomb: {torque: 4, static: 5}}}
expect:
  angle: {joint: A, quantity: angle, at: end, value: 9 / 4, absolute: 1e-9, source: I w^2 / 2 T}
  heat: {friction: brake, quantity: dissipation, at: end, value: 9 J, relative: 1e-9, source: kinetic energy}
  slides: {friction: brake, quantity: state, at: 1.25, value: 1, absolute: 1e-9, source: w = 0.5 rad/s}
  holds: {friction: brake, quantity: state, at: 1.75, value: 0, absolute: 1e-9, source: w = 0 from 1.5 s on}
  torque: {friction: brake, quantity: force, at: minimum, value: -4 N*m, absolute: 1e-9, source: statics}
"""


def test_a_run_finds_them_and_tells_them(tmp_path):
    (tmp_path / "brake.yaml").write_text(EXPECTING, encoding="utf-8")
    done = mbproj("run", "brake.yaml", "-o", "brake.h5", folder=tmp_path)
    assert done.returncode == 0 and "expectations        5 of 5 hold" in done.stdout, done.stdout + done.stderr
    scene = read_scene_text(EXPECTING)
    with open_results(tmp_path / "brake.h5") as results:
        seen = results.friction("brake")
        assert results.names("frictions") == ("brake",) and results.names("friction_units") == ("rad",)
        aside = np.abs(results.time - 1.5) > 0.1
        np.testing.assert_array_equal(seen.state[aside], np.where(results.time < 1.5, 1, 0)[aside])
        np.testing.assert_allclose(seen.rate, np.maximum(3.0 - 2.0 * results.time, 0.0), atol=1e-9)
        found = {each.quantity: series(each, results) for each in scene.expectations if each.of == "friction"}
        np.testing.assert_array_equal(found["force"][:, 0], seen.force)
        np.testing.assert_array_equal(found["dissipation"][:, 0], seen.dissipation)
        shown = {entry.path.partition("/")[2] for entry in results.datasets if entry.symbol == "nr"}
        assert shown == OBSERVABLES["friction"].keys()
    assert mbproj("export", "brake.h5", "-o", "tables", folder=tmp_path).returncode == 0
    head, *rows = (tmp_path / "tables" / "brake-friction-brake.csv").read_text(encoding="utf-8").splitlines()
    assert head.split(",")[-2:] == ["state (1)", "dissipation (J)"] and len(rows) == 9


def test_frictions_have_the_names_and_units_of_the_arrays():
    scene = read_scene_text(MANY)
    names = compile_system(scene).names
    found = friction_units({joint.name: joint for joint in scene.joints}, {force.name: force for force in scene.forces})
    assert found == dict(zip(names.frictions, names.friction_units, strict=True))


def expecting(given):
    head = EXPECTING[: EXPECTING.index("expect")]
    return f"{head}expect:\n  e: {{{given}, at: end, value: 1, absolute: 1, source: x}}\n"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("friction: break, quantity: force", "8:17: error: unknown dry friction 'break'; did you mean 'brake'?"),
        ("friction: brake, quantity: gap", "8:34: error: a dry friction has no 'gap'; it has: rate, force, state, "
         "dissipation"),
        ("force: brake, quantity: force", "8:14: error: force 'brake' is dry friction; write  friction: NAME  with "
         "rate, force, state or dissipation"),
    ],
)  # fmt: skip
def test_an_expectation_of_no_friction(given, message):
    assert errors(expecting(given)) == [f"f.yaml:{message}"]


def test_an_expectation_is_in_the_unit_of_what_it_is_about():
    """What is regularised is a force as others are; it has no state."""
    smooth = expecting("friction: brake, quantity: force").replace("static: 5", "regularised: 1 rpm")
    assert errors(smooth) == ["f.yaml:8:17: error: unknown dry friction 'brake'; the scene has none that sticks"]
    (found,) = read_scene_text(smooth.replace("friction: brake, q", "force: brake, q")).expectations
    assert (found.of, found.unit) == ("force", "N*m")
    wrong = expecting("friction: brake, quantity: force").replace("value: 1", "value: 1 N")
    assert errors(wrong) == ["f.yaml:8:57: error: 'force' is in N*m, this is a force, in N"]
    (state,) = read_scene_text(expecting("friction: brake, quantity: state")).expectations
    assert state.unit == ""


# Commands on scenes with dry friction.

#: Two arms of 1 kg each with their masses at 1 m and 3 m from the wall: a brake that holds 40 N m bears both, the other
#: one its own arm. The third joint slides.
ARMS = """\
mbproj: 1
title: Arms
gravity: [0, 0, -10]
parameters: {most: 45 N*m}
simulation: {duration: 1 s, step: 1 ms}
bodies:
  upper: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
  lower: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [3, 0, 0]}
  wheel: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 1, 0]}
joints:
  A: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [upper, lower], location: [2, 0, 0], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [ground, wheel], location: [0, 1, 0], axis: [0, 1, 0], speed: 3}
forces:
  shoulder: {type: friction, joint: A, coulomb: {torque: 5, static: most}}
  elbow: {type: friction, joint: B, coulomb: {torque: 10, static: 12}}
  axle: {type: friction, joint: C, coulomb: {torque: 0.5}}
"""


@pytest.fixture
def belt_scene(tmp_path):
    (tmp_path / "arms.yaml").write_text(ARMS)
    (tmp_path / "belt.yaml").write_text(BELT)
    return tmp_path


def test_check_says_what_sticks_at_the_start_and_what_it_bears(belt_scene):
    said = mbproj("check", "arms.yaml", folder=belt_scene).stdout.splitlines()
    line = "  3 dry frictions, sticking at the start: 'shoulder' bears 40 of 45 N m, 'elbow' bears 10 of 12 N m"
    assert line in said
    found = json.loads(mbproj("check", "arms.yaml", "--json", folder=belt_scene).stdout)["frictions_at_start"]
    assert [entry["sticks"] for entry in found.values()] == [True, True, False]
    assert [abs(entry["force"]) for entry in found.values()] == pytest.approx([40.0, 10.0, 0.5], rel=1e-12)
    assert [entry["static"] for entry in found.values()] == pytest.approx([45.0, 12.0, 0.5], rel=1e-12)
    assert (found["axle"]["direction"], found["axle"]["rate"]) == (1.0, pytest.approx(3.0))


def test_a_brake_that_is_too_weak_slips_at_the_start(belt_scene):
    said = mbproj("check", "arms.yaml", "--set", "most=39", folder=belt_scene).stdout
    assert "'shoulder' bears" not in said and "3 dry frictions, sticking at the start: 'elbow' bears" in said


def test_the_integrator_may_be_chosen_on_the_way(belt_scene):
    options = ("--integrator", "auto", "--tolerance", "1e-6")
    assert mbproj("check", "belt.yaml", *options, folder=belt_scene).returncode == 0
    done = succeeds("run", "belt.yaml", *options, folder=belt_scene)
    assert "dop853 throughout: " in done.stdout


def test_compare_divides_no_energy_of_friction(belt_scene):
    """Steps that end where a friction sticks or slips are not those that the split makes again."""
    options = ("--projections", "gpopm", "--until", "0.2", "--repeat", "1", "-j", "1", "--json")
    done = succeeds("compare", "belt.yaml", *options, folder=belt_scene)
    (entry,) = json.loads(done.stdout)["entries"]
    assert entry["error"] < 1e-9 and entry["failure"] == ""
    assert entry["energy_drift_integrator"] is entry["energy_drift_projection"] is None
