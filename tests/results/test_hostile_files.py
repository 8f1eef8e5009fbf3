"""Results files that are damaged, or that somebody made to do harm."""

from __future__ import annotations

import json
import os
import random
import socket
from pathlib import Path

import h5py
import numpy as np
import pytest

from mbproj.base import sandbox
from mbproj.base.errors import InputError, MbprojWarning
from mbproj.results.check import check_results
from mbproj.results.file.checksums import OF_ATTRIBUTES, OF_DATA, create_text, stamp_attributes
from mbproj.results.file.opening import ClosedView
from mbproj.results.reader import BESIDE_SAMPLES, open_results
from tests.crossed import some
from tests.results.pendulum_blocks import NAMES, PATHS, block, record, times
from tests.results.processes import child

# A results file may come from anybody: whatever it declares or leads to, the reader reads it or refuses it.


@pytest.fixture
def path(tmp_path):
    return record(tmp_path / "out.h5", block(times(20)))


def said(path, change, read=lambda results: None) -> str:
    """What the reader says of a file that `change` was done to."""
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(InputError) as caught, open_results(path) as results:
        read(results)
    return str(caught.value).removeprefix(f"error: '{path}'").removesuffix("; repeat the run")


def external_link(file: h5py.File) -> None:
    file["bodies/mine"] = h5py.ExternalLink("pipe", "/data")


def external_group(file: h5py.File) -> None:
    del file["scene"]
    file["scene"] = h5py.ExternalLink("pipe", "/scene")


def soft_link(file: h5py.File) -> None:
    file["a"] = h5py.SoftLink("/bodies/position")


def external_storage(file: h5py.File) -> None:
    del file["time"]
    file.create_dataset("time", (20,), "f8", external=[("pipe", 0, 160)])


def virtual(file: h5py.File) -> None:
    del file["time"]
    layout = h5py.VirtualLayout((20,), "f8", maxshape=(None,))
    layout[:] = h5py.VirtualSource("pipe", "data", shape=(20,), maxshape=(None,))
    file.create_virtual_dataset("time", layout)


@pytest.mark.parametrize(
    ("change", "name", "what"),
    [
        (external_link, "/bodies/mine", "an external link"),
        (external_group, "/scene", "an external link"),
        (soft_link, "/a", "a soft link"),
        (external_storage, "/time", "a dataset in external storage"),
        (virtual, "/time", "a virtual dataset"),
    ],
)
def test_nothing_leads_out_of_the_file(path, monkeypatch, change, name, what):
    """Who opened the pipe would wait for ever."""
    monkeypatch.chdir(path.parent)
    os.mkfifo("pipe")
    assert said(path, change) == (
        f": '{name}' is {what}, which could lead to another file; a results file holds all of its data itself"
    )


def test_a_circle_of_groups_is_walked_once(path):
    with h5py.File(path, "r+") as file:
        file["bodies/again"] = file["/"]
        inner = file.create_group("deep")
        for _ in range(200):
            inner = inner.create_group("deeper")
        inner["up"] = file["deep"]
    with open_results(path) as results:
        assert len(results.time) == 20


def test_what_cannot_be_opened_without_waiting_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(os.path.relpath(tmp_path / "socket"))
    for name, kind in (("pipe", "a named pipe"), ("socket", "a socket"), ("/dev/zero", "a device")):
        with pytest.raises(InputError) as caught:
            open_results(tmp_path / name)
        assert str(caught.value) == (
            f"error: '{tmp_path / name}' is {kind}, not a results file; results are what 'mbproj run SCENE' writes"
        )
    listener.close()


def test_declared_samples_are_held_against_the_file(path):
    def declare(file: h5py.File) -> None:
        for name in PATHS:
            file[name].resize(10**8, axis=0)

    assert said(path, declare) == " is damaged: 'time' declares 800000000 bytes, and the file holds 4100 of them"


def test_a_compression_bomb_is_refused(path):
    def pack(file: h5py.File) -> None:
        for name in PATHS:
            shape, dtype = file[name].shape[1:], file[name].dtype
            del file[name]
            file.create_dataset(name, (10**7, *shape), dtype, chunks=(10**7, *shape), compression="gzip")
        file["time"][:10] = 0.0

    assert "far more than the file has" in said(path, pack)


