"""`mbproj modes`, `modes.h5`, and `mbproj plot modes.h5`: what they say, write and refuse."""

from __future__ import annotations

import json
from math import pi, sqrt

import h5py
import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.modes import modes, stored
from mbproj.linear.reference import reference_at
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.results.linear_files import MODES_LAYOUT, read_modes, write_modes
from mbproj.scene.scene import read_scene_text
from tests.cli.commands import mbproj
from tests.linear.closed_forms import g, modes_of, under_gravity
from tests.stops.scenes import resting_on_a_stop

SCENE = under_gravity("""\
parameters: {m: 2, length: 0.5 m}
bodies:
  bar: {mass: m, inertia: [0.1, 0.17, 0.17], position: [0, 0, -length]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
""")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    return tmp_path


def frequency(length):
    return sqrt(2 * g * length / (0.17 + 2 * length**2)) / (2 * pi)


def test_json_has_stable_keys(folder):
    done = mbproj("modes", "scene.yaml", "--json", folder=folder)
    found = json.loads(done.stdout)
    assert found["frequencies_hz"] == pytest.approx([frequency(0.5)], rel=1e-12)
    assert (found["damping_ratios"], found["growth_rates"]) == ([0.0], [0.0])
    assert (found["at"], found["degrees_of_freedom"], found["balanced"]) == ("start", 1, True)
    assert found["modes"][0]["kinetic_energy"] == {"bar": 1.0}
    assert (folder / "modes.h5").exists()


UNLOADED = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 1 ms}
bodies: {b: {mass: 4, inertia: [1, 1, 1], position: [0, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, b], location: [0, 0, 0], axis: [1, 0, 0]}}
forces: {spring: {type: linear_spring_damper, joint: rail, stiffness: 100}}
"""


def test_where_no_force_acts_forces_balance(folder):
    (folder / "unloaded.yaml").write_text(UNLOADED)
    found = json.loads(mbproj("modes", "unloaded.yaml", "--json", folder=folder).stdout)
    assert (found["balanced"], found["imbalance"]["relative"]) == (True, 0.0)
    assert found["frequencies_hz"] == pytest.approx([5.0 / (2.0 * pi)], rel=1e-12)
    done = mbproj(
        "linearize", "unloaded.yaml", "--inputs", "spring", "--outputs", "rail.displacement", "--json", folder=folder
    )
    assert json.loads(done.stdout)["balanced"] is True
    found = json.loads(mbproj("equilibrium", "unloaded.yaml", "--json", folder=folder).stdout)
    assert (found["converged"], found["residual"]["relative"]) == (True, 0.0)


SPRING = "forces: {spring: {type: linear_spring_damper, joint: rail, stiffness: 700}}\n"


@pytest.mark.parametrize("at", ["start", "0.1 s"])
def test_modes_and_linear_models_are_those_of_where_a_run_begins(folder, at):
    """40 N press the mass on a stop of 900 N/m, beside a spring of 700 N/m: ω = 20 rad/s."""
    (folder / "rests.yaml").write_text(resting_on_a_stop(4.0, "step: 1 ms", SPRING))
    found = json.loads(mbproj("modes", "rests.yaml", "--at", at, "--json", folder=folder).stdout)
    assert found["frequencies_hz"] == pytest.approx([20.0 / (2.0 * pi)], rel=1e-9)
    assert found["balanced"]
    done = mbproj(
        "linearize",
        "rests.yaml",
        "--at",
        at,
        "--inputs",
        "spring",
        "--outputs",
        "rail.displacement",
        "--json",
        folder=folder,
    )
    assert json.loads(done.stdout)["A"][1][0] == pytest.approx(-400.0, rel=1e-9)


def test_a_trace_over_a_parameter_and_its_pictures(folder, undrawn):
    done = mbproj("modes", "scene.yaml", "--vary", "length=0.5 m:1000 mm:3", "-o", "t.h5", folder=folder)
    assert "3 values of length; the table is of the last, 1" in done.stdout
    traced = read_modes(folder / "t.h5")
    assert traced.varied == ("length",)
    assert traced.trace[:, 0].imag / (2 * pi) == pytest.approx([frequency(x) for x in (0.5, 0.75, 1.0)], rel=1e-12)
    drawn = mbproj("plot", "t.h5", folder=folder)
    assert drawn.stdout.split() == ["t-eigenvalues.png", "t-shapes.png", "t-traces.png"]


def test_a_time_of_a_run_and_of_its_file_give_the_same(folder):
    scene = SCENE.replace("axis: [0, 1, 0]}", "axis: [0, 1, 0], speed: 1 rad/s}")
    (folder / "swing.yaml").write_text(scene)
    assert mbproj("run", "swing.yaml", "-o", "r.h5", folder=folder).returncode == 0
    found = [
        json.loads(mbproj("modes", "swing.yaml", "--at", "0.25 s", "--json", *more, folder=folder).stdout)
        for more in ([], ["--from", "r.h5"])
    ]
    assert found[0]["angular_frequencies"] == pytest.approx(found[1]["angular_frequencies"], rel=1e-9)
    assert not found[0]["balanced"]
    assert "forces do not balance here" in found[0]["notes"][0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--at", "sometime"], "--at: error: unknown place 'sometime'; give start"),
        (["--at", "1 m"], "--at: error: '--at' is in s, this is a length, in m"),
        (["--at", "0.3", "--from", "r.h5"], "--from: error: 'r.h5' has no sample at t = 0.3 s; its nearest is at 0.25"),
        (["--from", "r.h5"], "--from: error: it needs a time; give one of its samples: --at TIME"),
        (["--vary", "length"], "--vary: error: 'length' is not NAME=RANGE"),
        (["--vary", "size=1:2:3"], "--set size: error: unknown parameter 'size'"),
        (["-o", "scene.yaml"], "'scene.yaml' exists and is not an HDF5 file of mbproj, so it is not replaced"),
    ],
)
def test_what_is_wrong_is_said_at_its_place(folder, arguments, said):
    options = ("--duration", "0.25", "--output-step", "0.25")
    assert mbproj("run", "scene.yaml", *options, "-o", "r.h5", folder=folder).returncode == 0
    done = mbproj("modes", "scene.yaml", *arguments, folder=folder)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr


def test_options_for_results_do_not_fit_a_file_of_modes(folder):
    assert mbproj("modes", "scene.yaml", "-q", folder=folder).stdout == ""
    done = mbproj("plot", "modes.h5", "--marker", "tip", folder=folder)
    assert (done.returncode, "--marker is for results of runs, and 'modes.h5' is none" in done.stderr) == (
        2,
        True,
    )
    done = mbproj("plot", "modes.h5", "--kind", "traces", folder=folder)
    assert "--kind traces: no parameter was varied: mbproj modes --vary" in done.stderr


def test_a_file_without_modes_has_nothing_to_draw(folder):
    fixed = SCENE + "  end: {type: revolute, bodies: [ground, bar], location: [1, 0, 0], axis: [0, 1, 0]}\n"
    (folder / "fixed.yaml").write_text(fixed)
    assert mbproj("modes", "fixed.yaml", folder=folder).returncode == 0
    done = mbproj("plot", "modes.h5", folder=folder)
    assert (done.returncode, "'modes.h5' has nothing to draw: the mechanism has no modes" in done.stderr) == (2, True)


# `modes.h5`: what stands in it is what was found, and what is wrong with a file is said.

#: A pendulum of two bodies that a fixed joint makes one, so that bodies and carriers differ.
MERGED = under_gravity("""\
bodies:
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, -0.5], orientation: {axis: [0, 1, 0], angle: 90 deg}}
  bob: {mass: 2, inertia: [0.2, 0.2, 0.2], position: [0.1, 0, -1], orientation: {axis: [1, 2, 0], angle: 50 deg}}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
  weld: {type: fixed, bodies: [rod, bob], location: [0, 0, -1]}
