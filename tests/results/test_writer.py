"""What is written is what is read, bit for bit: datasets, dimension scales, signs of Λ, applied forces."""

from __future__ import annotations

import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mbproj
from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.results.analysis.loads import loads_of
from mbproj.results.analysis.tables import tables
from mbproj.results.check import check_results
from mbproj.results.events import RecordedEvent
from mbproj.results.faults import OutputError
from mbproj.results.layout import ALL_NAMES, DATASETS
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from tests.results.pendulum_blocks import NAMES, NO_NAMES, PATHS, SETTINGS, block, part_of, record, scene, times
from tests.support import ROOT, Recorder

# What is written is what is read, bit for bit, however the blocks are cut, and every dataset says what it is.

#: Bodies, markers, joints and coordinates of the pendulum, by the layout's symbols.
SIZES = {"n": 1, "k": 2, "nj": 2, "nc": 1, "nf": 1, "nm": 1}


def test_events_are_kept_as_far_as_the_run_got(tmp_path):
    path, whole = tmp_path / "out.h5", block(times())
    told = [
        RecordedEvent(float(whole["time"][3]), "force 'ä'", "jump"),
        RecordedEvent(float(whole["time"][-1]), "stop", "kink", -1),
    ]
    with ResultsWriter(path, scene(), NAMES) as recorder:
        recorder.events([*told, RecordedEvent(1e6, "too late", "kink")])
        recorder.write(whole)
    with open_results(path) as results:
        assert list(results.events) == told
        assert check_results(results).faults == ()
    with h5py.File(path) as file:
        assert file["events/time"].attrs["units"] == "s" and file["events/name"].attrs["description"]
    assert open_results(record(tmp_path / "none.h5", whole)).events == ()


def test_threads_write_at_the_same_time(tmp_path):
    """While another thread switches as often as it can."""
    whole, before = block(times(20)), sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            paths = list(pool.map(lambda number: record(tmp_path / f"{number}.h5", whole), range(16)))
    finally:
        sys.setswitchinterval(before)
    for path in paths[::8]:
        with open_results(path) as results:
            assert check_results(results).faults == ()


def test_what_is_open_can_be_opened_by_h5py_too(tmp_path):
    path = record(tmp_path / "out.h5", block(times(20)))
    with open_results(path) as results, h5py.File(path) as file:
        assert np.array_equal(file["time"][()], results.time)
    with h5py.File(path) as file, open_results(path) as results:
        assert np.array_equal(file["time"][()], results.time)


def assert_equal(path: Path, expected: dict) -> None:
    with open_results(path) as results:
        for name in PATHS:
            assert results[name].dtype == expected[name].dtype, name
            assert results[name].tobytes() == expected[name].tobytes(), name


def test_round_trip_is_exact(tmp_path):
    whole = block(times())
    whole["diagnostics/energy_balance"][3] = -0.0
    whole["joints/reaction_force"][4, 1] = np.nan
    whole["diagnostics/total_energy"][5] = np.inf
    assert_equal(record(tmp_path / "out.h5", whole), whole)


@pytest.mark.full
@settings(max_examples=10, deadline=None)
@given(cuts=st.lists(st.integers(0, 700), max_size=12), every_flush=st.booleans())
def test_size_of_the_blocks_does_not_matter(cuts, every_flush):
    whole = block(times(700))
    edges = [0, *sorted(cuts), 700]
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr("mbproj.results.writer.FLUSH_SECONDS", 0.0 if every_flush else 60.0)
        path = Path(folder) / "out.h5"
        with ResultsWriter(path, scene(), NAMES) as recorder:
            for first, last in pairwise(edges):
                recorder.write(part_of(whole, slice(first, last)))
        assert_equal(path, whole)


@pytest.mark.parametrize("removed", [True, False])
def test_what_is_left_of_results_that_cannot_be_renamed_is_said(removed, tmp_path):
    def write() -> None:
        with ResultsWriter(tmp_path / "out.h5", scene(), NAMES) as recorder:
            recorder.write(block(times(10)))
            if removed:
                recorder.part.unlink()
            else:
                (tmp_path / "out.h5").mkdir()

    left = "it was removed meanwhile, and what was written is lost" if removed else "what was written before is still"
    with pytest.raises(OutputError, match=f"^cannot write '{tmp_path / 'out.h5.part'}': .*; {left}"):
        write()
    assert (tmp_path / "out.h5.part").exists() is not removed


