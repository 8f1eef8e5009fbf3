"""A results file may come from anybody: whatever it declares or leads to, the reader reads it or refuses it."""

from __future__ import annotations

import json
import os
import socket

import h5py
import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.results.file.checksums import OF_ATTRIBUTES, OF_DATA, create_text, stamp_attributes
from mbproj.results.reader import BESIDE_SAMPLES, open_results
from tests.crossed import some
from tests.results.pendulum_blocks import PATHS, block, record, times


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
    }
    assert lazy == set(BESIDE_SAMPLES)


def test_stamps_are_renewed_by_hand_only(path):
    """Whoever changes an attribute on purpose says so with the checksums."""
    with h5py.File(path, "r+") as file:
        file.attrs["host"] = "elsewhere"
        stamp_attributes(file)
    with open_results(path) as results:
        assert results.attributes["host"] == "elsewhere"
