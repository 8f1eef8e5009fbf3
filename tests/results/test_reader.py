"""Reading: by name, in windows, and what a prompt shows of results."""

from __future__ import annotations

import random
import shutil
import struct

import h5py
import numpy as np
import pytest

import mbproj
from mbproj import mobility, read_scene, simulate
from mbproj.base.errors import InputError
from mbproj.results.file.checksums import NOT_YET, stamp, stamp_attributes
from mbproj.results.file.opening import lookup3
from mbproj.results.layout import CONSTANTS
from mbproj.results.reader import open_own_results, open_results
from mbproj.scene.settings import settings_to_run
from tests.crossed import some
from tests.results.pendulum_blocks import AMPLITUDE, LENGTH, NAMES, PATHS, RATE, block, record, times
from tests.support import ROOT, assembled

# Reading: by name, in windows, and never anything but an InputError for a file that is not whole.


@pytest.fixture
def results(tmp_path):
    with open_results(record(tmp_path / "out.h5")) as opened:
        yield opened


def test_arrays_by_name(results):
    angle = AMPLITUDE * np.cos(RATE * times())
    assert np.array_equal(results.coordinate("A.angle").value, angle)
    assert results.coordinate("A.angle").unit == "rad"
    assert np.array_equal(results.marker("Mitte").position, 0.5 * results.marker("tip").position)
    assert np.allclose(np.linalg.norm(results.body("bob").position, axis=1), LENGTH, rtol=1e-14)
    assert np.array_equal(results.body("bob").angular_velocity[:, 0], results.coordinate("A.angle").speed)
    joint = results.joint("Gelenk ä")
    assert np.array_equal(joint.violation_angle, results["joints/violation_angle"][:, 1])
    assert np.array_equal(joint.reaction_torque, results["joints/reaction_torque"][:, 1])


def test_own_results_are_read_without_a_child_process(tmp_path, monkeypatch):
    path = record(tmp_path / "out.h5", block(times(40)))
    with open_results(path) as results:
        expected = {name: results[name].tobytes() for name in PATHS}
    monkeypatch.setattr("os.fork", None)
    with open_own_results(path) as results:
        assert {name: results[name].tobytes() for name in PATHS} == expected


def test_members_have_the_layouts_columns(results):
    """Each field of a member is the dataset of the same name."""
    for folder, member in (
        ("bodies", results.body("bob")),
        ("markers", results.marker("tip")),
        ("joints", results.joint("A")),
    ):
        for field, values in vars(member).items():
            assert np.array_equal(values, results[f"{folder}/{field}"][:, 0]), field


def test_arrays_are_read_only_and_stay_after_close(results):
    position = results["markers/position"]
    with pytest.raises(ValueError, match="read-only"):
        position[0] = 0.0
    results.close()
    assert results["markers/position"] is position


def test_select_window_and_names(results):
    part = results.select(start=0.5, stop=1.0, markers=["Mitte"], joints=["A"])
    assert np.array_equal(part.time, times()[50:101])
    assert part.names("markers") == ("Mitte",)
    assert part.names("coordinates") == ("A.angle",)
    assert np.array_equal(part["markers/velocity"], results["markers/velocity"][50:101, 1:])
    assert part["joints/reaction_force"].shape == part.shape("joints/reaction_force") == (51, 1, 3)
    again = part.select(start=0.6, stop=0.7)
    assert np.array_equal(again.time, times()[60:71])
    assert np.array_equal(again.marker("Mitte").position, results.marker("Mitte").position[60:71])
    assert results.select(joints=["Gelenk ä"]).names("coordinates") == ()
    assert len(results.select(start=3.0).time) == len(results.select(start=1.0, stop=0.5).time) == 0


def test_unknown_names(results):
    where = f"in '{results.path}'"
    cases = {
        lambda: results.marker("tipp"): f"error: no marker 'tipp' {where}; did you mean 'tip'? (markers: tip, Mitte)",
        lambda: results.joint("Z"): f"error: no joint 'Z' {where}; joints: A, Gelenk ä",
        lambda: results.coordinate("A.angel"): f"error: no joint coordinate 'A.angel' {where}; "
        "did you mean 'A.angle'? (coordinates: A.angle)",
        lambda: results.select(markers=["nix"]): f"error: no marker 'nix' {where}; markers: tip, Mitte",
    }
    for call, message in cases.items():
        with pytest.raises(InputError) as caught:
            call()
        assert str(caught.value) == message
    with pytest.raises(KeyError, match="no dataset 'bodies/positions'; did you mean 'bodies/position'"):
        results["bodies/positions"]