def test_arrays_may_be_reused_after_write(tmp_path):
    first, second = block(times(10)), block(times(10) + 0.1)
    with ResultsWriter(tmp_path / "out.h5", scene(), NAMES) as recorder:
        scratch = {name: values.copy() for name, values in first.items()}
        recorder.write(scratch)
        for name, values in scratch.items():
            values[...] = second[name]
        recorder.write(scratch)
    both = {name: np.concatenate([first[name], second[name]]) for name in PATHS}
    assert_equal(tmp_path / "out.h5", both)


def test_nothing_but_bodies(tmp_path):
    whole = block(times(20), NO_NAMES)
    path = record(tmp_path / "out.h5", whole, names=NO_NAMES)
    assert_equal(path, whole)
    with open_results(path) as results:
        assert results["markers/position"].shape == (20, 0, 3)
        assert results.names("joints") == ()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A file that no test changes."""
    return record(tmp_path_factory.mktemp("recorded") / "out.h5")


@pytest.mark.parametrize("dataset", DATASETS, ids=lambda dataset: dataset.path)
def test_every_dataset_says_what_it_is(recorded, dataset):
    with h5py.File(recorded, "r") as file:
        stored = file[dataset.path]
        assert stored.attrs["units"] == dataset.unit
        assert stored.attrs["description"] == dataset.description
        assert stored.attrs.get("frame") == dataset.frame
        assert stored.shape == (201, *(SIZES.get(axis, axis) for axis in dataset.shape))
        assert stored.compression is None


def test_layout_covers_the_frames_of_vectors():
    framed = {dataset.path: dataset.frame for dataset in DATASETS if dataset.shape[-1:] == (3,)}
    assert framed.pop("bodies/angular_velocity") == framed.pop("bodies/angular_acceleration") == "body axes"
    assert set(framed.values()) == {"global axes"}


def test_names_units_and_scene_come_back(tmp_path):
    projection = ProjectionSettings("baumgarte", gains=(25.0, 0.1 + 0.2), position=False)
    how = replace(SETTINGS, step=None, tolerance=1e-8, projection=projection)
    path = record(tmp_path / "out.h5", the_scene=scene(settings=how))
    with open_results(path) as results:
        assert results.settings == how
        assert results.scene_text == scene().text
        assert results.scene_path == Path("scenes/pendulum.yaml")
        assert results.title == "Pendulum of 9.8/9 m"
        assert results.overrides == {"length": "9.8/9"}
        assert results.gravity == (0.0, 0.0, -9.8)
        assert results.names("joints") == ("A", "Gelenk ä")
        assert results.names("coordinate_units") == ("rad",)


def test_scene_without_path_title_and_text(tmp_path):
    path = record(tmp_path / "out.h5", the_scene=scene(path=None, title="", text="", settings=Settings(), overrides={}))
    with open_results(path) as results:
        assert (results.scene_path, results.title, results.scene_text) == (None, "", "")
        assert results.settings == Settings()


def test_long_scene_text(tmp_path):
    text = "# ü\n" * 100_000
    with open_results(record(tmp_path / "out.h5", the_scene=scene(text=text))) as results:
        assert results.scene_text == text


def test_attributes(tmp_path):
    path = tmp_path / "out.h5"
    with ResultsWriter(path, scene(), NAMES) as recorder:
        recorder.write(block(times(3)))
        recorder.attributes({"integration_seconds": 0.25, "worst_joint": None, "status": "overwritten below"})
        recorder.attributes({"integration_seconds": 0.5, "formulation": "full"})
    with open_results(path) as results:
        found = results.attributes
        assert (found["integration_seconds"], found["formulation"]) == (0.5, "full")
        assert "worst_joint" not in found
        assert (found["format"], found["schema_version"], found["status"]) == ("mbproj results", 3, "complete")
        assert (found["numpy_version"], found["h5py_version"]) == (np.__version__, h5py.__version__)
        assert {"date", "host", "mbproj_version"} <= set(found)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda b: b.pop("markers/position"), "the block has no 'markers/position'"),
        (lambda b: b.update({"bodies/colour": b["time"]}), "the layout has no 'bodies/colour'"),
        (
            lambda b: b.update({"joints/violation": b["time"]}),
            r"'joints/violation' has the shape \(5,\) where \(5, 2\) is due",
        ),
    ],
)
def test_a_wrong_block_is_refused(tmp_path, change, message):
    wrong = block(times(5))
    change(wrong)
    recorder = ResultsWriter(tmp_path / "out.h5", scene(), NAMES)
    with pytest.raises(ValueError, match=message), recorder:
        recorder.write(wrong)


def test_counters_must_be_integers(tmp_path):
    wrong = block(times(5))
    wrong["diagnostics/steps"] = wrong["time"]
    recorder = ResultsWriter(tmp_path / "out.h5", scene(), NAMES)
    with pytest.raises(TypeError, match="Cannot cast"), recorder:
        recorder.write(wrong)


def test_time_comes_after_all_other_data(tmp_path, monkeypatch):
    """A write that fails between two datasets, the k-th of the second flush, leaves no time without its samples."""
    from mbproj.results import writer

    append, whole = writer.append, block(times(20))
    first, second = part_of(whole, slice(10)), part_of(whole, slice(10, 20))
    for most in range(0, len(PATHS), 7):
        path, done = tmp_path / f"{most}.h5", []

        def failing(target, values, at, most=most, done=done):
            done.append(at)
            if done.count(10) > most:
                raise OSError("no more")
            append(target, values, at)

        monkeypatch.setattr(writer, "append", failing)
        monkeypatch.setattr(writer, "FLUSH_SECONDS", 0.0)
        with pytest.raises(OutputError), ResultsWriter(path, scene(), NAMES) as recorder:
            recorder.write(first)
            recorder.write(second)
        with h5py.File(path.with_name(f"{path.name}.part")) as file:
            assert len(file["time"]) == 10
            assert min(len(file[name]) for name in PATHS) == 10


# Dimension scales: every axis of an array has its names, for HDF5's own calls and for xarray.


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("scales") / "results.h5"
    mbproj.run(ROOT / "mechanisms" / "five_bar.yaml", duration=0.05, output=path).close()
    return path


def test_every_axis_has_a_scale_of_its_length(path):
    with mbproj.open_results(path) as results, h5py.File(path, "r") as file:
        for dataset in results.datasets:
            array = file[dataset.path]
            for axis, length in enumerate(array.shape):
                if dataset.path == "time":
                    continue
                assert h5py.h5ds.get_num_scales(array.id, axis) == 1, dataset.path
                assert h5py.h5ds.is_attached(array.id, array.dims[axis][0].id, axis)
                assert array.dims[axis][0].shape == (length,), dataset.path
        assert list(file["joints/speed"].dims[1][0].asstr()) == [f"{name}.angle" for name in "ABCDE"]
        assert file["bodies/time"] == file["time"]
        uses = file["time"].attrs["REFERENCE_LIST"]
        assert {file[each["dataset"]].name for each in uses} >= {"/bodies/position", "/diagnostics/steps"}


def test_every_kind_of_names_is_a_scale():
    from mbproj.results.writer import NAMES

    assert set(NAMES) == {entry.symbol for entry in ALL_NAMES.values()}


def test_a_scale_can_be_detached(path, tmp_path):
    """HDF5's own call finds both lists that were written as it writes them."""
    copy = tmp_path / "copy.h5"
    copy.write_bytes(path.read_bytes())
    with h5py.File(copy, "r+", libver=("v110", "v110")) as file:
        array, before = file["bodies/position"], len(file["time"].attrs["REFERENCE_LIST"])
        h5py.h5ds.detach_scale(array.id, file["time"].id, 0)
        assert len(file["time"].attrs["REFERENCE_LIST"]) == before - 1
        assert h5py.h5ds.get_num_scales(array.id, 0) == 0


