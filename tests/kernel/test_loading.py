"""How the extension is loaded, and that mbproj does without one."""

from __future__ import annotations

import importlib.machinery
import os
import platform
import subprocess
import sys
from importlib.util import spec_from_file_location
from pathlib import Path

import pytest

from mbproj import kernel
from tests.kernel.scenes import needs_kernel
from tests.support import ROOT

ON_LINUX = platform.machine() == "x86_64" and Path("/proc/cpuinfo").exists()

NAME = "mbproj.kernel._core"


@pytest.fixture
def fresh(monkeypatch):
    """Forgets what was loaded, before and after; the extension itself is left alone."""
    monkeypatch.delitem(sys.modules, NAME, raising=False)
    kernel._loaded.cache_clear()
    yield monkeypatch
    kernel._loaded.cache_clear()


class Broken:
    """Finds, for a name of ours, a file that is no extension."""

    def __init__(self, path: Path, *names: str) -> None:
        path.write_bytes(b"no shared library at all")
        self.path, self.names = path, names

    def find_spec(self, name, path=None, target=None):
        return spec_from_file_location(name, self.path) if name in self.names else None


def broken(folder: Path, *names: str) -> Broken:
    return Broken(folder / f"broken{importlib.machinery.EXTENSION_SUFFIXES[0]}", *names)


def test_without_an_extension_there_is_no_core_and_a_reason(fresh):
    fresh.setitem(sys.modules, NAME, None)
    assert kernel.core() is None
    assert kernel.build_info() == "not built"


def test_an_extension_that_does_not_load_is_a_reason_and_no_error(fresh, tmp_path):
    fresh.setattr(sys, "meta_path", [broken(tmp_path, NAME), *sys.meta_path])
    assert kernel.core() is None
    reason = kernel.build_info()
    assert reason.startswith("failed to import: ")
    assert str(tmp_path) in reason


def processor_flags() -> set[str]:
    """What Linux says that this processor has."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    return set(next(line for line in lines if line.startswith("flags")).split())


@needs_kernel
@pytest.mark.skipif(not ON_LINUX, reason="x86-64 and Linux only")
def test_it_uses_what_this_processor_has_unless_it_is_portable():
    """The build for AVX2 and FMA loads where both are there; where it does not, the message says what to do."""
    flags = processor_flags()
    if "AVX2" in kernel.build_info()["instruction_set"]:
        assert {"avx2", "fma"} <= flags
        assert "-mavx2 -mfma" in kernel.build_info()["flags"]
    else:
        assert "avx" not in kernel.build_info()["flags"]


def test_importing_the_package_loads_nothing():
    code = "import sys, mbproj.kernel; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert not {"numpy", NAME} & set(done.stdout.split())


def asks_for_a_kernel() -> bool:
    """As the installation reads it, see pyproject.toml."""
    return os.environ.get("MBPROJ_KERNEL", "").lower() in ("1", "yes", "on", "true")


@pytest.mark.skipif(not asks_for_a_kernel(), reason="MBPROJ_KERNEL does not ask for a kernel")
def test_a_kernel_that_the_environment_asks_for_is_there():
    assert kernel.core() is not None, kernel.build_info()
