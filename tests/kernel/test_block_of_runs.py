"""Runs of a block advance in one call, each with the bits of the same run by itself, in whatever parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.kernel import core
from mbproj.motion.formulations.choice import choose
from mbproj.scene.scene import read_scene, read_scene_text
from tests.crossed import crossed
from tests.kernel.scenes import assembled, needs_kernel
from tests.support import MECHANISMS

pytestmark = needs_kernel
MOST, FOREVER = 2**31, 1e9
DOP853 = {"integrator": "dop853", "tolerance": 1e-8, "output_step": 0.013}
RK4 = {"integrator": "rk4", "step": 0.005, "output_step": 0.02}
RADAU = {"integrator": "radau5", "tolerance": 1e-6, "output_step": 0.05}


def run_of(scene: Scene, duration: float = 0.3, **keys: Any) -> Any:
    """A run of the kernel that has not begun."""
    system, state = assembled(scene)
    settings = Settings(projection=ProjectionSettings(method="gpopm"), duration=duration, **keys)
    compiled = choose(system, state, settings).compiled
    assert compiled is not None
    return compiled.run(state, settings)


def alike(name: str, count: int) -> list[Scene]:
    """A shipped mechanism under different gravity."""
    scene = read_scene(next(path for path in MECHANISMS if path.stem == name))
    return [replace(scene, gravity=tuple(g * factor for g in scene.gravity)) for factor in np.linspace(0.9, 1.1, count)]


def advanced(runs: Sequence[Any], most: int, seconds: float) -> tuple[list[list[Any]], int]:
    """The samples of each run in parts, and the number of calls."""
    running, parts, calls = core().Status.running, [[] for _ in runs], 0
    while any(run.outcome.status == running for run in runs):
        for own, part in zip(parts, core().advance_runs(list(runs), most, seconds), strict=True):
            own.append(part)
        calls += 1
        assert calls < 100_000
    return parts, calls


def assert_one_motion(run: Any, parts: Sequence[Any], other: Any) -> None:
    """The run, whose samples are in parts, is the other, which has not begun."""
    for name, expected in other.advance(MOST, FOREVER).items():
        np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), expected, name)
    assert run.outcome.status == other.outcome.status
    np.testing.assert_array_equal(run.counters, other.counters)
    np.testing.assert_array_equal(run.standing["y"], other.standing["y"])
    assert run.standing["t"] == other.standing["t"] and run.standing["turns"] == other.standing["turns"]


@crossed(
    "name, keys, most, seconds",
    ["five_bar", "spatial_slider_crank"],
    [pytest.param(DOP853, id="dop853"), pytest.param(RK4, id="rk4"), pytest.param(RADAU, id="radau5")],
    [pytest.param(*each) for each in ((MOST, FOREVER), (1, FOREVER), (3, FOREVER), (MOST, 1e-6), (2, 1e-6))],
    together=1,
)
def test_runs_of_a_block_have_the_bits_of_single_ones(name, keys, most, seconds):
    scenes = alike(name, 4)
    runs = [run_of(scene, **keys) for scene in scenes]
    parts, calls = advanced(runs, most, seconds)
    assert (calls == 1) == (most == MOST and seconds == FOREVER)
    for run, own, scene in zip(runs, parts, scenes, strict=True):
        assert run.outcome.status == core().Status.finished
        assert_one_motion(run, own, run_of(scene, **keys))


FAILING = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.3}
bodies:
  bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  f: {type: force, body: bar, force: [sqrt(END - t), 0, 0]}
"""


@crossed("failing, most, seconds", [0, 2, 4], [pytest.param(MOST, FOREVER), pytest.param(2, 1e-6)], together=1)
def test_a_run_that_fails_does_not_touch_the_others(failing, most, seconds):
    """Its force is the root of a negative number from 0.1 s on; it has the samples of before."""
    ends = [1.0 + each / 8.0 for each in range(5)]
    ends[failing] = 0.1
    scenes = [read_scene_text(FAILING.replace("END", repr(end))) for end in ends]
    runs = [run_of(scene, **RK4) for scene in scenes]
    parts, _ = advanced(runs, most, seconds)
    finished = core().Status.finished
    assert [run.outcome.status == finished for run in runs] == [number != failing for number in range(5)]
    assert np.concatenate([part["t"] for part in parts[failing]])[-1] == pytest.approx(0.08, abs=0.021)
    for run, own, scene in zip(runs, parts, scenes, strict=True):
        assert_one_motion(run, own, run_of(scene, **RK4))


def test_what_is_no_run_is_refused():
    with pytest.raises((TypeError, ValueError)):
        core().advance_runs([run_of(alike("five_bar", 1)[0], **RK4), None], MOST, FOREVER)
