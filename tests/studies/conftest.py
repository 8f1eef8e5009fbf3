"""What tests of studies share: references are kept with the test's own files."""

from __future__ import annotations

import pytest

from mbproj.scene.scene import read_scene
from mbproj.studies.measure.solve import Mechanism
from tests.support import ROOT


@pytest.fixture(autouse=True)
def _own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def pendulum() -> Mechanism:
    return Mechanism.of(read_scene(ROOT / "mechanisms" / "physical_pendulum.yaml"))


@pytest.fixture
def slider_crank() -> Mechanism:
    return Mechanism.of(read_scene(ROOT / "mechanisms" / "spatial_slider_crank.yaml"))
