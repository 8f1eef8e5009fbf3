"""Dimension scales: every axis of an array has its names, for HDF5's own calls and for xarray."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

import mbproj
from mbproj.results.layout import ALL_NAMES
from tests.support import ROOT


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