def test_xarray_shows_times_and_names(path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    with xarray.open_dataset(path, group="bodies", engine="h5netcdf") as bodies, mbproj.open_results(path) as results:
        height = bodies.position.sel(names="bar3", axis="z")
        np.testing.assert_array_equal(height, results.body("bar3").position[:, 2])
        np.testing.assert_array_equal(bodies.time, results.time)
        assert bodies.position.attrs["units"] == "m"
    with xarray.open_dataset(path, group="joints", engine="h5netcdf") as joints:
        assert joints.reaction_force.dims == ("time", "names", "axis")
        assert list(joints.coordinate_names.values) == [f"{name}.angle" for name in "ABCDE"]


# Euler parameters are recorded without jumps: Λ and -Λ are one orientation, but derivatives of a record are wrong where
# the sign changes between two samples.

CRANK = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2.2 s, tolerance: 1e-6, integrator: dop853, output_step: 20 ms}
bodies:
  crank: {mass: 0.5, inertia: [2e-3, 2e-3, 2e-3], position: [0.12, 0, 0]}
  spun: {mass: 1, inertia: [1e-2, 1e-2, 1e-2], position: [1, 0, 0], angular_velocity: [0, -17, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [ground, spun], location: [1, 0, 0], axis: [0, 1, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 75 rpm}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_orientations_do_not_jump_between_samples(formulation: str) -> None:
    scene = read_scene_text(CRANK)
    system, recorder = compile_system(scene), Recorder()
    simulate(
        system,
        assemble(system, initial_guess(scene, system)),
        replace(scene.settings, formulation=formulation),
        recorder,
    )
    found = recorder["bodies/orientation"]
    assert len(found) == 111  # five turns and a half of one, and six of the other
    assert np.sum(found[1:] * found[:-1], axis=-1).min() > 0.98


def test_a_run_that_goes_on_does_not_jump() -> None:
    """At 0.42 s the crank has turned by more than half a turn."""
    scene = read_scene_text(CRANK)
    system = compile_system(scene)
    state, recorder, kept = assemble(system, initial_guess(scene, system)), Recorder(), list[Any]()
    settings = replace(scene.settings, formulation="planar")
    simulate(system, state, replace(settings, duration=0.42), recorder, keep=lambda *mark: kept.append(mark[-1]))
    simulate(system, state, settings, recorder, keep=lambda *_: None, resumed=kept[-1])
    times, rows = np.unique(recorder["time"], return_index=True)
    found = recorder["bodies/orientation"][rows]
    assert len(times) == 111
    assert np.sum(found[1:] * found[:-1], axis=-1).min() > 0.98


# Forces and torques of given components are recorded: their values, their power, their work.

SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, tolerance: 1e-10, integrator: dop853, output_step: 5 ms, formulation: FORMULATION}
bodies:
  rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  push: {type: force, body: rod, location: [1, 0, 0], force: [0, 0, "5*sin(3*t)"]}
  follow: {type: force, body: rod, location: [1, 0, 0], axes: body, force: [0, 0, 2]}
  twist: {type: torque, body: rod, axes: body, torque: [0, "2*t", 0]}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["full", "reduced", "planar"])
