"""Runs side by side, four at once in packs: each has the bits of the same run by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbproj.integrate.formulations.choice import choose
from mbproj.kernel import core
from mbproj.scene import read_scene
from mbproj.scene.records import ProjectionSettings, Scene, Settings
from tests.kernel.scenes import assembled, loops, needs_kernel, star, tree
from tests.support import MECHANISMS, random_chain

pytestmark = needs_kernel
MOST, FOREVER = 2**31, 1e9
DOP853 = {"integrator": "dop853", "tolerance": 1e-8, "output_step": 0.013}
RK4 = {"integrator": "rk4", "step": 0.005, "output_step": 0.02}
PEAKS = ("position_peak", "joint_peak", "velocity_peak")


def run_of(scene: Scene, projection: str = "gpopm", **keys: Any) -> Any:
    """A run of the kernel that has not begun."""
    system, state = assembled(scene)
    settings = Settings(projection=ProjectionSettings(method=projection), **keys)
    compiled = choose(system, state, settings).compiled
    assert compiled is not None
    return compiled.run(state, settings)


def side_by_side(runs: Sequence[Any]) -> Any:
    return core().together(list(runs), FOREVER, lambda: None)


def alike(scene: Scene, count: int, seed: int = 0) -> list[Scene]:
    """Scenes that differ in masses, in moments of inertia, in speeds and in gravity."""
    rng = np.random.default_rng(seed)

    def body(given: Any) -> Any:
        heavier, faster = rng.uniform(0.8, 1.25, size=2)
        inertia = np.asarray(given.inertia, dtype=float) * heavier
        return replace(
            given,
            mass=given.mass * heavier,
            inertia=tuple(map(tuple, inertia)) if inertia.ndim == 2 else tuple(inertia),
            angular_velocity=tuple(faster * np.asarray(given.angular_velocity, dtype=float)),
        )

    return [
        replace(
            scene,
            bodies=tuple(body(each) for each in scene.bodies),
            gravity=tuple(rng.uniform(0.9, 1.1) * np.asarray(scene.gravity, dtype=float)),
        )
        for _ in range(count)
    ]


def assert_alike(runs: Sequence[Any], others: Sequence[Any]) -> int:
    """That runs side by side are those of the others, each by itself; how many packs have made."""
    together = side_by_side(runs)
    for run, samples, other in zip(runs, together, others, strict=True):
        if samples is None:
            continue
        alone = other.advance(MOST, FOREVER)
        assert run.outcome.status == other.outcome.status == core().Status.finished
        assert samples.keys() == alone.keys()
        for name, found in samples.items():
            np.testing.assert_array_equal(found, alone[name], name)
        np.testing.assert_array_equal(run.counters, other.counters)
        np.testing.assert_array_equal(run.standing["y"], other.standing["y"])
        assert run.standing["t"] == other.standing["t"] and run.standing["turns"] == other.standing["turns"]
        for peak in PEAKS:
            one, two = getattr(run, peak), getattr(other, peak)
            assert (one.value, one.row, one.time) == (two.value, two.row, two.time)
    return sum(samples is not None for samples in together)


def made_alike(scenes: Sequence[Scene], **keys: Any) -> int:
    return assert_alike(*([run_of(scene, **keys) for scene in scenes] for _ in range(2)))


@pytest.mark.parametrize("projection", ["gpopm", "gopm"])
@pytest.mark.parametrize("keys", [DOP853, RK4], ids=["dop853", "rk4"])
@pytest.mark.parametrize("name", ["five_bar", "planar_four_bar", "spatial_slider_crank", "double_pendulum"])
def test_shipped_mechanisms_have_the_bits_of_runs_by_themselves(name, keys, projection):
    scene = read_scene(next(path for path in MECHANISMS if path.stem == name))
    made = made_alike(alike(scene, 9), projection=projection, duration=0.5, **keys)
    assert made >= 7  # two slider-cranks look for rows near dependent on their way with fixed steps


SHAPES = {
    **{f"tree {seed}": lambda seed=seed: tree(seed) for seed in range(3)},
    **{f"loops {seed}": lambda seed=seed: loops(seed) for seed in range(3)},
    **{f"star {seed}": lambda seed=seed: star(seed) for seed in range(2)},
    "chain": lambda: random_chain(7, ["revolute", "universal", "spherical", "cylindrical"]),
}


@pytest.mark.parametrize("keys", [DOP853, RK4], ids=["dop853", "rk4"])
@pytest.mark.parametrize("shape", SHAPES)
def test_random_mechanisms_have_the_bits_of_runs_by_themselves(shape, keys):
    assert made_alike(alike(SHAPES[shape](), 6, seed=1), duration=0.1, **keys) >= 3


def test_lengths_and_ends_differ_from_case_to_case():
    """A pack holds lengths, tolerances and ends of its own in each lane; lanes that have ended take the next cases."""
    path = next(path for path in MECHANISMS if path.stem == "five_bar")
    rng = np.random.default_rng(3)
    made = [
        (read_scene(path, {"length": length}), {**DOP853, "duration": duration, "tolerance": tolerance})
        for length, duration, tolerance in zip(
            rng.uniform(0.3, 3.0, 11), rng.uniform(0.05, 0.4, 11), 10.0 ** rng.uniform(-10, -5, 11), strict=True
        )
    ]
    pairs = [[run_of(scene, **keys) for scene, keys in made] for _ in range(2)]
    assert assert_alike(*pairs) == len(made)


def test_what_packs_do_not_make_runs_by_itself():
    """Another signature, another method, forces, a run that has begun: None, and the run goes on as it would have."""
    paths = {path.stem: path for path in MECHANISMS}
    keys = {**RK4, "duration": 0.1}
    five_bar, sprung = read_scene(paths["five_bar"]), read_scene(paths["quarter_car"])
    begun = run_of(five_bar, **keys)
    begun.advance(1, FOREVER)
    runs = [run_of(five_bar, **keys), run_of(five_bar, **{**keys, "integrator": "heun2"}), begun]
    packed = side_by_side(runs)
    assert [samples is None for samples in packed] == [False, True, True]
    for run in runs[1:]:
        assert run.outcome.status == core().Status.running
        run.advance(MOST, FOREVER)
        assert run.outcome.status == core().Status.finished
    alone = run_of(sprung, **keys)
    assert side_by_side([alone]) == [None]


def test_a_look_that_raises_leaves_the_runs_as_they_were():
    scene = read_scene(next(path for path in MECHANISMS if path.stem == "five_bar"))
    runs, others = ([run_of(scene, **RK4, duration=2.0) for _ in range(5)] for _ in range(2))

    def raising() -> None:
        raise TimeoutError

    with pytest.raises(TimeoutError):
        core().together(runs, 0.0, raising)
    assert assert_alike(runs, others) == 5