def test_missing_foreign_and_directory(tmp_path):
    (tmp_path / "scene.yaml").write_text("mbproj: 1\n")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1.0
    cases = {
        "no.h5": f"error: there is no results file '{tmp_path}/no.h5'; "
        f"write it with: mbproj run SCENE -o {tmp_path}/no.h5",
        "scene.yaml": f"error: '{tmp_path}/scene.yaml' is not a results file of mbproj; "
        "results are what 'mbproj run SCENE' writes",
        "other.h5": f"error: '{tmp_path}/other.h5' is not a results file of mbproj; "
        "results are what 'mbproj run SCENE' writes",
        ".": f"error: '{tmp_path}' is a directory; give a results file in it",
    }
    for name, message in cases.items():
        with pytest.raises(InputError) as caught:
            open_results(tmp_path / name)
        assert str(caught.value) == message
    with pytest.raises(InputError, match="File name too long"):
        open_results(tmp_path / ("x" * 300))


def changed(tmp_path, change) -> str:
    """What the reader says to a file that `change` was done to."""
    path = record(tmp_path / "changed.h5", block(times(20)))
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(InputError) as caught:
        open_results(path)
    return str(caught.value).replace(str(path), "OUT")


def test_another_schema_version(tmp_path):
    def older(file: h5py.File) -> None:
        file.attrs["schema_version"] = 1
        stamp_attributes(file)

    said = changed(tmp_path, older)
    assert said == (
        "error: 'OUT' has schema version 1, and this mbproj reads version 3; "
        "repeat the run, or read it with the mbproj that wrote it"
    )


def test_missing_and_misshapen_datasets(tmp_path):
    def without(file: h5py.File) -> None:
        del file["joints/speed"]

    def misshapen(file: h5py.File) -> None:
        del file["bodies/position"]
        file["bodies/position"] = np.zeros((20, 7))

    assert changed(tmp_path, without) == "error: 'OUT' is damaged: it has no 'joints/speed'; repeat the run"
    assert changed(tmp_path, misshapen) == (
        "error: 'OUT' is damaged: 'bodies/position' has the wrong shape or type; repeat the run"
    )


def test_lengths_that_differ_are_cut_to_the_shortest(tmp_path):
    """As after a kill in the middle of a flush."""
    path = record(tmp_path / "out.h5", block(times(20)))
    with h5py.File(path, "r+") as file:
        file["time"].resize(13, axis=0)
        stamp(file["time"], NOT_YET)
    with open_results(path) as results:
        assert {len(results[name]) for name in PATHS} == {13}


def read_everything(path) -> None:
    with open_results(path) as results:
        for name in PATHS:
            results[name]
        for kind in NAMES:
            results.names(kind)
        _ = (results.settings, results.title, results.scene_text, results.scene_path, results.overrides)
        _ = (results.gravity, results.status, results.attributes, results.marker("tip"))


#: Damages of each kind of file; many more are those of `scripts/fuzz_campaign.py --only results`.
TRIALS = 24


@pytest.mark.parametrize("flag", some([0, 1, 5], 3), ids=["closed", "opened", "killed"])
def test_truncated_and_flipped_files(tmp_path, flag):
    """A damaged file reads, or is refused with an InputError: never another exception, never a hang."""
    whole = bytearray(record(tmp_path / "out.h5", block(times(20))).read_bytes())
    whole[11] = flag
    whole[44:48] = struct.pack("<I", lookup3(bytes(whole[:44])))
    path, draw, refused = tmp_path / "damaged.h5", random.Random(flag), 0
    for trial in range(TRIALS):
        damaged = bytearray(whole)
        if trial % 3 == 0:
            del damaged[draw.randrange(len(damaged)) :]
        else:
            for _ in range(draw.choice([1, 3, 20])):
                damaged[draw.randrange(60_000)] ^= 1 << draw.randrange(8)
        path.write_bytes(damaged)
        try:
            read_everything(path)
        except InputError as error:
            assert str(error).startswith(("error: '", "error: no marker"))
            refused += 1
    assert TRIALS / 3 < refused < TRIALS


def test_checksum_of_the_superblock():
    """The published value of lookup3 for this text, and HDF5's own for a file that it wrote."""
    assert lookup3(b"Four score and seven years ago") == 0x17770551