def test_what_others_packed_is_read(path):
    """As h5repack does it; text and constants stay."""
    with open_results(path) as results:
        whole = [results[name] for name in PATHS]
    with h5py.File(path, "r+") as file:
        for name in PATHS:
            values = file[name][...]
            attributes = dict(file[name].attrs)
            del file[name]
            packed = file.create_dataset(name, data=values, chunks=True, compression="gzip", shuffle=True)
            packed.attrs.update(attributes)
    with open_results(path) as results:
        assert all(np.array_equal(results[name], values) for name, values in zip(PATHS, whole, strict=True))


def replaced(name: str, **made: object):
    """A change that puts another dataset in the place of one."""

    def change(file: h5py.File) -> None:
        if name in file:
            del file[name]
        file.create_dataset(name, **made)

    return change


NOTHING = h5py.Empty("f8")
REFERENCE = h5py.special_dtype(ref=h5py.Reference)


@pytest.mark.parametrize(
    "made",
    some([
        {"data": 1.0}, {"data": np.zeros((20, 2))}, {"data": np.zeros(20, "f4")}, {"data": np.zeros(20, "c16")},
        {"data": NOTHING}, {"shape": (20,), "dtype": REFERENCE}, {"data": ["a"] * 20},
        {"shape": (20,), "dtype": h5py.vlen_dtype(np.float64)}, {"data": np.zeros(20, [("a", "f8"), ("b", "i4")])},
        {"shape": (20,), "dtype": np.dtype((np.float64, (3,)))}, {"data": np.zeros(20, "V8")},
        {"data": np.zeros(20, ">f8")}, {"shape": (2**60,), "dtype": "f4", "chunks": (1,)},
    ], 3),
)  # fmt: skip
def test_samples_of_another_type_or_shape_are_refused(path, made):
    assert said(path, replaced("time", **made)) in (
        " is damaged: 'time' has the wrong shape or type", " is damaged: 'time' cannot be read",
    )  # fmt: skip


def text(name: str, value: object):
    def change(file: h5py.File) -> None:
        del file[name]
        create_text(file, name, value, "")

    return change


@pytest.mark.parametrize(
    ("change", "read", "what"),
    [
        (text("joints/names", ["A", "../../T"]), "title", "'joints/names' has '../../T', which is not one"),
        (text("bodies/names", ["a\x1b[31m"]), "title", "'bodies/names' has 'a\\x1b[31m', which is not one"),
        (text("joints/coordinate_units", ["mm"]), "title", "'joints/coordinate_units' has 'mm', which is not one"),
        (text("joints/coordinate_units", []), "title", "'joints/coordinate_units' has 0 entries for 1 columns"),
        (text("motions/names", ["a", "b"]), "title", "'motions/units' has 1 entries for 2 columns"),
        (replaced("joints/names", data=["A", "B"]), "title", "'joints/names' has the wrong shape or type"),
        (replaced("bodies/names", data=np.array([b"\xff"], "S1")), "title", "'bodies/names' cannot be read"),
        (replaced("scene/gravity", data=[0.0, np.nan, 1.0]), "gravity", "'scene/gravity' is not finite"),
        (replaced("scene/text", data=NOTHING), "scene_text", "'scene/text' cannot be read"),
        (text("scene/path", "a\0b"), "scene_path", "'scene/path' is not a path"),
        (text("scene/overrides", "[" * 100_000), "overrides", "'scene/overrides' is not JSON"),
        (text("scene/overrides", "[1]"), "overrides", "'scene/overrides' is not text by parameter"),
        (text("scene/overrides", '{"a": 1}'), "overrides", "'scene/overrides' is not text by parameter"),
        (text("scene/settings", "[]"), "settings", "'scene/settings' is wrong: it is not a mapping of keys"),
    ],
)
def test_text_and_constants_that_make_no_sense(path, change, read, what):
    assert said(path, change, lambda results: getattr(results, read)) == f" is damaged: {what}"


