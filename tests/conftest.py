"""One BLAS thread a worker, the two runs, the order of the tests, and sweeps and reading without other processes."""

from __future__ import annotations

import os
from collections.abc import Mapping

import pytest
from hypothesis import settings

# Before NumPy loads. The matrices are small, and workers that share cores only get in each other's way; the command
# line does the same.
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


# How long an example takes depends on what else the machine does.
settings.register_profile("without the clock", deadline=None)
settings.load_profile("without the clock")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A test not marked `full` is in both runs: `-m full` is everything, and `-m "not default"` what the default lacks.

    Tests that take long go first: at the end, the other processes would wait for them.
    """
    for item in items:
        if any(_has(item, mark.kwargs) for mark in item.iter_markers("full_where")):
            item.add_marker("full")
        if item.get_closest_marker("full") is None:
            item.add_marker("default")
            item.add_marker("full")
    items.sort(key=lambda item: item.get_closest_marker("long") is None)


def _has(item: pytest.Item, values: Mapping[str, object]) -> bool:
    """Whether the test is a case with one of these values."""
    return any(item.callspec.params[name] == value for name, value in values.items())


@pytest.fixture
def sweeps_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps run their cases in the test's own process: the start of another takes longer than most sweeps of tests."""
    from tests.cli.fork_server import in_this_process  # not before the variables are set

    monkeypatch.setattr("mbproj.studies.parallel.hand_out.in_parallel", in_this_process)


@pytest.fixture
def read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Results files are read in the test's own process alone: none is damaged, and a child would read each first."""
    for reader in ("results.output_files", "results.file.opening", "results.check"):
        monkeypatch.setattr(f"mbproj.{reader}.try_in_sandbox", lambda *_: True)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are composed, and a blank one is saved in place of each: to lay it out takes longer than most commands.
    `tests/figures` draws each kind."""
    from matplotlib.figure import Figure

    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda _, file, **options: save(Figure((1, 1)), file, **options))