def test_checksum_agrees_with_hdf5(tmp_path):
    head = record(tmp_path / "out.h5").read_bytes()[:48]
    assert struct.unpack("<I", head[44:])[0] == lookup3(head[:44])


def test_part_beside_a_finished_file_is_not_read(tmp_path):
    path = record(tmp_path / "out.h5", block(times(20)))
    shutil.copy(record(tmp_path / "new.h5", block(times(30))), tmp_path / "out.h5.part")
    with open_results(path) as results:
        assert (len(results.time), results.partial) == (20, False)


def test_import_is_light():
    import subprocess
    import sys

    code = "import mbproj.results.reader, sys; print('matplotlib' in sys.modules, 'scipy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False False\n"


UNIQUE = "joints/reaction_force_unique"


def test_marks_are_read_as_they_were_written_and_follow_the_joints(tmp_path):
    marks = np.array([[True, False, True], [False, True, True]])
    with open_results(record(tmp_path / "marks.h5", constants={UNIQUE: marks})) as results:
        assert np.array_equal(results.constant(UNIQUE), marks)
        assert np.array_equal(results.select(joints=["Gelenk ä"]).constant(UNIQUE), marks[1:])
        assert results.constant("joints/reaction_torque_unique") is None
        with pytest.raises(KeyError, match="did you mean 'joints/reaction_force_unique'"):
            results.constant("joints/reaction_force_uniqe")
    with h5py.File(tmp_path / "marks.h5") as file:
        assert file[UNIQUE].attrs["frame"] == "global axes"


def test_marks_of_the_wrong_shape_are_neither_written_nor_read(tmp_path):
    with pytest.raises(ValueError, match=r"has the shape \(3, 3\) where \(2, 3\) is due"):
        record(tmp_path / "never.h5", constants={UNIQUE: np.ones((3, 3), dtype=bool)})
    with pytest.raises(ValueError, match="the layout has no 'joints/unique'"):
        record(tmp_path / "never.h5", constants={"joints/unique": np.ones((2, 3), dtype=bool)})
    path = record(tmp_path / "damaged.h5")
    with h5py.File(path, "r+") as file:
        file[UNIQUE] = np.ones((2, 2), dtype=bool)
    with open_results(path) as results, pytest.raises(InputError, match="has the wrong shape or type"):
        results.constant(UNIQUE)


# What a prompt or a notebook shows of results is short, and the keys that the pages name exist.

#: The most lines of a value in a notebook.
LINES = 15


@pytest.fixture(scope="module")
def shown_results():
    with mbproj.run(ROOT / "mechanisms" / "planar_four_bar.yaml", duration=0.2, certify=True) as found:
        yield found


def test_values_of_results_are_shown_in_few_lines(shown_results):
    shown = [
        shown_results,
        shown_results.trust,
        shown_results.body(shown_results.names("bodies")[0]),
        shown_results.joint(shown_results.names("joints")[0]),
    ]
    for value in shown:
        lines = repr(value).splitlines()
        assert len(lines) <= LINES and max(map(len, lines)) <= 120, lines
    assert f"violation          array ({len(shown_results.time)},)" in repr(shown[-1])


def test_values_of_a_scene_are_shown_in_few_lines():
    scene = read_scene(ROOT / "mechanisms" / "planar_four_bar.yaml", {}, {"duration": "0.1"})
    system, state = assembled(scene)
    report = simulate(system, state, settings_to_run(scene))
    for value in (scene, system, state, report, mbproj.Mechanism.of(scene), mobility(system, state)):
        assert len(repr(value).splitlines()) <= LINES, type(value)
    assert repr(state).splitlines()[:2] == ["State", "  t                  0.0"]
    assert repr(system).splitlines()[-1].endswith(" more")


def test_what_does_not_change_is_found_by_its_path(shown_results):
    for entry in CONSTANTS:
        assert entry.path in shown_results
        np.testing.assert_array_equal(shown_results[entry.path], shown_results.constant(entry.path))
    with pytest.raises(KeyError, match="did you mean 'joints/reaction_force_unique'"):
        _ = shown_results["joints/reaction_forces_unique"]
    assert "joints/reaction_forces_unique" not in shown_results


def test_mobility_is_that_of_a_state():
    found = mobility(*assembled(read_scene(ROOT / "mechanisms" / "five_bar.yaml")))
    assert (found.degrees_of_freedom, found.rank) == (5, 30)