@pytest.mark.parametrize(
    ("key", "value"),
    some([
        ("duration", -1), ("duration", "nan"), ("duration", 1e999), ("duration", [1]), ("duration", {"a": 1}),
        ("duration", True), ("step", 0), ("step", "x" * 10_000), ("tolerance", 5), ("integrator", "euler"),
        ("integrator", 3), ("formulation", "none"), ("output_step", -0.1), ("colour", "red"), ("acceleration", []),
        ("projection", None), ("projection", 5), ("projection", {"method": "gpopm", "every": 0}),
        ("projection", {"method": "baumgarte", "gains": [1]}), ("projection", {"gains": {"a": 1}}),
        ("projection", {"max_iterations": 1.5}), ("projection", {"test": "hope"}), ("projection", {"method": {}}),
        ("projection", {"alpha": -1}), ("projection", {"x": 1}),
    ], 5),
)  # fmt: skip
def test_settings_that_no_scene_can_have(path, key, value):
    def change(file: h5py.File) -> None:
        values = json.loads(bytes(file["scene/settings"][()]))
        text("scene/settings", json.dumps({**values, key: value}))(file)

    if (key, value) == ("projection", None):
        with h5py.File(path, "r+") as file:
            change(file)
        with open_results(path) as results:
            assert results.settings.projection.method == "gpopm"
    else:
        assert said(path, change, lambda results: results.settings).startswith(
            " is damaged: 'scene/settings' is wrong:"
        )


def test_attributes_of_others_are_left_out(path):
    odd = {"list": [1.0, 2.0], "nothing": NOTHING, "big": "x" * 2_000_000, "a\x1b[31m": 1, "flag": True, "mine": "text"}
    with h5py.File(path, "r+") as file:
        file.attrs.update({name: value for name, value in odd.items() if name != "big"})
        file.attrs.create("reference", file["time"].ref, dtype=REFERENCE)
    with open_results(path) as results:
        assert {"flag": True, "mine": "text"}.items() <= results.attributes.items()
        assert not {"list", "nothing", "a\x1b[31m", "reference", OF_ATTRIBUTES} & results.attributes.keys()


@pytest.mark.parametrize(
    ("name", "value", "what"),
    [
        ("status", 5, " is damaged: it has no status"),
        ("status", b"\xff\xfe", " is damaged: its attributes cannot be read"),
        ("format", 5, " is not a results file of mbproj; results are what 'mbproj run SCENE' writes"),
        ("schema_version", "3", " has schema version 3, and this mbproj reads version 3"),
    ],
)
def test_attributes_of_another_type(path, name, value, what):
    def change(file: h5py.File) -> None:
        del file.attrs[name], file.attrs[OF_ATTRIBUTES]
        file.attrs[name] = np.bytes_(value) if isinstance(value, bytes) else value

    assert said(path, change).startswith(what)


@pytest.mark.parametrize("group", ["trust", "verification"])
def test_groups_that_hold_something_else(path, group):
    for change in (
        replaced(group, data=1.0),
        lambda file: file.create_group(group).attrs.update({"status": "complete"}),
    ):
        with h5py.File(path, "r+") as file:
            if group in file:
                del file[group]
        assert said(path, change, lambda results: getattr(results, group)).startswith(" is damaged: ")


def test_a_checksum_that_is_none(path):
    def change(file: h5py.File) -> None:
        file["time"].attrs[OF_DATA] = "none"

    assert said(path, change, lambda results: results.time) == " is damaged: 'time' cannot be read"


def test_whatever_stands_beside_the_samples_is_tried_in_the_sandbox(path):
    """A property that reads the file is in the list of what a child tries first."""
    from mbproj.results.record import Results

    lazy = {name for name, value in vars(Results).items() if isinstance(value, property)} - {
        "time",
        "status",
        "datasets",
        "event_times",  # of the events
        "abscissa",  # of the times, or of a coordinate
        "scene",  # of its text
    }
    assert lazy == set(BESIDE_SAMPLES)


def test_stamps_are_renewed_by_hand_only(path):
    """Whoever changes an attribute on purpose says so with the checksums."""
    with h5py.File(path, "r+") as file:
        file.attrs["host"] = "elsewhere"
        stamp_attributes(file)
    with open_results(path) as results:
        assert results.attributes["host"] == "elsewhere"


# A flipped bit or a torn page: the reader says so, in bounded time, or what it reads is what was written.

MARKS = {"joints/reaction_force_unique": np.array([[True, False, True], [False, True, True]])}
IN_PLACE = ("scene/text", "scene/settings", "scene/overrides", "scene/gravity", "markers/names", *MARKS)


@pytest.fixture
def whole_file(tmp_path, monkeypatch):
    monkeypatch.setattr(sandbox, "SECONDS", 1)
    return record(tmp_path / "out.h5", block(times(20)), constants=MARKS)


