"""`modes.h5`: what stands in it is what was found, and what is wrong with a file is said."""

from __future__ import annotations

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
from tests.linear.closed_forms import HEAD, modes_of

#: A pendulum of two bodies that a fixed joint makes one, so that bodies and carriers differ.
MERGED = (
    HEAD
    + """\
bodies:
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, -0.5], orientation: {axis: [0, 1, 0], angle: 90 deg}}
  bob: {mass: 2, inertia: [0.2, 0.2, 0.2], position: [0.1, 0, -1], orientation: {axis: [1, 2, 0], angle: 50 deg}}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
  weld: {type: fixed, bodies: [rod, bob], location: [0, 0, -1]}
"""
)


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
