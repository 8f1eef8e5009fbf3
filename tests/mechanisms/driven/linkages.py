"""Planar linkages in the x-z plane whose joints close by circles: points in closed form, and scenes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from tests.support import Recorder

#: Samples in a turn.
SAMPLES = 720


def crossing(p, q, from_p, from_q, side):
    """Where circles about points p and q (complex) cross: to the left of p → q for side 1, to the right for -1."""
    way = q - p
    distance = np.abs(way)
    along = (distance**2 + from_p**2 - from_q**2) / (2.0 * distance)
    return p + way / distance * (along + 1j * side * np.sqrt(from_p**2 - along**2))


def derivatives(values):
    """First and second derivatives by the angle of a function at equal steps of a turn, by its Fourier series."""
    order = np.fft.fftfreq(len(values), 1.0 / len(values))
    order[np.abs(order) == len(values) / 2] = 0.0
    series = np.fft.fft(values)
    first, second = np.fft.ifft(1j * order * series), np.fft.ifft(-(order**2) * series)
    return (first, second) if np.iscomplexobj(values) else (first.real, second.real)


def place(z: complex) -> str:
    """A point as a scene has it."""
    return f"[{float(z.real)!r}, 0, {float(z.imag)!r}]"


def pin(bodies: str, at: complex) -> str:
    """A revolute joint whose angle grows as that of the plane does."""
    return f"{{type: revolute, bodies: [{bodies}], location: {place(at)}, axis: [0, -1, 0]}}"


def block(name: str, entries: Mapping[str, str]) -> str:
    """A block of a scene."""
    return f"{name}:\n" + "".join(f"  {key}: {text}\n" for key, text in entries.items())


def run(text: str, **options):
    """(the system, what was recorded, the report) of a scene's text with these settings."""
    scene = read_scene_text(text, simulation=options)
    system, recorder = compile_system(scene), Recorder()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    assert report.kinematic
    return system, recorder, report