def all_of(path: Path) -> list[object]:
    """Whatever a reader can ask for. InputError where something is wrong."""
    with open_results(path) as results:
        found = check_results(results)
        if found.faults:
            raise InputError("; ".join(found.faults))
        marks = results.constant("joints/reaction_force_unique")
        series = [results[name].tobytes() for name in PATHS]
        names = [results.names(kind) for kind in NAMES]
        scene = [results.title, results.scene_text, results.scene_path, results.overrides, results.settings]
        constant = None if marks is None else marks.tolist()
        return [series, names, scene, results.gravity, dict(results.attributes), constant]


def refused(path: Path, whole: list[object]) -> bool:
    """Whether the reader refuses the file; if it does not, what it reads must be what was written."""
    try:
        found = all_of(path)
    except InputError:
        return True
    assert found == whole
    return False


@pytest.mark.parametrize("seed", some(range(4), 4))
def test_a_flipped_bit_never_passes_as_data(whole_file, seed):
    whole, data, draw = all_of(whole_file), whole_file.read_bytes(), random.Random(seed)
    used = [place for place, byte in enumerate(data) if byte]
    count = 0
    for _ in range(10):
        flipped = bytearray(data)
        flipped[draw.choice(used)] ^= 1 << draw.randrange(8)
        whole_file.write_bytes(flipped)
        count += refused(whole_file, whole)
    assert count > 6


@pytest.mark.parametrize("seed", some(range(3), 3))
def test_torn_pages(whole_file, seed):
    """Zeros in place of pages of 512 B to 64 kB, anywhere in what is used."""
    whole, data, draw = all_of(whole_file), whole_file.read_bytes(), random.Random(seed)
    used = [place for place, byte in enumerate(data) if byte]
    count = 0
    for _ in range(10):
        page = 2 ** draw.randrange(9, 17)
        start = draw.choice(used) // page * page
        whole_file.write_bytes(data[:start] + bytes(len(data[start : start + page])) + data[start + page :])
        count += refused(whole_file, whole)
    assert count > 5


def place_of(path: Path, name: str) -> int:
    """Where a dataset's bytes begin in the file."""
    with h5py.File(path, "r") as file:
        dataset = file[name]
        return dataset.id.get_offset() if dataset.chunks is None else dataset.id.get_chunk_info(0).byte_offset


def change(path: Path, place: int, new: bytes) -> None:
    with path.open("r+b") as file:
        file.seek(place)
        file.write(new)


@pytest.mark.parametrize("name", some(["bodies/position", "diagnostics/steps", "time"], 3))
def test_a_changed_sample_is_refused_where_it_is_read(whole_file, name):
    change(whole_file, place_of(whole_file, name) + 9, b"\x7f")
    with open_results(whole_file) as results:
        with pytest.raises(InputError) as caught:
            results[name]
        assert str(caught.value) == f"error: '{whole_file}' is damaged: '{name}' cannot be read; repeat the run"
        assert check_results(results).faults == (f"'{name}' cannot be read, samples 0 to 19",)


def test_a_chunk_of_zeros_is_refused(whole_file):
    """Fletcher-32 of zeros is zero, so that it takes a chunk that a crash left empty for right."""
    with h5py.File(whole_file, "r") as file:
        size = file["bodies/position"].id.get_chunk_info(0).size
    change(whole_file, place_of(whole_file, "bodies/position"), bytes(size))
    with h5py.File(whole_file, "r") as file:
        assert not file["bodies/position"][...].any()
    with (
        open_results(whole_file) as results,
        pytest.raises(InputError, match="'bodies/position' is not what was written"),
    ):
        results["bodies/position"]


@pytest.mark.parametrize("name", some(IN_PLACE, 3))
def test_changed_text_and_constants_are_refused(whole_file, name):
    place = place_of(whole_file, name)
    change(whole_file, place, bytes([whole_file.read_bytes()[place] ^ 1]))
    with pytest.raises(InputError, match=f"'{name}' is not what was written: its checksum differs"):
        all_of(whole_file)


def test_a_changed_attribute_is_refused(whole_file):
    place = whole_file.read_bytes().rindex(b"complete")
    change(whole_file, place, b"C")
    with pytest.raises(InputError, match="is damaged: its attribute 'status' is not what was written"):
        open_results(whole_file)


