"""Pictures draw the path on which a wheel touches its plane."""

from __future__ import annotations

import numpy as np

import mbproj
from mbproj.model.euler_parameters import product
from mbproj.show.appearance.mechanism import look_of
from mbproj.show.appearance.motion import PoseHistory
from tests.rolling import scenes


def test_the_path_of_a_contact_is_on_the_plane_and_below_a_wheel():
    """A coin's centre goes round at 1 m, and the coin touches at 1 + R cos θ."""
    scene = mbproj.read_scene_text(scenes.coin())
    turns = np.linspace(0.0, 2.0, 5)
    half, lean = 0.5 * turns, 0.5 * scenes.TILT
    position = [np.cos(turns), np.sin(turns), np.full(5, scenes.RADIUS * np.sin(scenes.TILT))]
    about_z = np.column_stack([np.cos(half), 0 * half, 0 * half, np.sin(half)])
    orientation = product(about_z, np.array([np.cos(lean), 0.0, np.sin(lean), 0.0]))
    motion = PoseHistory(turns, np.column_stack(position)[:, None], orientation[:, None])
    (contact,) = look_of(scene, motion, {}).touching
    far = 1.0 + scenes.RADIUS * np.cos(scenes.TILT)
    expected = np.column_stack([far * np.cos(turns), far * np.sin(turns), 0.0 * turns])
    np.testing.assert_allclose(contact.path(motion), expected, atol=1e-15)