""")


@pytest.fixture
def written(tmp_path):
    scene = read_scene_text(MERGED)
    system = compile_system(scene)
    found = modes(reference_at(system, assembled_start(scene, system), "start"))
    return write_modes(tmp_path / "modes.h5", stored(found, "a pendulum"), scene), found


def test_what_is_written_is_read(written):
    path, found = written
    read = read_modes(path)
    np.testing.assert_array_equal(read.eigenvalue, found.eigenvalues)
    np.testing.assert_array_equal(read.coordinate_shape, found.coordinates)
    assert (read.bodies, read.title, read.where, read.time) == (("rod", "bob"), "a pendulum", "start", 0.0)


def test_every_body_of_the_scene_moves_about_the_pin(written):
    """Each turns alike about y, and its centre of mass moves as that turn about the pin says."""
    read = read_modes(written[0])
    np.testing.assert_allclose(read.position, [[0, 0, -0.5], [0.1, 0, -1]], atol=1e-15)
    expected = rotation_matrix(np.array(read.orientation))
    assert expected[0, 2, 0] == pytest.approx(-1.0)
    shift, turn = read.displacement[0, :, :3], read.displacement[0, :, 3:]
    np.testing.assert_allclose(turn[0], turn[1], atol=1e-15)
    np.testing.assert_allclose(shift, np.cross(turn, read.position), atol=1e-15)


def test_the_file_names_units_and_frames(written):
    with h5py.File(written[0]) as file:
        assert file["modes/displacement_real"].attrs["units"] == "m, rad"
        assert file["modes/displacement_real"].attrs["frame"] == "global axes"
        assert file.attrs["format"] == "mbproj modes"
        assert "revolute" in file["scene/text"][()].decode()


@pytest.mark.parametrize("part", [part.path for part in MODES_LAYOUT.parts if part.kind == "real"])
def test_a_file_whose_shapes_do_not_agree_is_refused(written, part):
    path, _ = written
    with h5py.File(path, "r+") as file:
        old = file[part]
        shape = (old.shape[0] + 1, *old.shape[1:])
        del file[part]
        file.create_dataset(part, data=np.zeros(shape))
    if part == "traces/value":
        part = "traces/eigenvalue"
    with pytest.raises(InputError, match=part):
        read_modes(path)


def test_another_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"there is no file '.*none\.h5'; write it with: mbproj modes SCENE"):
        read_modes(tmp_path / "none.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file.attrs["format"] = "something"
    with pytest.raises(InputError, match="is not a file of modes of mbproj"):
        read_modes(tmp_path / "other.h5")


def test_of_a_pair_of_equal_size_the_shape_is_scaled_to_the_mechanism():
    found = modes_of(MERGED)
    length = found.reference.system.length
    assert np.abs(found.shapes[0] / ([length] * 3 + [1.0] * 3)).max() == pytest.approx(1.0)