def without_checksums(path: Path) -> None:
    """The file as an mbproj before checksums wrote it."""
    with h5py.File(path, "r+") as file:
        del file.attrs[OF_ATTRIBUTES]
        for group in [item for item in file.values() if isinstance(item, h5py.Group)]:
            for shared in {"time", "axis", "euler_parameter"} & set(group):
                if group[shared] == file[shared]:
                    del group[shared]
        names: list[str] = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        for name in names:
            values, attributes, chunks = file[name][...], dict(file[name].attrs), file[name].chunks
            maxshape, dtype = file[name].maxshape, file[name].dtype
            del file[name], attributes[OF_DATA]
            attributes.pop(OF_ATTRIBUTES, None)
            file.create_dataset(name, data=values, dtype=dtype, chunks=chunks, maxshape=maxshape)
            file[name].attrs.update(attributes)


def test_files_without_checksums_are_read(whole_file):
    whole = all_of(whole_file)
    without_checksums(whole_file)
    assert all_of(whole_file) == whole
    with open_results(whole_file) as results:
        found = check_results(results)
    assert found.faults == ()
    assert len(found.unguarded) == found.datasets == len(PATHS) + len(NAMES) + 6 + len(MARKS)


def test_a_sound_file_has_a_checksum_of_everything(whole_file):
    with open_results(whole_file) as results:
        found = check_results(results)
    assert (found.faults, found.unguarded) == ((), ())


def test_other_faults_that_a_check_finds(whole_file):
    with h5py.File(whole_file, "r+") as file:
        file["bodies/velocity"].attrs["units"] = "mm/s"
        del file["bodies/velocity"].attrs[OF_ATTRIBUTES]
        del file["time"].attrs[OF_DATA]
        file["time"][3] = 0.0
    with open_results(whole_file) as results:
        assert set(check_results(results).faults) == {
            "'bodies/velocity' has another unit than 'm/s'",
            "'time' does not ascend",
        }


KILLED = """
    writer.FLUSH_SECONDS = 0.0
    with ResultsWriter(sys.argv[1], scene(), NAMES) as recorder:
        recorder.write(block(times(600)))
        go()
        sys.stdin.readline()
"""


def test_a_killed_run_may_have_left_its_last_chunk_torn(tmp_path):
    """A kill falls between rows of the chunk that grows and its checksum: the rows that were there are right. A chunk
    that is full was written once."""
    process = child(KILLED, str(tmp_path / "out.h5"))
    process.stdout.readline()
    process.kill()
    process.wait()
    part = tmp_path / "out.h5.part"
    with h5py.File(ClosedView(part), "r") as file:
        chunks = [file["bodies/position"].id.get_chunk_info(number) for number in range(2)]
    assert [chunk.chunk_offset[0] for chunk in chunks] == [0, 512]
    change(part, chunks[1].byte_offset + chunks[1].size - 4, b"\0\1\2\3")
    unchecked = "do not have their checksum: the run was killed while it wrote them, or they were changed"
    with open_results(part) as results:
        with pytest.warns(MbprojWarning, match=f"the last samples of 'bodies/position' in '{part}' {unchecked}"):
            assert np.array_equal(results["bodies/position"], block(times(600))["bodies/position"])
        assert np.array_equal(results.select(start=5.5)["bodies/position"], results["bodies/position"][550:])
        assert check_results(results).faults == (f"samples 512 to 599 of 'bodies/position' {unchecked}",)
    change(part, chunks[0].byte_offset + chunks[0].size - 4, b"\0\1\2\3")
    with open_results(part) as results:
        assert "'bodies/position' cannot be read, samples 0 to 511, samples 512 to 599" in check_results(results).faults


@pytest.mark.parametrize(
    ("name", "attribute"),
    [
        ("bodies/position", "frame"),
        ("bodies/position", "description"),
        ("time", "units"),
        ("scene/gravity", "units"),
        ("markers/names", "description"),
        ("joints/reaction_force_unique", "frame"),
    ],
)
def test_a_changed_description_is_found(whole_file, name, attribute):
    """Texts of attributes stand in a heap that HDF5 does not guard."""
    with h5py.File(whole_file, "r+") as file:
        file[name].attrs[attribute] = file[name].attrs[attribute] + "."
    with open_results(whole_file) as results:
        faults = check_results(results).faults
    assert f"'{name}' has an attribute '{attribute}' that is not what was written" in faults
