"""Runs of the five-bar to show."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mbproj import Scene, assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.results.writer import ResultsWriter
from tests.support import ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
#: A scene whose title is markup.
HOSTILE = """\
mbproj: 1
title: "</script><script>alert(1)</script> <!-- & \\u2028 ü"
gravity: [0, 0, -9.8]
simulation: {duration: 0.1, step: 0.01}
bodies: {bob: {mass: 1, inertia: [1, 1, 1], position: [0, 0, -1]}}
joints: {pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}}
"""


def recorded(scene: Scene, path: Path) -> Path:
    """The results of a scene, in a file."""
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    with ResultsWriter(path, scene, system.names.as_mapping()) as writer:
        simulate(system, state, settings_to_run(scene), writer)
    return path


def five_bar(path: Path, **simulation: Any) -> Path:
    """The results of the five-bar with these changes of its settings."""
    return recorded(read_scene(FIVE_BAR, simulation=simulation), path)
