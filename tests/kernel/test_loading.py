"""Which extension is used, and that mbproj does without one."""

from __future__ import annotations

import importlib.machinery
import os
import platform
import subprocess
import sys
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

from mbproj import kernel
from tests.kernel.scenes import needs_kernel
from tests.support import ROOT

ON_LINUX = platform.machine() == "x86_64" and Path("/proc/cpuinfo").exists()

NAMES = ("mbproj.kernel._core", "mbproj.kernel._core_v3")


@pytest.fixture
def fresh(monkeypatch):
    """Forgets what was loaded, before and after; the extensions themselves are left alone."""
    for name in NAMES:
        monkeypatch.delitem(sys.modules, name, raising=False)
    kernel._chosen.cache_clear()
    yield monkeypatch
    kernel._chosen.cache_clear()


class Broken:
    """Finds, for a name of ours, a file that is no extension."""

    def __init__(self, path: Path, *names: str) -> None:
        path.write_bytes(b"no shared library at all")
        self.path, self.names = path, names

    def find_spec(self, name, path=None, target=None):
        return spec_from_file_location(name, self.path) if name in self.names else None


def stand_in(*, runs_v3: bool) -> ModuleType:
    """For an extension: what the choice asks of it."""
    module = ModuleType("stand_in")
    module.runs_v3 = lambda: runs_v3
    return module


def broken(folder: Path, *names: str) -> Broken:
    return Broken(folder / f"broken{importlib.machinery.EXTENSION_SUFFIXES[0]}", *names)


def test_without_an_extension_there_is_no_core_and_a_reason(fresh):
    fresh.setitem(sys.modules, NAMES[0], None)
    assert kernel.core() is None
    assert kernel.build_info() == "not built"


def test_an_extension_that_does_not_load_is_a_reason_and_no_error(fresh, tmp_path):
    fresh.setattr(sys, "meta_path", [broken(tmp_path, *NAMES), *sys.meta_path])
    assert kernel.core() is None
    reason = kernel.build_info()
    assert reason.startswith("failed to import: ")
    assert str(tmp_path) in reason


@pytest.mark.parametrize("runs_v3", [False, True])
def test_the_processor_decides_which_of_two_builds_is_used(fresh, runs_v3):
    baseline, faster = stand_in(runs_v3=runs_v3), stand_in(runs_v3=runs_v3)
    for name, module in zip(NAMES, (baseline, faster), strict=True):
        fresh.setitem(sys.modules, name, module)
    assert kernel.core() is (faster if runs_v3 else baseline)


def test_a_broken_faster_build_leaves_the_baseline(fresh, tmp_path):
    baseline = stand_in(runs_v3=True)
    fresh.setitem(sys.modules, NAMES[0], baseline)
    fresh.setattr(sys, "meta_path", [broken(tmp_path, NAMES[1]), *sys.meta_path])
    assert kernel.core() is baseline


@needs_kernel
@pytest.mark.skipif(not ON_LINUX, reason="x86-64 and Linux only")
def test_the_real_choice_agrees_with_the_system_about_the_processor():
    flags = next(line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("flags")).split()
    capable = {"avx2", "fma"} <= set(flags)
    assert ("AVX" in kernel.build_info()["instruction_set"]) == capable


def test_importing_the_package_loads_nothing():
    code = "import sys, mbproj.kernel; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert not {"numpy", *NAMES} & set(done.stdout.split())


def asks_for_a_kernel() -> bool:
    """As the installation reads it, see pyproject.toml."""
    return os.environ.get("MBPROJ_KERNEL", "").lower() in ("1", "yes", "on", "true")


@pytest.mark.skipif(not asks_for_a_kernel(), reason="MBPROJ_KERNEL does not ask for a kernel")
def test_a_kernel_that_the_environment_asks_for_is_there():
    assert kernel.core() is not None, kernel.build_info()
