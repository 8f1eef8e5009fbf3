"""Before NumPy loads: one BLAS thread a worker. The matrices are small, and workers that share cores only get in each
other's way; the command line does the same."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

#: Tests that do not hold yet everywhere, by name: to be settled and taken off this list.
UNFINISHED = frozenset((Path(__file__).parent / "unfinished.txt").read_text(encoding="utf-8").split())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.nodeid.split("[")[0] in UNFINISHED:
            item.add_marker(pytest.mark.xfail(reason="listed in tests/unfinished.txt", strict=False))
