"""The data of a page of modes: the linearised pose, and the shape of each mode about it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.errors import InputError, Problem
from mbproj.model.euler_parameters import product
from mbproj.pages.appearance.mechanism import look_of
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.appearance.view import view_of
from mbproj.pages.data.frames import THINNED
from mbproj.pages.data.packing import Packer
from mbproj.pages.data.page_data import look_data, motion_data, view_data
from mbproj.pages.data.pages import PageData
from mbproj.results.linear.modes_file import StoredModes, read_modes
from mbproj.results.linear.parts import scene_of_modes

#: The initial amplitude of a page: a part of the mechanism's size, and of 1 rad.
AMPLITUDE = 0.15
#: The binary digits of shapes, whose largest number is 1.
DIGITS = 20
#: The number of modes for whose largest swing the first view has room.
IN_VIEW = 30
LARGER = "shapes are drawn larger than small motions are: joints seem to open"


def page_of_modes(path: Path, label: str) -> PageData:
    """The page of a file of modes. Raises InputError where the file has no mode."""
    modes = read_modes(path)
    if not len(modes.eigenvalue):
        raise InputError(Problem(f"'{path}' has no mode to show", hint="its mechanism has no degree of freedom"))
    scene, meshes = scene_of_modes(path, modes.bodies)
    pose = PoseHistory(np.zeros(1), modes.position[None], modes.orientation[None])
    size = look_of(scene, pose, meshes).size
    count = min(len(modes.eigenvalue), max(1, THINNED // (12 * max(len(modes.bodies), 1))))
    scales, shapes = unit_shapes(modes.displacement[:count], size)
    swings = swing_ends(modes, shapes[:IN_VIEW], size)
    look = look_of(scene, swings, meshes)
    packer = Packer()
    turning = np.array([1.0 if unit == "rad" else size for unit in modes.coordinate_units])
    along = _turning_on(modes, modes.coordinate_shape[:count]) / scales[:, None]
    shown = {
        "size": size,
        "amplitude": AMPLITUDE,
        "list": [{"name": modes.names[mode], "words": words_on(modes, mode)} for mode in range(count)],
        "shape": packer.add(_halves(_turning_on(modes, shapes).reshape(count, -1)), 2.0**-DIGITS),
        "coordinates": list(modes.coordinates),
        "units": list(modes.coordinate_units),
        "along": packer.add(_halves(along), np.tile(turning * 2.0**-DIGITS, 2)),
    }
    left = len(modes.eigenvalue) - count
    remarks = [*modes.notes.splitlines(), LARGER, f"no room for the {left} fastest modes" if left else ""]
    run = {
        "label": label,
        "look": look_data(look, packer),
        **motion_data(pose, look.size, packer),
        "groups": [],
        "events": [],
        "trust": None,
        "remarks": [remark for remark in remarks if remark],
        "blocks": packer.blocks,
    }
    rest = {**run, "label": "the pose", "ghost": True, "remarks": []}
    title = modes.title or label
    data = {"title": title, "view": view_data(view_of(scene, swings, look)), "runs": [{**run, "modes": shown}, rest]}
    return PageData(title, data, packer)


def words_on(modes: StoredModes, mode: int) -> str:
    """The motion of a mode in words."""
    value, damping = modes.eigenvalue[mode], modes.damping_ratio[mode]
    if value == 0.0:
        return "neutral: nothing drives it back"
    grows = value.real > 0.0
    constant = f"by e in {1.0 / abs(value.real):.4g} s" if value.real != 0.0 else ""
    if value.imag == 0.0:
        return f"does not oscillate: it {'grows' if grows else 'falls'} {constant}"
    rings = f"{modes.frequency[mode]:.4g} Hz, damping ratio {damping:.3g}"
    return f"{rings}: it grows {constant}" if grows else rings


def unit_shapes(displacement: Numbers, size: float) -> tuple[Array, Numbers]:
    """The scale of each mode (k, n, 6), and its shape divided by the scale. Then the largest displacement is `size`, or
    the largest rotation 1 rad."""
    parts = displacement / np.array([size] * 3 + [1.0] * 3)
    largest = np.linalg.norm(parts.reshape(*parts.shape[:2], 2, 3), axis=-1).max(axis=(1, 2), initial=0.0)
    scales = np.where(largest > 0.0, largest, 1.0)
    return scales, parts / scales[:, None, None]


def swing_ends(modes: StoredModes, shapes: Numbers, size: float) -> PoseHistory:
    """The pose, then the two ends of each swing at the initial amplitude, for the real and the imaginary part of each
    shape."""
    parts = AMPLITUDE * np.concatenate([sign * half for half in (shapes.real, shapes.imag) for sign in (1.0, -1.0)])
    parts = np.concatenate([np.zeros((1, *parts.shape[1:])), parts])
    angle = np.linalg.norm(parts[..., 3:], axis=-1, keepdims=True)
    axis = parts[..., 3:] / np.where(angle > 0.0, angle, 1.0)
    turn = np.concatenate([np.cos(0.5 * angle), np.sin(0.5 * angle) * axis], axis=-1)
    return PoseHistory(np.zeros(len(parts)), modes.position + size * parts[..., :3], product(turn, modes.orientation))


def _turning_on(modes: StoredModes, shapes: Numbers) -> Numbers:
    """Shapes (k, ..), conjugated where needed, so that their motion is Re(shape · exp(iφ)) with a growing phase φ."""
    back = modes.eigenvalue[: len(shapes)].imag < 0.0
    return np.where(back.reshape(-1, *[1] * (shapes.ndim - 1)), shapes.conj(), shapes)


def _halves(values: Numbers) -> Array:
    return np.concatenate([values.real, values.imag], axis=1)