def test_given_forces_are_recorded_with_their_power_and_their_work(tmp_path, formulation):
    scene = read_scene_text(SCENE.replace("FORMULATION", formulation))
    system = compile_system(scene)
    with ResultsWriter(tmp_path / "out.h5", scene, system.names.as_mapping()) as recorder:
        simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    with open_results(tmp_path / "out.h5") as results:
        assert results.names("applied") == ("push", "follow", "twist")
        time, angle, speed = results.time, *results["joints/coordinate"].T, *results["joints/speed"].T
        push, follow, twist = np.swapaxes(results["forces/applied"], 0, 1)
        np.testing.assert_allclose(push[:, 2], 5.0 * np.sin(3.0 * time), atol=1e-14)
        np.testing.assert_allclose(twist, np.outer(2.0 * time, [0.0, 1.0, 0.0]), atol=1e-14)
        along = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)  # body z, turned about y
        np.testing.assert_allclose(follow, 2.0 * along, atol=1e-12)
        power = np.stack([-push[:, 2] * np.cos(angle) * speed, -2.0 * speed, 2.0 * time * speed], axis=1)
        np.testing.assert_allclose(results["forces/applied_power"], power, atol=1e-11)
        works = [load.put_in - load.taken_out for load in loads_of(results) if load.quantity == "power"]
        assert sum(works) == pytest.approx(results["diagnostics/work"][-1], abs=1e-6)
        pushed = next(table for table in tables(results) if table.name == "force-push")
    assert pushed.headings[3:] == ("applied_z (N)", "applied_power (W)")
