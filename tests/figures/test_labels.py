"""A legend says what the overlaid runs differ in."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace

import pytest

from mbproj.base.settings import ProjectionSettings
from mbproj.results.reader import open_results
from mbproj.show.figures.rows import derive_labels
from tests.results.pendulum_blocks import SETTINGS, block, record, scene, times

GOPM = replace(SETTINGS, projection=ProjectionSettings("gopm", tolerance=1e-13))
BAUMGARTE = replace(SETTINGS, projection=ProjectionSettings("baumgarte", tolerance=1e-13, gains=(25.0, 25.0)))


@pytest.mark.parametrize(
    ("scenes", "labels"),
    [
        ([{}, {"settings": GOPM}, {"settings": BAUMGARTE}], ["gpopm", "gopm", "baumgarte"]),
        ([{}, {"settings": replace(SETTINGS, step=0.005)}], ["h = 0.01 s", "h = 0.005 s"]),
        ([{}, {"settings": replace(GOPM, step=0.005)}], ["gpopm, h = 0.01 s", "gopm, h = 0.005 s"]),
        (
            [{"settings": replace(SETTINGS, integrator="dop853", step=None, tolerance=1e-9)}, {}],
            ["tolerance 1e-09, dop853", "h = 0.01 s, rk4"],
        ),
        ([{}, {"settings": replace(SETTINGS, duration=5.0)}], ["duration 2", "duration 5"]),
        ([{"overrides": {"mass": "2"}}, {"overrides": {"mass": "3"}}], ["mass = 2", "mass = 3"]),
        ([{}, {}], ["run0", "run1"]),
        ([{}, {"settings": GOPM}, {}], ["run0: gpopm", "run1: gopm", "run2: gpopm"]),
        ([{}, {"title": "another", "settings": GOPM}], ["run0: gpopm", "run1: gopm"]),
        ([{}], ["run0"]),
    ],
)
def test_labels(tmp_path, scenes, labels):
    with ExitStack() as stack:
        opened = [
            stack.enter_context(open_results(record(tmp_path / f"run{i}.h5", block(times(3)), scene(**changes))))
            for i, changes in enumerate(scenes)
        ]
        assert derive_labels(opened) == labels


def test_the_same_run_in_two_directories(tmp_path):
    paths = [tmp_path / name / "results.h5" for name in "ab"]
    for path in paths:
        path.parent.mkdir()
        record(path, block(times(3)))
    with open_results(paths[0]) as first, open_results(paths[1]) as second:
        assert derive_labels([first, second]) == [str(path) for path in paths]
