"""Analyses of results files that the tests write themselves."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def read_without_sandbox(read_here: None) -> None:
    """As the files are none that others have damaged."""
