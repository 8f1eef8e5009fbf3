"""A flipped bit or a torn page: the reader says so, in bounded time, or what it reads is what was written."""

from __future__ import annotations

import random
from pathlib import Path

import h5py
import numpy as np
import pytest

from mbproj.base import sandbox
from mbproj.base.errors import InputError, MbprojWarning
from mbproj.results.check import check_results
from mbproj.results.file.checksums import OF_ATTRIBUTES, OF_DATA
from mbproj.results.file.opening import ClosedView
from mbproj.results.reader import open_results
from tests.crossed import some
from tests.results.pendulum_blocks import NAMES, PATHS, block, record, times
from tests.results.processes import child

MARKS = {"joints/reaction_force_unique": np.array([[True, False, True], [False, True, True]])}
IN_PLACE = ("scene/text", "scene/settings", "scene/overrides", "scene/gravity", "markers/names", *MARKS)


@pytest.fixture
def path(tmp_path, monkeypatch):
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
def test_a_flipped_bit_never_passes_as_data(path, seed):
    whole, data, draw = all_of(path), path.read_bytes(), random.Random(seed)
    used = [place for place, byte in enumerate(data) if byte]
    count = 0
    for _ in range(10):
        flipped = bytearray(data)
        flipped[draw.choice(used)] ^= 1 << draw.randrange(8)
        path.write_bytes(flipped)
        count += refused(path, whole)
    assert count > 6


@pytest.mark.parametrize("seed", some(range(3), 3))
def test_torn_pages(path, seed):
    """Zeros in place of pages of 512 B to 64 kB, anywhere in what is used."""
    whole, data, draw = all_of(path), path.read_bytes(), random.Random(seed)
    used = [place for place, byte in enumerate(data) if byte]
    count = 0
    for _ in range(10):
        page = 2 ** draw.randrange(9, 17)
        start = draw.choice(used) // page * page
        path.write_bytes(data[:start] + bytes(len(data[start : start + page])) + data[start + page :])
        count += refused(path, whole)
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
def test_a_changed_sample_is_refused_where_it_is_read(path, name):
    change(path, place_of(path, name) + 9, b"\x7f")
    with open_results(path) as results:
        with pytest.raises(InputError) as caught:
            results[name]
        assert str(caught.value) == f"error: '{path}' is damaged: '{name}' cannot be read; repeat the run"
        assert check_results(results).faults == (f"'{name}' cannot be read, samples 0 to 19",)


def test_a_chunk_of_zeros_is_refused(path):
    """Fletcher-32 of zeros is zero, so that it takes a chunk that a crash left empty for right."""
    with h5py.File(path, "r") as file:
        size = file["bodies/position"].id.get_chunk_info(0).size
    change(path, place_of(path, "bodies/position"), bytes(size))
    with h5py.File(path, "r") as file:
        assert not file["bodies/position"][...].any()
    with open_results(path) as results, pytest.raises(InputError, match="'bodies/position' is not what was written"):
        results["bodies/position"]


@pytest.mark.parametrize("name", some(IN_PLACE, 3))
def test_changed_text_and_constants_are_refused(path, name):
    place = place_of(path, name)
    change(path, place, bytes([path.read_bytes()[place] ^ 1]))
    with pytest.raises(InputError, match=f"'{name}' is not what was written: its checksum differs"):
        all_of(path)


def test_a_changed_attribute_is_refused(path):
    place = path.read_bytes().rindex(b"complete")
    change(path, place, b"C")
    with pytest.raises(InputError, match="is damaged: its attribute 'status' is not what was written"):
        open_results(path)


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


def test_files_without_checksums_are_read(path):
    whole = all_of(path)
    without_checksums(path)
    assert all_of(path) == whole
    with open_results(path) as results:
        found = check_results(results)
    assert found.faults == ()
    assert len(found.unguarded) == found.datasets == len(PATHS) + len(NAMES) + 6 + len(MARKS)


def test_a_sound_file_has_a_checksum_of_everything(path):
    with open_results(path) as results:
        found = check_results(results)
    assert (found.faults, found.unguarded) == ((), ())


def test_other_faults_that_a_check_finds(path):
    with h5py.File(path, "r+") as file:
        file["bodies/velocity"].attrs["units"] = "mm/s"
        del file["bodies/velocity"].attrs[OF_ATTRIBUTES]
        del file["time"].attrs[OF_DATA]
        file["time"][3] = 0.0
    with open_results(path) as results:
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
def test_a_changed_description_is_found(path, name, attribute):
    """Texts of attributes stand in a heap that HDF5 does not guard."""
    with h5py.File(path, "r+") as file:
        file[name].attrs[attribute] = file[name].attrs[attribute] + "."
    with open_results(path) as results:
        faults = check_results(results).faults
    assert f"'{name}' has an attribute '{attribute}' that is not what was written" in faults
