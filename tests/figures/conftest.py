"""Results of a pendulum to draw: one run, and two to overlay."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbproj.base.settings import ProjectionSettings
from mbproj.results.reader import open_results
from tests.results.pendulum_blocks import SETTINGS, block, record, scene, times


@pytest.fixture
def results(tmp_path):
    with open_results(record(tmp_path / "run.h5")) as opened:
        yield opened


@pytest.fixture
def two(tmp_path, results):
    how = replace(SETTINGS, projection=ProjectionSettings("gopm", tolerance=1e-13))
    path = record(tmp_path / "other.h5", block(times(), drift=-3e-6), scene(settings=how))
    with open_results(path) as opened:
        yield [results, opened]


@pytest.fixture(autouse=True)
def read_without_sandbox(read_here: None) -> None:
    """As the files are none that others have damaged."""
